#include "input/reader.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "input/suggest.hpp"

namespace fbi::input {
namespace {

std::string join(const std::string& path, const std::string& key) { return path.empty() ? key : path + "." + key; }

std::string prefix(const std::string& path) { return path.empty() ? "" : path + ": "; }

}  // namespace

void Reader::read(const Node& root, const Describe& describe, std::vector<Complaint>& complaints) {
  Reader reader(complaints);
  if (root.kind != Node::Kind::object) {
    complaints.push_back({root.position, "must be an object {...}, not " + root.description()});
    return;
  }
  reader.read_object(root, "", describe);
}

void Reader::read_object(const Node& node, const std::string& path, const Describe& describe) {
  positions_[path] = node.position;
  for (const Node::Member& member : node.members) positions_.emplace(join(path, member.key), member.value.position);
  frames_.push_back({&node, path, {}, {}});
  describe(*this);
  const std::vector<std::string>& keys = frames_.back().keys;
  std::set<std::string> misspelt;
  for (const Node::Member& member : node.members) {
    if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
    const std::string nearest = nearest_word(member.key, keys);
    misspelt.insert(nearest);
    const std::string hint =
        nearest.empty() ? "; known here: " + list_text(keys) : "; did you mean \"" + nearest + "\"?";
    complaints_.push_back({member.position, prefix(path) + "unknown key \"" + member.key + "\"" + hint});
  }
  for (const auto& [key, what] : frames_.back().missing) {
    if (misspelt.count(key) == 0) complaints_.push_back({node.position, prefix(path) + what});
  }
  frames_.pop_back();
}

const Node* Reader::take(const Field& f, std::string& path) {
  Frame& frame = frames_.back();
  frame.keys.push_back(f.key);
  path = join(frame.path, f.key);
  const Node::Member* member = frame.node->find(f.key);
  const bool may_be_judged = f.only_key.empty() || !failed(f.only_key);
  if (!member) {
    if (f.is_required && f.only_holds && may_be_judged) {
      std::string what = "missing key \"" + f.key + "\"";
      if (!f.only_key.empty()) what += ", needed for " + f.only_key + " " + f.only_value;
      if (!f.example.empty()) what += "; add for example \"" + f.key + "\": " + f.example;
      missing(f.key, what);
    }
    return nullptr;
  }
  if (!f.only_holds && may_be_judged) {
    complain(member->value, path,
             "only for " + f.only_key + " " + f.only_value + "; " + (f.only_hint.empty() ? "remove it" : f.only_hint));
    return nullptr;
  }
  return &member->value;
}

const Node* Reader::take_list(const Field& f, std::string& path, std::size_t size, const char* of_what) {
  const Node* node = take(f, path);
  if (!node) return nullptr;
  if (node->kind == Node::Kind::list && node->items.size() == size) {
    for (std::size_t i = 0; i < size; ++i) positions_[path + "[" + std::to_string(i) + "]"] = node->items[i].position;
    return node;
  }
  complain(*node, path,
           "must be a list of " + std::to_string(size) + " " + of_what + (size == 3 ? " [x, y, z], not " : ", not ") +
               node->description());
  return nullptr;
}

void Reader::complain(const Node& node, const std::string& path, const std::string& what) {
  complaints_.push_back({node.position, prefix(path) + what});
  failed_.insert(path);
}

bool Reader::constant(const Node& node, const std::string& path, double& value) {
  if (node.kind == Node::Kind::number) {
    value = node.number;
  } else if (node.kind == Node::Kind::text) {
    try {
      const Expression expression(node.text);
      if (!expression.is_constant()) {
        complain(node, path, "\"" + node.text + "\" must be constant: x, y, z and t have no value here");
        return false;
      }
      value = expression(0, 0, 0, 0);
    } catch (const std::invalid_argument& error) {
      complain(node, path, "must be a number or a formula: \"" + node.text + "\": " + error.what());
      return false;
    }
  } else {
    complain(node, path, "must be a number, not " + node.description());
    return false;
  }
  if (!std::isfinite(value)) {
    complain(node, path, "must be finite, but \"" + node.text + "\" is not");
    return false;
  }
  return true;
}

bool Reader::in_range(const Node& node, const std::string& path, double value, const Range& range) {
  if (value >= range.min && value <= range.max && !(range.without_min && value == range.min)) return true;
  std::string bounds;
  if (std::isfinite(range.min)) bounds = (range.without_min ? "above " : "at least ") + number_text(range.min);
  if (std::isfinite(range.max)) bounds += (bounds.empty() ? "at most " : " and at most ") + number_text(range.max);
  const std::string got =
      node.kind == Node::Kind::text ? "\"" + node.text + "\" = " + number_text(value) : number_text(value);
  complain(node, path, "must be " + bounds + ", not " + got);
  return false;
}

bool Reader::real(const Node& node, const std::string& path, double& value, const Range& range) {
  double read = 0.0;
  if (!constant(node, path, read) || !in_range(node, path, read, range)) return false;
  value = read;
  return true;
}

bool Reader::whole(const Node& node, const std::string& path, Index& value, const Range& range) {
  double read = 0.0;
  if (!constant(node, path, read)) return false;
  if (read != std::floor(read)) {
    complain(node, path, "must be a whole number, not " + number_text(read));
    return false;
  }
  const Range storable = between(std::numeric_limits<Index>::min(), std::numeric_limits<Index>::max());
  if (!in_range(node, path, read, range) || !in_range(node, path, read, storable)) return false;
  value = static_cast<Index>(read);
  return true;
}

bool Reader::formula(const Node& node, const std::string& path, Expression& value) {
  if (node.kind == Node::Kind::text) {
    try {
      value = Expression(node.text);
    } catch (const std::invalid_argument& error) {
      complain(node, path, "formula \"" + node.text + "\": " + error.what());
      return false;
    }
    if (value.is_constant() && !std::isfinite(value(0, 0, 0, 0))) {
      complain(node, path, "must be finite, but \"" + node.text + "\" is not");
      return false;
    }
    return true;
  }
  double number_read = 0.0;
  if (node.kind != Node::Kind::number) {
    complain(node, path, "must be a number or a formula of x, y, z, t as text, not " + node.description());
    return false;
  }
  if (!constant(node, path, number_read)) return false;
  value = Expression(number_read);
  return true;
}

void Reader::flag(const Field& f, bool& value) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind == Node::Kind::boolean) {
    value = node->boolean;
  } else if (node->kind == Node::Kind::text && (node->text == "on" || node->text == "off")) {
    value = node->text == "on";
  } else {
    complain(*node, path, "must be true or false, not " + node->description());
  }
}

void Reader::number(const Field& f, double& value, const Range& range) {
  std::string path;
  if (const Node* node = take(f, path)) real(*node, path, value, range);
}

void Reader::number_or_word(const Field& f, double& value, bool& is_word, const Range& range, const Word& word) {
  std::string path;
  const Node* node = take(f, path);
  if (node == nullptr) return;
  is_word = node->kind == Node::Kind::text && node->text == word.name;
  if (!is_word) real(*node, path, value, range);
}

void Reader::integer(const Field& f, Index& value, const Range& range) {
  std::string path;
  if (const Node* node = take(f, path)) whole(*node, path, value, range);
}

void Reader::text(const Field& f, std::string& value) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind == Node::Kind::text) {
    value = node->text;
  } else {
    complain(*node, path, "must be text in quotes, not " + node->description());
  }
}

void Reader::pair(const Field& f, std::array<double, 2>& value, const Range& range) {
  std::string path;
  const Node* node = take_list(f, path, 2, "numbers");
  if (!node) return;
  for (int i = 0; i < 2; ++i) real(node->items[i], path + "[" + std::to_string(i) + "]", value[i], range);
}

void Reader::texts(const Field& f, std::vector<std::string>& value) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind != Node::Kind::list) {
    complain(*node, path, "must be a list [...] of texts, not " + node->description());
    return;
  }
  value.clear();
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const Node& item = node->items[i];
    positions_[path + "[" + std::to_string(i) + "]"] = item.position;
    if (item.kind == Node::Kind::text)
      value.push_back(item.text);
    else
      complain(item, path + "[" + std::to_string(i) + "]", "must be text in quotes, not " + item.description());
  }
}

void Reader::vector(const Field& f, Vec3& value, const Range& range) {
  std::string path;
  const Node* node = take_list(f, path, 3, "numbers");
  if (!node) return;
  for (int i = 0; i < 3; ++i) real(node->items[i], path + "[" + std::to_string(i) + "]", value[i], range);
}

void Reader::integers(const Field& f, std::array<Index, 3>& value, const Range& range) {
  std::string path;
  const Node* node = take_list(f, path, 3, "whole numbers");
  if (!node) return;
  for (int i = 0; i < 3; ++i) whole(node->items[i], path + "[" + std::to_string(i) + "]", value[i], range);
}

void Reader::vectors(const Field& f, std::vector<Vec3>& values) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind != Node::Kind::list) {
    complain(*node, path, "must be a list of points [[x, y, z], ...], not " + node->description());
    return;
  }
  for (std::size_t n = 0; n < node->items.size(); ++n) {
    const Node& item = node->items[n];
    const std::string place = path + "[" + std::to_string(n) + "]";
    positions_[place] = item.position;
    Vec3 value = Vec3::Zero();
    if (item.kind != Node::Kind::list || item.items.size() != 3) {
      complain(item, place, "must be a list of 3 numbers [x, y, z], not " + item.description());
      continue;
    }
    for (int i = 0; i < 3; ++i) real(item.items[i], place + "[" + std::to_string(i) + "]", value[i], any_number());
    values.push_back(value);
  }
}

void Reader::formula(const Field& f, Expression& value) {
  std::string path;
  const Node* node = take(f, path);
  if (node) formula(*node, path, value);
}

void Reader::formulas(const Field& f, VectorExpression& value) {
  std::string path;
  const Node* node = take_list(f, path, 3, "formulas");
  if (!node) return;
  for (int i = 0; i < 3; ++i) formula(node->items[i], path + "[" + std::to_string(i) + "]", value[i]);
}

void Reader::partial_formulas(const Field& f, std::array<std::optional<Expression>, 3>& value) {
  std::string path;
  const Node* node = take_list(f, path, 3, "formulas");
  if (!node) return;
  for (int i = 0; i < 3; ++i) {
    if (node->items[i].kind == Node::Kind::null) continue;
    Expression read;
    if (formula(node->items[i], path + "[" + std::to_string(i) + "]", read)) value[i] = read;
  }
}

void Reader::word(const Field& f, std::size_t& chosen, const std::vector<Word>& words) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  std::vector<std::string> names, quoted;
  for (const Word& candidate : words) {
    names.push_back(candidate.name);
    quoted.push_back("\"" + candidate.name + "\"");
  }
  if (node->kind != Node::Kind::text) {
    complain(*node, path, "must be " + list_text(quoted) + ", not " + node->description());
    return;
  }
  const auto found = std::find(names.begin(), names.end(), node->text);
  if (found != names.end()) {
    chosen = static_cast<std::size_t>(found - names.begin());
    return;
  }
  std::string hint = did_you_mean(node->text, names);
  if (hint.empty()) hint = "; choose " + list_text(quoted);
  complain(*node, path, "unknown value \"" + node->text + "\"" + hint);
}

void Reader::object(const Field& f, const std::string& /*title*/, const Describe& describe) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind == Node::Kind::object) {
    read_object(*node, path, describe);
  } else {
    complain(*node, path, "must be an object {...}, not " + node->description());
  }
}

void Reader::named(const Field& f, const std::string& /*title*/,
                   const std::function<void(Visitor&, const std::string&)>& describe) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind != Node::Kind::object) {
    complain(*node, path, "must be an object {...}, not " + node->description());
    return;
  }
  positions_[path] = node->position;
  for (const Node::Member& member : node->members) {
    const std::string item_path = join(path, member.key);
    if (member.value.kind == Node::Kind::object) {
      read_object(member.value, item_path, [&](Visitor& v) { describe(v, member.key); });
    } else {
      complain(member.value, item_path, "must be an object {...}, not " + member.value.description());
    }
  }
}

void Reader::list(const Field& f, const std::string& /*title*/, const Describe& add) {
  std::string path;
  const Node* node = take(f, path);
  if (!node) return;
  if (node->kind != Node::Kind::list) {
    complain(*node, path, "must be a list [...] of objects, not " + node->description());
    return;
  }
  for (std::size_t i = 0; i < node->items.size(); ++i) {
    const Node& item = node->items[i];
    const std::string item_path = path + "[" + std::to_string(i) + "]";
    if (item.kind == Node::Kind::object) {
      read_object(item, item_path, add);
    } else {
      complain(item, item_path, "must be an object {...}, not " + item.description());
    }
  }
}

std::string Reader::inside(const std::string& path) const {
  if (path.empty()) return frames_.back().path;
  return join(frames_.back().path, path);
}

bool Reader::given(const std::string& path) const { return positions_.count(inside(path)) > 0; }

bool Reader::failed(const std::string& path) const {
  const std::string full = inside(path);
  const auto first = failed_.lower_bound(full);
  for (auto it = first; it != failed_.end() && it->compare(0, full.size(), full) == 0; ++it) {
    if (it->size() == full.size() || (*it)[full.size()] == '.' || (*it)[full.size()] == '[') return true;
  }
  return false;
}

void Reader::missing(const std::string& key, const std::string& what) {
  frames_.back().missing.push_back({key, what});
  failed_.insert(inside(key));
}

void Reader::error(const std::string& path, const std::string& what) {
  const std::string full = inside(path);
  std::string place = full;
  while (!place.empty() && positions_.count(place) == 0) {
    const std::size_t cut = place.find_last_of(".[");
    place = cut == std::string::npos ? "" : place.substr(0, cut);
  }
  complaints_.push_back({positions_[place], prefix(full) + what});
  failed_.insert(full);
}

}  // namespace fbi::input
