/// JSON with // comments as a tree in which every key and value knows its line and column.
#pragma once

#include <string>
#include <vector>

namespace fbi::input {

/// Place in a text, both one-based; columns count characters.
struct Position {
  int line = 1;
  int column = 1;
};

/// Something wrong with a text, and where.
struct Complaint {
  Position position;
  std::string text;
};

/// One JSON value.
struct Node {
  enum class Kind { null, boolean, number, text, list, object };
  struct Member;

  Kind kind = Kind::null;
  Position position;            ///< of its first character
  bool boolean = false;         ///< for boolean
  double number = 0.0;          ///< for number
  std::string text;             ///< for text: its content; for number: as written
  std::vector<Node> items;      ///< for list
  std::vector<Member> members;  ///< for object, in file order

  /// The member with this key, or null.
  const Member* find(const std::string& key) const;
  /// The value in words for an error message: "the text "abc"", "the number 3", "a list", ...
  std::string description() const;
};

struct Node::Member {
  std::string key;
  Position position;  ///< of the opening quote of the key
  Node value;
};

/// Reads JSON with // and block comments. Syntax errors and keys given twice are appended to `complaints`; after a
/// syntax error the tree holds nothing.
Node parse_document(const std::string& text, std::vector<Complaint>& complaints);

}  // namespace fbi::input
