#include "input/reference_writer.hpp"

#include <cmath>
#include <set>
#include <utility>

#include "input/suggest.hpp"

namespace fbi::input {
namespace {

std::string anchor(const std::string& title) {
  std::string text;
  for (const char c : title) text += c == ' ' ? '-' : static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return "[" + title + "](#" + text + ")";
}

class ReferenceWriter final : public Visitor {
 public:
  /// Writes the section of one kind of object, then those of the kinds first met in it.
  void section(const std::string& title, const Describe& describe) {
    const std::string outer_rows = std::exchange(rows_, "");
    const std::string outer_following = std::exchange(following_, "");
    describe(*this);
    const std::string text =
        "## " + title + "\n\n| key | value | default | meaning |\n|---|---|---|---|\n" + rows_ + "\n" + following_;
    rows_ = outer_rows;
    following_ = outer_following + text;
  }
  const std::string& text() const { return following_; }

  void flag(const Field& f, bool& value) override { row(f, "true or false", value ? "`true`" : "`false`"); }
  void number(const Field& f, double& value, const Range& range) override {
    row(f, "number" + bounds(range), code(number_text(value)));
  }
  void number_or_word(const Field& f, double& value, bool& /*is_word*/, const Range& range, const Word& word) override {
    row(f, "number" + bounds(range) + "<br>`\"" + word.name + "\"` " + word.meaning, code(number_text(value)));
  }
  void integer(const Field& f, Index& value, const Range& range) override {
    row(f, "whole number" + bounds(range), code(std::to_string(value)));
  }
  void text(const Field& f, std::string&) override { row(f, "text", ""); }
  void pair(const Field& f, std::array<double, 2>& value, const Range& range) override {
    row(f, "2 numbers" + bounds(range), code("[" + number_text(value[0]) + ", " + number_text(value[1]) + "]"));
  }
  void texts(const Field& f, std::vector<std::string>&) override { row(f, "list of texts", ""); }
  void vector(const Field& f, Vec3& value, const Range& range) override {
    row(f, "3 numbers" + bounds(range), three(number_text(value[0]), number_text(value[1]), number_text(value[2])));
  }
  void integers(const Field& f, std::array<Index, 3>& value, const Range& range) override {
    row(f, "3 whole numbers" + bounds(range),
        three(std::to_string(value[0]), std::to_string(value[1]), std::to_string(value[2])));
  }
  void vectors(const Field& f, std::vector<Vec3>&) override { row(f, "list of 3 numbers each", ""); }
  void formula(const Field& f, Expression& value) override { row(f, "formula", code(value.text())); }
  void formulas(const Field& f, VectorExpression& value) override {
    row(f, "3 formulas", three(value[0].text(), value[1].text(), value[2].text()));
  }
  void partial_formulas(const Field& f, std::array<std::optional<Expression>, 3>&) override {
    row(f, "3 formulas or `null`", "");
  }
  void word(const Field& f, std::size_t& chosen, const std::vector<Word>& words) override {
    std::string value;
    for (const Word& candidate : words) {
      value += (value.empty() ? "`\"" : "<br>`\"") + candidate.name + "\"`";
      if (!candidate.meaning.empty()) value += " " + candidate.meaning;
    }
    row(f, value, chosen == no_word ? "" : code("\"" + words[chosen].name + "\""));
  }
  void object(const Field& f, const std::string& title, const Describe& describe) override {
    row(f, "object: " + anchor(title), "");
    follow(title, describe);
  }
  void named(const Field& f, const std::string& title,
             const std::function<void(Visitor&, const std::string&)>& describe) override {
    row(f, "object by names of your own: each " + anchor(title), "");
    follow(title, [&](Visitor& v) { describe(v, "NAME"); });
  }
  void list(const Field& f, const std::string& title, const Describe& add) override {
    row(f, "list of objects: " + anchor(title), "");
    follow(title, add);
  }

 private:
  void follow(const std::string& title, const Describe& describe) {
    if (titles_.insert(title).second) section(title, describe);
  }
  static std::string code(const std::string& text) {
    std::string quoted = "`";
    quoted += text;
    quoted += "`";
    return quoted;
  }
  static std::string three(const std::string& x, const std::string& y, const std::string& z) {
    std::string list = "[";
    for (const std::string* item : {&x, &y, &z}) {
      if (item != &x) list += ", ";
      list += *item;
    }
    list += "]";
    return code(list);
  }
  static std::string bounds(const Range& range) {
    std::string text;
    if (std::isfinite(range.min)) text += (range.without_min ? " > " : " >= ") + number_text(range.min);
    if (std::isfinite(range.max)) text += (text.empty() ? " <= " : ", <= ") + number_text(range.max);
    return text;
  }
  void row(const Field& f, const std::string& value, const std::string& default_text) {
    std::string meaning = f.meaning;
    if (!f.unit.empty()) meaning += " [" + f.unit + "]";
    if (!f.only_key.empty()) meaning += "; only for `" + f.only_key + "` " + f.only_value;
    std::string shown = f.is_required ? "required" : f.has_default ? default_text : "";
    const std::string cells[] = {"`" + f.key + "`", value, shown, meaning};
    for (const std::string& cell : cells) {
      rows_ += "| ";
      for (const char c : cell) rows_ += c == '|' ? std::string("\\|") : std::string(1, c);
      rows_ += " ";
    }
    rows_ += "|\n";
  }

  std::string rows_;
  std::string following_;
  std::set<std::string> titles_;
};

}  // namespace

std::string reference_page(const std::string& title, const Visitor::Describe& describe) {
  ReferenceWriter writer;
  writer.section(title, describe);
  return writer.text();
}

}  // namespace fbi::input
