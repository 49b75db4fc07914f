/// Two inputs are the same when they differ only in what is left out.
#include "input/canonical.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace fbi::input {
namespace {

TEST(Canonical, ignores_layout_comments_order_and_what_is_left_out) {
  const std::vector<std::string> left_out = {"/title", "/time/end", "/absent/key"};
  const std::string one = R"({"title": "a", "time": {"step": 1e-3, "end": 1}, "x": [1, 2]} // remark)";
  const std::string other = R"({ "x":[1,2], "time":{"end":7,"step":0.001} })";
  EXPECT_EQ(canonical_text(one, left_out), canonical_text(other, left_out));
  EXPECT_NE(canonical_text(one, {"/title"}), canonical_text(other, {"/title"}));
  EXPECT_NE(canonical_text(one, left_out), canonical_text(R"({"x":[2,1],"time":{"step":0.001}})", left_out));
}

TEST(Canonical, refuses_what_is_not_json) { EXPECT_THROW(canonical_text("{", {}), std::invalid_argument); }

}  // namespace
}  // namespace fbi::input
