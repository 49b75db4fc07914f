#include "input/schema_writer.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace fbi::input {
namespace {

using Json = nlohmann::ordered_json;

class SchemaWriter final : public Visitor {
 public:
  explicit SchemaWriter(Json& definitions) : definitions_(definitions) {}

  Json object_schema(const Describe& describe) {
    const Json outer_properties = std::exchange(properties_, Json::object());
    const Json outer_required = std::exchange(required_, Json::array());
    describe(*this);
    Json schema = {{"type", "object"}, {"properties", properties_}, {"additionalProperties", false}};
    if (!required_.empty()) schema["required"] = required_;
    properties_ = outer_properties;
    required_ = outer_required;
    return schema;
  }

  void flag(const Field& f, bool& value) override {
    Json schema = {{"enum", {true, false, "on", "off"}}};
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void number(const Field& f, double& value, const Range& range) override {
    Json schema = number_schema(range);
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void number_or_word(const Field& f, double& value, bool& /*is_word*/, const Range& range, const Word& word) override {
    Json schema = {{"anyOf", Json::array({{{"const", word.name}}, number_schema(range)})}};
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void integer(const Field& f, Index& value, const Range& range) override {
    Json schema = number_schema(range, "integer");
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void text(const Field& f, std::string&) override { add(f, {{"type", "string"}}); }
  void pair(const Field& f, std::array<double, 2>& value, const Range& range) override {
    Json schema = {{"type", "array"}, {"items", number_schema(range)}, {"minItems", 2}, {"maxItems", 2}};
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void texts(const Field& f, std::vector<std::string>&) override {
    add(f, {{"type", "array"}, {"items", {{"type", "string"}}}});
  }
  void vector(const Field& f, Vec3& value, const Range& range) override {
    Json schema = three(number_schema(range));
    if (f.has_default && !f.is_required) schema["default"] = {value[0], value[1], value[2]};
    add(f, schema);
  }
  void integers(const Field& f, std::array<Index, 3>& value, const Range& range) override {
    Json schema = three(number_schema(range, "integer"));
    if (f.has_default && !f.is_required) schema["default"] = value;
    add(f, schema);
  }
  void vectors(const Field& f, std::vector<Vec3>&) override {
    add(f, {{"type", "array"}, {"items", three(number_schema(any_number()))}});
  }
  void formula(const Field& f, Expression&) override { add(f, {{"type", {"number", "string"}}}); }
  void formulas(const Field& f, VectorExpression&) override { add(f, three({{"type", {"number", "string"}}})); }
  void partial_formulas(const Field& f, std::array<std::optional<Expression>, 3>&) override {
    add(f, three({{"type", {"number", "string", "null"}}}));
  }
  void word(const Field& f, std::size_t& chosen, const std::vector<Word>& words) override {
    Json schema = {{"enum", Json::array()}};
    for (const Word& candidate : words) schema["enum"].push_back(candidate.name);
    if (f.has_default && !f.is_required && chosen != no_word) schema["default"] = words[chosen].name;
    add(f, schema);
  }
  void object(const Field& f, const std::string& title, const Describe& describe) override {
    add(f, {{"$ref", definition(title, describe)}});
  }
  void named(const Field& f, const std::string& title,
             const std::function<void(Visitor&, const std::string&)>& describe) override {
    const std::string reference = definition(title, [&](Visitor& v) { describe(v, "NAME"); });
    add(f, {{"type", "object"}, {"additionalProperties", {{"$ref", reference}}}});
  }
  void list(const Field& f, const std::string& title, const Describe& add_item) override {
    add(f, {{"type", "array"}, {"items", {{"$ref", definition(title, add_item)}}}});
  }

 private:
  static Json number_schema(const Range& range, const char* type = "number") {
    Json schema = {{"type", {type, "string"}}};
    if (std::isfinite(range.min)) schema[range.without_min ? "exclusiveMinimum" : "minimum"] = range.min;
    if (std::isfinite(range.max)) schema["maximum"] = range.max;
    return schema;
  }
  static Json three(const Json& items) {
    return {{"type", "array"}, {"items", items}, {"minItems", 3}, {"maxItems", 3}};
  }

  std::string definition(const std::string& title, const Describe& describe) {
    std::string name;
    for (const char c : title) name += c == ' ' ? '_' : c;
    if (!definitions_.contains(name)) {
      definitions_[name] = nullptr;  // keeps its place
      Json schema = object_schema(describe);
      definitions_[name] = schema;
    }
    return "#/$defs/" + name;
  }

  void add(const Field& f, Json schema) {
    std::string meaning = f.meaning;
    if (!f.unit.empty()) meaning += " [" + f.unit + "]";
    if (!f.only_key.empty()) meaning += " (" + f.only_key + " " + f.only_value + ")";
    schema["description"] = meaning;
    properties_[f.key] = schema;
    if (f.is_required && f.only_key.empty()) required_.push_back(f.key);
  }

  Json& definitions_;
  Json properties_ = Json::object();
  Json required_ = Json::array();
};

}  // namespace

std::string json_schema(const std::string& title, const Visitor::Describe& describe) {
  Json definitions = Json::object();
  SchemaWriter writer(definitions);
  Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
  schema.update(writer.object_schema(describe));
  schema["$defs"] = definitions;
  return schema.dump(2) + "\n";
}

}  // namespace fbi::input
