#include "input/expression.hpp"

#include <muParser.h>

#include <cctype>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include "input/float_traps.hpp"
#include "input/suggest.hpp"

namespace fbi::input {

struct Expression::Parser {
  mu::Parser parser;
  double x = 0.0, y = 0.0, z = 0.0, t = 0.0;
};

namespace {

/// A lone "=" would assign to x, y, z or t: only comparisons may hold that sign.
void refuse_assignment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
      continue;
    }
    if (i > 0 && (text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!')) continue;
    throw std::invalid_argument("\"=\" at position " + std::to_string(i + 1) + "; a comparison is written \"==\"");
  }
}

bool is_name(const std::string& token) {
  return !token.empty() && (std::isalpha(static_cast<unsigned char>(token[0])) || token[0] == '_');
}

[[noreturn]] void fail(const mu::Parser& parser, const mu::Parser::exception_type& error) {
  std::string token = error.GetToken();
  const std::string position = " at position " + std::to_string(error.GetPos() + 1);
  if (error.GetCode() == mu::ecUNASSIGNABLE_TOKEN && is_name(token)) {
    token = token.substr(0, token.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ_0123456789"));
    std::vector<std::string> known = {"x", "y", "z", "t", "pi", "e"};
    for (const auto& function : parser.GetFunDef()) known.push_back(function.first);
    std::string hint = did_you_mean(token, known);
    if (hint.empty()) hint = "; known are x, y, z, t, pi, e and functions such as sin, cos, exp, ln, sqrt, min, max";
    throw std::invalid_argument("unknown name \"" + token + "\"" + position + hint);
  }
  switch (error.GetCode()) {
    case mu::ecUNEXPECTED_EOF:
      throw std::invalid_argument("ends too early");
    case mu::ecMISSING_PARENS:
      throw std::invalid_argument("a closing \")\" is missing");
    case mu::ecEMPTY_EXPRESSION:
      throw std::invalid_argument("is empty");
    case mu::ecTOO_MANY_PARAMS:
      throw std::invalid_argument("too many arguments for \"" + token + "\"" + position);
    case mu::ecTOO_FEW_PARAMS:
      throw std::invalid_argument("too few arguments for \"" + token + "\"" + position);
    case mu::ecMISPLACED_COLON:
    case mu::ecMISSING_ELSE_CLAUSE:
      throw std::invalid_argument("a choice is written \"condition ? a : b\"");
    default:
      if (token.empty()) throw std::invalid_argument("cannot be understood" + position);
      throw std::invalid_argument("unexpected \"" + token + "\"" + position);
  }
}

}  // namespace

Expression::Expression(double value) : text_(number_text(value)), constant_(value) {}

Expression::Expression(const std::string& text) : text_(text) {
  const FloatTrapsOff traps_off;
  if (text.find_first_not_of(" \t\n\r") == std::string::npos) throw std::invalid_argument("is empty");
  refuse_assignment(text);
  parser_ = std::make_unique<Parser>();
  mu::Parser& parser = parser_->parser;
  try {
    parser.ClearConst();
    parser.DefineConst("pi", std::numbers::pi);
    parser.DefineConst("e", std::numbers::e);
    parser.DefineVar("x", &parser_->x);
    parser.DefineVar("y", &parser_->y);
    parser.DefineVar("z", &parser_->z);
    parser.DefineVar("t", &parser_->t);
    parser.SetExpr(text);
    const double value = parser.Eval();
    if (parser.GetNumResults() != 1) throw std::invalid_argument("gives several values; one is expected");
    uses_time_ = uses_space_ = false;
    for (const auto& variable : parser.GetUsedVar()) (variable.first == "t" ? uses_time_ : uses_space_) = true;
    if (!uses_time_ && !uses_space_) {
      constant_ = value;
      parser_.reset();
    } else {
      // Looking for the used variables resets the compiled form; compile it again here rather than at the first use.
      parser.Eval();
    }
  } catch (const mu::Parser::exception_type& error) {
    fail(parser, error);
  }
}

Expression::Expression(const Expression& other)
    : text_(other.text_), constant_(other.constant_), uses_time_(other.uses_time_), uses_space_(other.uses_space_) {
  // The compiled form points at its own variables, so a copy compiles the text again.
  if (other.parser_) *this = Expression(other.text_);
}

Expression& Expression::operator=(const Expression& other) {
  if (this != &other) *this = Expression(other);
  return *this;
}

Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

double Expression::operator()(double x, double y, double z, double t) const {
  if (!parser_) return constant_;
  const FloatTrapsOff traps_off;
  parser_->x = x;
  parser_->y = y;
  parser_->z = z;
  parser_->t = t;
  return parser_->parser.Eval();
}

bool Expression::is_constant() const { return !parser_; }
bool Expression::depends_on_time() const { return uses_time_; }
bool Expression::depends_on_space() const { return uses_space_; }
bool Expression::is_zero() const { return !parser_ && constant_ == 0.0; }

}  // namespace fbi::input
