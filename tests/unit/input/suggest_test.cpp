/// "did you mean".
#include "input/suggest.hpp"

#include <gtest/gtest.h>

using namespace fbi::input;

TEST(Suggest, CountsEdits) {
  EXPECT_EQ(edit_distance("length", "length"), 0);
  EXPECT_EQ(edit_distance("lenght", "length"), 1);  // a swap
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
}

TEST(Suggest, FindsTheNearestWord) {
  const std::vector<std::string> known = {"length", "radius", "area"};
  EXPECT_EQ(nearest_word("lenght", known), "length");
  EXPECT_EQ(nearest_word("RADIUS", known), "radius");
  EXPECT_EQ(nearest_word("density", known), "");
  EXPECT_EQ(did_you_mean("lenght", known), "; did you mean \"length\"?");
  EXPECT_EQ(did_you_mean("qqq", known), "");
}

TEST(Suggest, ListsWords) {
  EXPECT_EQ(list_text({"a"}), "a");
  EXPECT_EQ(list_text({"a", "b", "c"}), "a, b or c");
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(3.0), "3");
}
