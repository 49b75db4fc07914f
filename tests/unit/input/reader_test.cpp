/// Field tables on a small struct: reading, messages, JSON Schema and reference page.
#include "input/reader.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "input/reference_writer.hpp"
#include "input/schema_writer.hpp"

using namespace fbi::input;

namespace {

enum class Color { red, blue };

struct Leg {
  double length = 0.0;
};

struct Table {
  double height = 0.7;
  fbi::Index drawers = 2;
  bool round = false;
  std::string owner;
  Color color = Color::red;
  fbi::Vec3 place = fbi::Vec3::Zero();
  VectorExpression wind{};
  std::array<std::optional<Expression>, 3> partly{};
  std::optional<double> price;
  std::vector<Leg> legs;
};

void describe_leg(Visitor& v, Leg& p) {
  v.number(field("length", "length of a leg", "length").required("0.7"), p.length, positive());
}

void describe_table(Visitor& v, Table& p) {
  v.number(field("height", "height above the floor", "length"), p.height, positive());
  v.integer(field("drawers", "number of drawers"), p.drawers, between(0, 9));
  v.flag(field("round", "round or square"), p.round);
  v.text(field("owner", "who owns it").required("\"me\""), p.owner);
  v.choice<Color>(field("color", "its color"), p.color,
                  {{Color::red, "red", "like wine"}, {Color::blue, "blue", "like ice"}});
  v.vector(field("place", "where it stands"), p.place);
  v.formulas(field("wind", "how it blows"), p.wind);
  v.partial_formulas(field("partly", "how it partly blows").only("color", "blue", p.color == Color::blue), p.partly);
  v.optional_number(field("price", "what it costs"), p.price, at_least(0));
  v.list_of(field("legs", "its legs"), "Leg", p.legs, describe_leg);
}

std::string complaints_of(const std::string& text, Table& table) {
  std::vector<Complaint> complaints;
  const Node root = parse_document(text, complaints);
  Reader::read(
      root, [&](Visitor& v) { describe_table(v, table); }, complaints);
  std::string all;
  for (const Complaint& complaint : complaints) {
    all += std::to_string(complaint.position.column) + " " + complaint.text + "\n";
  }
  return all;
}

std::string complaints_of(const std::string& text) {
  Table table;
  return complaints_of(text, table);
}

}  // namespace

TEST(Reader, ReadsEveryKind) {
  Table table;
  EXPECT_EQ(
      complaints_of(
          R"({"height": "1/4", "drawers": 3, "round": "on", "owner": "x", "color": "blue", "place": [1, "2*pi", 3],
    "wind": ["x", 0, "t"], "partly": [null, 1, null], "price": 5, "legs": [{"length": 1}, {"length": 2}]})",
          table),
      "");
  EXPECT_EQ(table.height, 0.25);
  EXPECT_EQ(table.drawers, 3);
  EXPECT_TRUE(table.round);
  EXPECT_EQ(table.owner, "x");
  EXPECT_EQ(table.color, Color::blue);
  EXPECT_DOUBLE_EQ(table.place[1], 6.283185307179586);
  EXPECT_EQ(table.wind[0](4, 0, 0, 0), 4.0);
  EXPECT_FALSE(table.partly[0].has_value());
  EXPECT_EQ((*table.partly[1])(0, 0, 0, 0), 1.0);
  EXPECT_EQ(table.price, 5.0);
  ASSERT_EQ(table.legs.size(), 2u);
  EXPECT_EQ(table.legs[1].length, 2.0);
}

TEST(Reader, KeepsDefaults) {
  Table table;
  EXPECT_EQ(complaints_of(R"({"owner": "x"})", table), "");
  EXPECT_EQ(table.height, 0.7);
  EXPECT_EQ(table.drawers, 2);
  EXPECT_FALSE(table.price.has_value());
}

TEST(Reader, ReportsAllAtOnce) {
  EXPECT_EQ(complaints_of(R"({"hight": 1, "drawers": 2.5, "color": "bleu", "legs": [{}, 3]})"),
            "25 drawers: must be a whole number, not 2.5\n"
            "39 color: unknown value \"bleu\"; did you mean \"blue\"?\n"
            "56 legs[0]: missing key \"length\"; add for example \"length\": 0.7\n"
            "60 legs[1]: must be an object {...}, not the number 3\n"
            "2 unknown key \"hight\"; did you mean \"height\"?\n"
            "1 missing key \"owner\"; add for example \"owner\": \"me\"\n");
}

TEST(Reader, DoesNotMissWhatIsMisspelt) {
  EXPECT_EQ(complaints_of(R"({"onwer": "x"})"), "2 unknown key \"onwer\"; did you mean \"owner\"?\n");
}

TEST(Reader, ExplainsWrongTypesAndRanges) {
  EXPECT_EQ(complaints_of(R"({"owner": 1})"), "11 owner: must be text in quotes, not the number 1\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "height": true})"), "26 height: must be a number, not true\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "height": "2-2"})"), "26 height: must be above 0, not \"2-2\" = 0\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "height": "x"})"),
            "26 height: \"x\" must be constant: x, y, z and t have no value here\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "height": "1/0"})"), "26 height: must be finite, but \"1/0\" is not\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "drawers": 10})"),
            "27 drawers: must be at least 0 and at most 9, not 10\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "round": 1})"), "25 round: must be true or false, not the number 1\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "place": [1, 2]})"),
            "25 place: must be a list of 3 numbers [x, y, z], not a list of 2\n");
  EXPECT_EQ(
      complaints_of(R"({"owner": "x", "wind": [1, "u", null]})"),
      "28 wind[1]: formula \"u\": unknown name \"u\" at position 1; known are x, y, z, t, pi, e and functions such as "
      "sin, cos, exp, ln, sqrt, min, max\n"
      "33 wind[2]: must be a number or a formula of x, y, z, t as text, not null\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "color": "green"})"),
            "25 color: unknown value \"green\"; choose \"red\" or \"blue\"\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "partly": [1, 2, 3]})"), "26 partly: only for color blue; remove it\n");
  EXPECT_EQ(complaints_of(R"({"owner": "x", "colour": "red"})"),
            "16 unknown key \"colour\"; did you mean \"color\"?\n");
}

TEST(Writers, ShowTheSameTable) {
  Table table;
  const auto describe = [&](Visitor& v) { describe_table(v, table); };
  const nlohmann::json schema = nlohmann::json::parse(json_schema("Table", describe));
  EXPECT_EQ(schema["required"], nlohmann::json({"owner"}));
  EXPECT_EQ(schema["additionalProperties"], false);
  EXPECT_EQ(schema["properties"]["height"]["default"], 0.7);
  EXPECT_EQ(schema["properties"]["height"]["exclusiveMinimum"], 0.0);
  EXPECT_EQ(schema["properties"]["color"]["enum"], nlohmann::json({"red", "blue"}));
  EXPECT_EQ(schema["properties"]["legs"]["items"]["$ref"], "#/$defs/Leg");
  EXPECT_EQ(schema["$defs"]["Leg"]["required"], nlohmann::json({"length"}));
  const std::string page = reference_page("Table", describe);
  EXPECT_NE(page.find("| `height` | number > 0 | `0.7` | height above the floor [length] |"), std::string::npos)
      << page;
  EXPECT_NE(page.find("## Leg\n"), std::string::npos);
}
