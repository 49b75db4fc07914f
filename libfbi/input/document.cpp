#include "input/document.hpp"

#include <nlohmann/json.hpp>

#include "input/float_traps.hpp"
#include "input/suggest.hpp"

namespace fbi::input {
namespace {

using Json = nlohmann::json;

constexpr std::size_t max_depth = 64;

/// Walks over the tokens of a text in step with the parser's events, which come in the order of the text; it so learns
/// where each token begins although the parser reads ahead.
class TokenCursor {
 public:
  explicit TokenCursor(const std::string& text) : text_(text) {
    if (text_.compare(0, 3, "\xEF\xBB\xBF") == 0) offset_ = 3;
  }

  /// Position of the next token (a bracket, a string, a number or a word); moves behind it.
  Position next() {
    const Position position = skip_to_token();
    if (offset_ >= text_.size()) return position;
    const char first = text_[offset_];
    advance();
    if (first == '"') {
      while (offset_ < text_.size() && text_[offset_] != '"') {
        if (text_[offset_] == '\\') advance();
        advance();
      }
      advance();
    } else if (std::string("{}[]").find(first) == std::string::npos) {
      while (offset_ < text_.size() && std::string("{}[],:/ \t\r\n").find(text_[offset_]) == std::string::npos)
        advance();
    }
    return position;
  }

  /// Start of the token that ends at `offset` or later (or one before it: the parser notices an unknown word at the
  /// character that follows), else the place just before `offset`. For a new cursor.
  Position token_before(std::size_t offset, bool unknown_word) {
    while (true) {
      const Position place = skip_to_token(offset > 0 ? offset - 1 : 0);
      if (offset_ + 1 >= offset || offset_ >= text_.size()) return place;
      const bool word = std::string("{}[]\"").find(text_[offset_]) == std::string::npos;
      next();
      if (offset_ + (word && unknown_word ? 1 : 0) >= offset) return place;
    }
  }

 private:
  void advance() {
    if (offset_ >= text_.size()) return;
    const unsigned char c = static_cast<unsigned char>(text_[offset_++]);
    if (c == '\n') {
      ++line_;
      column_ = 1;
    } else if ((c & 0xC0) != 0x80) {  // continuation bytes of UTF-8 take no column
      ++column_;
    }
  }

  /// Moves over blanks, comments, commas and colons, but not beyond `limit`.
  Position skip_to_token(std::size_t limit = std::string::npos) {
    while (offset_ < text_.size() && offset_ < limit) {
      if (text_.compare(offset_, 2, "//") == 0) {
        while (offset_ < text_.size() && text_[offset_] != '\n') advance();
      } else if (text_.compare(offset_, 2, "/*") == 0) {
        while (offset_ < text_.size() && text_.compare(offset_, 2, "*/") != 0) advance();
        advance();
        advance();
      } else if (std::string(" \t\r\n,:").find(text_[offset_]) != std::string::npos) {
        advance();
      } else {
        break;
      }
    }
    return {line_, column_};
  }

  const std::string& text_;
  std::size_t offset_ = 0;
  int line_ = 1;
  int column_ = 1;
};

/// Builds the tree from the parser's events.
class TreeBuilder {
 public:
  TreeBuilder(const std::string& text, std::vector<Complaint>& complaints)
      : text_(text), cursor_(text), complaints_(complaints) {}

  Node take() { return std::move(root_); }

  bool null() { return add(Node::Kind::null, nullptr); }
  bool boolean(bool value) {
    return add(Node::Kind::boolean, [&](Node& node) { node.boolean = value; });
  }
  bool number_integer(Json::number_integer_t value) {
    return number(static_cast<double>(value), std::to_string(value));
  }
  bool number_unsigned(Json::number_unsigned_t value) {
    return number(static_cast<double>(value), std::to_string(value));
  }
  bool number_float(Json::number_float_t value, const Json::string_t& text) { return number(value, text); }
  bool string(Json::string_t& value) {
    return add(Node::Kind::text, [&](Node& node) { node.text = value; });
  }
  bool binary(Json::binary_t&) { return false; }

  bool start_object(std::size_t) { return open(Node::Kind::object); }
  bool end_object() { return close(); }
  bool start_array(std::size_t) { return open(Node::Kind::list); }
  bool end_array() { return close(); }

  bool key(Json::string_t& name) {
    const Position position = cursor_.next();
    Node& object = *open_.back();
    if (const Node::Member* first = object.find(name)) {
      complaints_.push_back({position, "key \"" + name + "\" given twice; it was first given in line " +
                                           std::to_string(first->position.line)});
    }
    object.members.push_back({name, position, {}});
    return true;
  }

  bool parse_error(std::size_t offset, const std::string& /*last_token*/, const Json::exception& error) {
    std::string what = error.what();
    // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while parsing value - unexpected
    // ..."
    if (const std::size_t detail = what.find(" - "); detail != std::string::npos) {
      what = what.substr(detail + 3);
    } else if (const std::size_t bracket = what.find("] "); bracket != std::string::npos) {
      what = what.substr(bracket + 2);
    }
    if (what.find("unexpected '}'; expected string literal") != std::string::npos ||
        what.find("unexpected ']'; expected '['") != std::string::npos) {
      what += "; is there a comma too many before it?";
    }
    // What was read last may be long and hold control characters.
    if (const std::size_t begin = what.find("; last read: "); begin != std::string::npos) {
      const std::size_t end = what.find("; expected", begin);
      what.erase(begin, end == std::string::npos ? std::string::npos : end - begin);
    }
    complaints_.push_back(
        {TokenCursor(text_).token_before(offset, what.find("invalid literal") == 0), "not valid JSON: " + what});
    return false;
  }

 private:
  bool number(double value, const std::string& text) {
    return add(Node::Kind::number, [&](Node& node) {
      node.number = value;
      node.text = text;
    });
  }

  Node& place() {
    if (open_.empty()) return root_;
    Node& parent = *open_.back();
    if (parent.kind == Node::Kind::object) return parent.members.back().value;
    return parent.items.emplace_back();
  }

  template <class Fill>
  bool add(Node::Kind kind, Fill fill) {
    const Position position = cursor_.next();
    Node& node = place();
    node.kind = kind;
    node.position = position;
    if constexpr (!std::is_null_pointer_v<Fill>) fill(node);
    return true;
  }

  bool open(Node::Kind kind) {
    const Position position = cursor_.next();
    if (open_.size() == max_depth) {
      complaints_.push_back({position, "nested too deeply"});
      return false;
    }
    Node& node = place();
    node.kind = kind;
    node.position = position;
    open_.push_back(&node);
    return true;
  }

  bool close() {
    cursor_.next();
    open_.pop_back();
    return true;
  }

  const std::string& text_;
  TokenCursor cursor_;
  std::vector<Complaint>& complaints_;
  Node root_;
  std::vector<Node*> open_;  // stays valid: a list or object grows only while it is the innermost open one
};

}  // namespace

const Node::Member* Node::find(const std::string& key) const {
  for (const Member& member : members) {
    if (member.key == key) return &member;
  }
  return nullptr;
}

std::string Node::description() const {
  switch (kind) {
    case Kind::null:
      return "null";
    case Kind::boolean:
      return boolean ? "true" : "false";
    case Kind::number:
      return "the number " + text;
    case Kind::text:
      return "the text \"" + (text.size() > 40 ? text.substr(0, 37) + "..." : text) + "\"";
    case Kind::list:
      return "a list of " + std::to_string(items.size());
    case Kind::object:
      return "an object {...}";
  }
  return "";
}

Node parse_document(const std::string& text, std::vector<Complaint>& complaints) {
  const FloatTrapsOff traps_off;  // a number such as 1e999 overflows while it is read
  TreeBuilder builder(text, complaints);
  const bool good = Json::sax_parse(text.begin(), text.end(), &builder, Json::input_format_t::json, true, true);
  return good ? builder.take() : Node{};
}

}  // namespace fbi::input
