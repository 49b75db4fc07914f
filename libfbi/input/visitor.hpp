/// Field tables: one description of a parameter struct that parses it, validates it and documents it.
///
/// A table is a function `void describe(Visitor& v, Struct& p)` that names every key of the struct once, with its
/// meaning, unit, range and member. `Reader` fills the struct from a JSON object, `SchemaWriter` makes a JSON Schema,
/// `ReferenceWriter` a Markdown page of it. Defaults are the member initialisers of the struct.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "input/expression.hpp"

namespace fbi::input {

/// Admissible values of a number.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool without_min = false;  ///< the number must lie above min
};
inline Range any_number() { return {}; }
inline Range positive() { return {.min = 0.0, .without_min = true}; }
inline Range at_least(double min) { return {.min = min}; }
inline Range between(double min, double max) { return {.min = min, .max = max}; }

/// One key of an object: its name and meaning.
struct Field {
  std::string key;
  std::string meaning;  ///< half a sentence
  std::string unit;     ///< dimension in words, such as "mass/length^3"; may be empty
  bool is_required = false;
  bool has_default = true;  ///< false: nothing is assumed when the key is missing
  std::string example;      ///< JSON text shown where a required key is missing
  std::string only_key;     ///< the field goes with certain values of this key of the same object ...
  std::string only_value;   ///< ... named here in words ...
  bool only_holds = true;   ///< ... and this says whether it has one of them
  std::string only_hint;    ///< what to do instead

  Field& required(const std::string& sample = "") {
    is_required = true;
    example = sample;
    return *this;
  }
  Field& optional() {
    has_default = false;
    return *this;
  }
  /// The key makes sense (and, if required, is required) only when `holds`: where `of` has the value(s) `value`.
  Field& only(const std::string& of, const std::string& value, bool holds, const std::string& hint = "") {
    only_key = of;
    only_value = value;
    only_holds = holds;
    only_hint = hint;
    return *this;
  }
};
inline Field field(const std::string& key, const std::string& meaning, const std::string& unit = "") {
  Field result;
  result.key = key;
  result.meaning = meaning;
  result.unit = unit;
  return result;
}

/// One admissible word of a choice.
template <class T>
struct Option {
  T value;
  std::string name;
  std::string meaning;
};
struct Word {
  std::string name;
  std::string meaning;
};

/// What is done with a field table. Paths are those of the object being described: "radius", "section.radius",
/// "array.counts[0]".
class Visitor {
 public:
  static constexpr std::size_t no_word = static_cast<std::size_t>(-1);
  using Describe = std::function<void(Visitor&)>;

  virtual ~Visitor() = default;

  /// true or false, also "on" or "off".
  virtual void flag(const Field& f, bool& value) = 0;
  /// A number, or a constant formula as text.
  virtual void number(const Field& f, double& value, const Range& range = {}) = 0;
  /// A number, or one word that stands for something else.
  virtual void number_or_word(const Field& f, double& value, bool& is_word, const Range& range, const Word& word) = 0;
  virtual void integer(const Field& f, Index& value, const Range& range = {}) = 0;
  virtual void text(const Field& f, std::string& value) = 0;
  /// Two numbers.
  virtual void pair(const Field& f, std::array<double, 2>& value, const Range& range = {}) = 0;
  /// A list of texts.
  virtual void texts(const Field& f, std::vector<std::string>& value) = 0;
  /// Three numbers.
  virtual void vector(const Field& f, Vec3& value, const Range& range = {}) = 0;
  virtual void integers(const Field& f, std::array<Index, 3>& value, const Range& range = {}) = 0;
  /// A list of points of three numbers each.
  virtual void vectors(const Field& f, std::vector<Vec3>& values) = 0;
  /// A formula of x, y, z, t.
  virtual void formula(const Field& f, Expression& value) = 0;
  /// Three formulas of x, y, z, t.
  virtual void formulas(const Field& f, VectorExpression& value) = 0;
  /// Three formulas; null leaves a component out.
  virtual void partial_formulas(const Field& f, std::array<std::optional<Expression>, 3>& value) = 0;
  /// One word of a list; `chosen` is an index into `words`, or no_word for no default.
  virtual void word(const Field& f, std::size_t& chosen, const std::vector<Word>& words) = 0;
  /// An object of its own table; `title` names its kind, and two objects of one kind have one table.
  virtual void object(const Field& f, const std::string& title, const Describe& describe) = 0;
  /// An object whose keys the user chooses; each value is an object of kind `title`, described by describe(v, key).
  virtual void named(const Field& f, const std::string& title,
                     const std::function<void(Visitor&, const std::string&)>& describe) = 0;
  /// A list of objects; `add` appends one to the list and describes it.
  virtual void list(const Field& f, const std::string& title, const Describe& add) = 0;

  /// True when a file is being read; checks that go beyond one field are made only then.
  virtual bool reading() const { return false; }
  /// True when the file gives this path (right or wrong).
  virtual bool given(const std::string& /*path*/) const { return false; }
  /// True when the value at this path, or below it, could not be used.
  virtual bool failed(const std::string& /*path*/) const { return false; }
  /// Reports that a key of this object is missing, unless another key looks like a misspelling of it.
  virtual void missing(const std::string& /*key*/, const std::string& /*what*/) {}
  /// Reports an error at the path, or at the nearest object around it that exists.
  virtual void error(const std::string& /*path*/, const std::string& /*what*/) {}

  template <class T>
  void choice(const Field& f, T& value, const std::vector<Option<T>>& options) {
    std::vector<Word> words;
    std::size_t chosen = no_word;
    for (std::size_t i = 0; i < options.size(); ++i) {
      words.push_back({options[i].name, options[i].meaning});
      if (options[i].value == value) chosen = i;
    }
    word(f, chosen, words);
    if (chosen != no_word) value = options[chosen].value;
  }

  void optional_number(Field f, std::optional<double>& value, const Range& range = {}) {
    double number_given = 0.0;
    number(f.optional(), number_given, range);
    if (given(f.key)) value = number_given;
  }

  template <class T>
  void optional_object(Field f, const std::string& title, std::optional<T>& value, void (*describe)(Visitor&, T&)) {
    object(f.optional(), title, [&](Visitor& v) {
      value.emplace();
      describe(v, *value);
    });
  }

  template <class T>
  void list_of(Field f, const std::string& title, std::vector<T>& items, void (*describe)(Visitor&, T&)) {
    list(f.optional(), title, [&](Visitor& v) { describe(v, items.emplace_back()); });
  }
};

}  // namespace fbi::input
