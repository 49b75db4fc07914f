/// A number or a formula of x, y, z and t, as it stands in an input file.
#pragma once

#include <array>
#include <memory>
#include <string>

#include "base/types.hpp"

namespace fbi::input {

/// A scalar field f(x, y, z, t) given by a number or by text such as "100*y*(2-y)*sin(pi*t)".
///
/// Known names: x, y, z, t, pi, e and the functions of muParser (sin, cos, tan, exp, ln, log10, sqrt, abs, min, max, sign, ...,
/// and "condition ? a : b"). Copying shares nothing: each copy may be evaluated independently.
class Expression {
 public:
  Expression() : Expression(0.0) {}
  Expression(double value);  // NOLINT: a number is an expression
  /// Parses `text`. Throws std::invalid_argument with a message that names the position or the unknown name.
  explicit Expression(const std::string& text);
  Expression(const Expression& other);
  Expression& operator=(const Expression& other);
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;
  ~Expression();

  /// Value at the point (x, y, z) and time t; may be non-finite where the formula is.
  double operator()(double x, double y, double z, double t) const;
  double operator()(const Vec3& x, double t) const { return (*this)(x[0], x[1], x[2], t); }

  /// True for a number, or a formula without x, y, z, t.
  bool is_constant() const;
  bool depends_on_time() const;
  bool depends_on_space() const;
  /// True when it is the constant 0.
  bool is_zero() const;
  /// The text as given, or the number printed so that it reads back exactly.
  const std::string& text() const { return text_; }

 private:
  struct Parser;
  std::string text_;
  double constant_ = 0.0;
  std::unique_ptr<Parser> parser_;  // empty for a constant
  bool uses_time_ = false;
  bool uses_space_ = false;
};

/// Three components of a vector field.
using VectorExpression = std::array<Expression, 3>;

}  // namespace fbi::input
