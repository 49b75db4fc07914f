/// Positions of keys and values, and messages about broken JSON.
#include "input/document.hpp"

#include <gtest/gtest.h>

using namespace fbi::input;

namespace {

std::string place(const Position& position) {
  return std::to_string(position.line) + ":" + std::to_string(position.column);
}

Node parse(const std::string& text) {
  std::vector<Complaint> complaints;
  Node node = parse_document(text, complaints);
  EXPECT_TRUE(complaints.empty());
  return node;
}

std::string complaint(const std::string& text) {
  std::vector<Complaint> complaints;
  parse_document(text, complaints);
  return complaints.empty() ? "none" : place(complaints[0].position) + ": " + complaints[0].text;
}

}  // namespace

TEST(Document, KnowsWhereEverythingStands) {
  const Node root = parse(
      "// first line: { \"no\": 1 }\n"
      "{ \"one\": 1.5, /* two, \"x\" */ \"two\": [true, null,\n"
      "    \"a \\\" b\"],\n"
      "\t\"three\" : { \"four\":-2 } }");
  EXPECT_EQ(place(root.position), "2:1");
  ASSERT_EQ(root.members.size(), 3u);
  EXPECT_EQ(place(root.members[0].position), "2:3");
  EXPECT_EQ(place(root.members[0].value.position), "2:10");
  EXPECT_EQ(root.members[0].value.number, 1.5);
  EXPECT_EQ(place(root.members[1].position), "2:30");
  const Node& list = root.members[1].value;
  ASSERT_EQ(list.items.size(), 3u);
  EXPECT_EQ(place(list.position), "2:37");
  EXPECT_EQ(place(list.items[0].position), "2:38");
  EXPECT_EQ(place(list.items[1].position), "2:44");
  EXPECT_EQ(place(list.items[2].position), "3:5");
  EXPECT_EQ(list.items[2].text, "a \" b");
  EXPECT_EQ(place(root.members[2].position), "4:2");
  const Node& four = root.members[2].value.members[0].value;
  EXPECT_EQ(place(four.position), "4:21");
  EXPECT_EQ(four.number, -2.0);
}

TEST(Document, CountsCharactersNotBytes) {
  const Node root = parse("{\"\xC3\xA4\xE2\x82\xAC\": \"\xC3\xA4\", \"b\": 1}");
  EXPECT_EQ(place(root.members[0].value.position), "1:8");
  EXPECT_EQ(place(root.members[1].position), "1:13");
}

TEST(Document, SkipsAByteOrderMark) { EXPECT_EQ(place(parse("\xEF\xBB\xBF{}").position), "1:1"); }

TEST(Document, RefusesKeysGivenTwice) {
  EXPECT_EQ(complaint("{ \"a\": 1,\n  \"a\": 2 }"), "2:3: key \"a\" given twice; it was first given in line 1");
}

TEST(Document, PlacesSyntaxErrors) {
  EXPECT_EQ(complaint("{ \"a\": 1, }"),
            "1:11: not valid JSON: unexpected '}'; expected string literal; is there a comma too many before it?");
  EXPECT_EQ(complaint("{ \"a\": tru }"), "1:8: not valid JSON: invalid literal");
  EXPECT_EQ(complaint("{ \"a\": 1 \"b\": 2 }"), "1:10: not valid JSON: unexpected string literal; expected '}'");
  EXPECT_EQ(complaint("{ \"a\": 1e999 }"), "1:8: not valid JSON: number overflow parsing '1e999'");
  EXPECT_EQ(complaint("{\n \"a\": [1, 2"), "2:12: not valid JSON: unexpected end of input; expected ']'");
  EXPECT_EQ(complaint("{} x"), "1:4: not valid JSON: invalid literal; expected end of input");
  EXPECT_EQ(complaint(""), "1:1: not valid JSON: unexpected end of input; expected '[', '{', or a literal");
}

TEST(Document, RefusesEndlessNesting) { EXPECT_EQ(complaint(std::string(100000, '[')), "1:65: nested too deeply"); }
