/// Fills parameter structs from a JSON tree by their field tables, and collects everything that is wrong.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "input/document.hpp"
#include "input/visitor.hpp"

namespace fbi::input {

class Reader final : public Visitor {
 public:
  /// Reads `root` (an object) by `describe` and appends what is wrong to `complaints`, with its position.
  static void read(const Node& root, const Describe& describe, std::vector<Complaint>& complaints);

  void flag(const Field& f, bool& value) override;
  void number(const Field& f, double& value, const Range& range) override;
  void number_or_word(const Field& f, double& value, bool& is_word, const Range& range, const Word& word) override;
  void integer(const Field& f, Index& value, const Range& range) override;
  void text(const Field& f, std::string& value) override;
  void pair(const Field& f, std::array<double, 2>& value, const Range& range) override;
  void texts(const Field& f, std::vector<std::string>& value) override;
  void vector(const Field& f, Vec3& value, const Range& range) override;
  void integers(const Field& f, std::array<Index, 3>& value, const Range& range) override;
  void vectors(const Field& f, std::vector<Vec3>& values) override;
  void formula(const Field& f, Expression& value) override;
  void formulas(const Field& f, VectorExpression& value) override;
  void partial_formulas(const Field& f, std::array<std::optional<Expression>, 3>& value) override;
  void word(const Field& f, std::size_t& chosen, const std::vector<Word>& words) override;
  void object(const Field& f, const std::string& title, const Describe& describe) override;
  void named(const Field& f, const std::string& title,
             const std::function<void(Visitor&, const std::string&)>& describe) override;
  void list(const Field& f, const std::string& title, const Describe& add) override;
  bool reading() const override { return true; }
  bool given(const std::string& path) const override;
  bool failed(const std::string& path) const override;
  void missing(const std::string& key, const std::string& what) override;
  void error(const std::string& path, const std::string& what) override;

 private:
  explicit Reader(std::vector<Complaint>& complaints) : complaints_(complaints) {}
  void read_object(const Node& node, const std::string& path, const Describe& describe);
  const Node* take(const Field& f, std::string& path);
  const Node* take_list(const Field& f, std::string& path, std::size_t size, const char* of_what);
  void complain(const Node& node, const std::string& path, const std::string& what);
  bool constant(const Node& node, const std::string& path, double& value);
  bool in_range(const Node& node, const std::string& path, double value, const Range& range);
  bool real(const Node& node, const std::string& path, double& value, const Range& range);
  bool whole(const Node& node, const std::string& path, Index& value, const Range& range);
  bool formula(const Node& node, const std::string& path, Expression& value);
  std::string inside(const std::string& path) const;

  struct Frame {
    const Node* node;
    std::string path;
    std::vector<std::string> keys;                             // named by the table
    std::vector<std::pair<std::string, std::string>> missing;  // key and message
  };
  std::vector<Frame> frames_;
  std::map<std::string, Position> positions_;  // of every value met, by its full path
  std::set<std::string> failed_;               // full paths
  std::vector<Complaint>& complaints_;
};

}  // namespace fbi::input
