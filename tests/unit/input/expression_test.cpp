/// Formulas: values, kinds, copies, messages, and no trap for finite results.
#include "input/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

using fbi::input::Expression;

namespace {

double value(const std::string& text, double x = 0, double y = 0, double z = 0, double t = 0) {
  return Expression(text)(x, y, z, t);
}

std::string message(const std::string& text) {
  try {
    const Expression expression(text);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace

TEST(Expression, KnowsVariablesConstantsAndFunctions) {
  EXPECT_DOUBLE_EQ(value("100*y*(2-y)", 0, 0.5), 75.0);
  EXPECT_DOUBLE_EQ(value("x + 10*y + 100*z + 1000*t", 1, 2, 3, 4), 4321.0);
  EXPECT_DOUBLE_EQ(value("sin(pi/6)"), 0.5);
  EXPECT_DOUBLE_EQ(value("ln(e)"), 1.0);
  EXPECT_DOUBLE_EQ(value("exp(1)"), std::numbers::e);
  EXPECT_DOUBLE_EQ(value("sqrt(2)^2"), 2.0000000000000004);
  EXPECT_DOUBLE_EQ(value("min(3, 1, 2) + max(4, 6)"), 7.0);
  EXPECT_DOUBLE_EQ(value("abs(-2) + sign(-3) + log10(100)"), 3.0);
  EXPECT_DOUBLE_EQ(value("-x^2", 3), -9.0);
  EXPECT_DOUBLE_EQ(value("2^3^2"), 512.0);
  EXPECT_DOUBLE_EQ(value("1.5e3"), 1500.0);
}

TEST(Expression, ChoosesByCondition) {
  const Expression ramp("t < 2 ? t/2 : 1");
  EXPECT_DOUBLE_EQ(ramp(0, 0, 0, 1), 0.5);
  EXPECT_DOUBLE_EQ(ramp(0, 0, 0, 5), 1.0);
  EXPECT_DOUBLE_EQ(value("x >= 1 && y != 2 ? 7 : 8", 1, 3), 7.0);
}

TEST(Expression, TellsWhatItDependsOn) {
  EXPECT_TRUE(Expression("10/226").is_constant());
  EXPECT_FALSE(Expression("10/226").is_zero());
  EXPECT_TRUE(Expression("0").is_zero());
  EXPECT_TRUE(Expression().is_zero());
  const Expression time("sin(pi*t)"), space("x*y"), both("z+t");
  EXPECT_TRUE(time.depends_on_time() && !time.depends_on_space() && !time.is_constant());
  EXPECT_TRUE(!space.depends_on_time() && space.depends_on_space() && !space.is_zero());
  EXPECT_TRUE(both.depends_on_time() && both.depends_on_space());
}

TEST(Expression, NumberPrintsExactly) {
  for (const double number : {0.1, 1.0 / 3.0, -2.5e-300, 1e22, 4.0}) {
    EXPECT_EQ(std::stod(Expression(number).text()), number);
    EXPECT_EQ(Expression(number)(1, 2, 3, 4), number);
  }
  EXPECT_EQ(Expression("1/3").text(), "1/3");
}

TEST(Expression, CopiesAreIndependent) {
  Expression copy;
  {
    const Expression original("x + t");
    copy = original;
    const Expression second = original;
    EXPECT_DOUBLE_EQ(second(1, 0, 0, 2), 3.0);
  }
  EXPECT_DOUBLE_EQ(copy(10, 0, 0, 20), 30.0);
  EXPECT_TRUE(copy.depends_on_time());
  const Expression moved = std::move(copy);
  EXPECT_DOUBLE_EQ(moved(1, 0, 0, 1), 2.0);
}

TEST(Expression, DoesNotTrap) {  // the tests run with floating-point traps on
  EXPECT_DOUBLE_EQ(value("exp(-1/x)", 0.0), 0.0);
  EXPECT_DOUBLE_EQ(value("exp(-1000*x)", 1.0), 0.0);
  EXPECT_DOUBLE_EQ(value("x > 0 ? ln(x) : 0", 0.0), 0.0);
  EXPECT_TRUE(std::isinf(value("1/x")));
  EXPECT_TRUE(std::isnan(value("sqrt(x)", -1)));
  EXPECT_TRUE(std::isinf(value("1/0")));
}

TEST(Expression, NamesWhatItDoesNotKnow) {
  EXPECT_EQ(message("2*sqr(y) + 1"), "unknown name \"sqr\" at position 3; did you mean \"sqrt\"?");
  EXPECT_EQ(message("4*sine(x)"), "unknown name \"sine\" at position 3; did you mean \"sin\"?");
  EXPECT_EQ(
      message("velocity*x"),
      "unknown name \"velocity\" at position 1; known are x, y, z, t, pi, e and functions such as sin, cos, exp, ln, "
      "sqrt, min, max");
}

TEST(Expression, ExplainsSyntaxErrors) {
  EXPECT_EQ(message(""), "is empty");
  EXPECT_EQ(message("  "), "is empty");
  EXPECT_EQ(message("2*"), "ends too early");
  EXPECT_EQ(message("(1+x"), "a closing \")\" is missing");
  EXPECT_EQ(message("x = 2"), "\"=\" at position 3; a comparison is written \"==\"");
  EXPECT_EQ(message("1, 2"), "gives several values; one is expected");
  EXPECT_EQ(message("x ? 1"), "a choice is written \"condition ? a : b\"");
  EXPECT_EQ(message("sin(1, 2)"), "too many arguments for \"sin\" at position 9");
  EXPECT_NE(message("1 + * 2").find("position 5"), std::string::npos);
}
