/// A flat bounding-volume tree: which of many boxes overlap a given one.
#pragma once

#include <utility>
#include <vector>

#include "base/types.hpp"
#include "search/aabb.hpp"

namespace fbi::search {

/// Binary tree over boxes in one array, split at the median of the centers along the longest edge.
class Tree {
 public:
  Tree() = default;
  /// Builds the tree in O(n log n); `boxes` shape=(n), none of them empty.
  explicit Tree(const std::vector<Aabb>& boxes);

  /// Appends to `found` the numbers of all boxes that overlap `box` (touching counts), in an order that depends on the
  /// boxes alone. Cost O(log n + hits) for boxes of similar size.
  void overlapping(const Aabb& box, std::vector<Index>& found) const;
  /// Appends all pairs of boxes that overlap each other (touching counts), each once with the lower number first, in an
  /// order that depends on the boxes alone.
  void pairs(std::vector<std::pair<Index, Index>>& found) const;

 private:
  struct Node {
    Aabb box;
    Index first =
        0;  ///< leaf: first entry of items_; inner: number of the second child (the first child is the next node)
    Index count = 0;  ///< leaf: number of boxes; inner: 0
  };
  bool is_leaf(Index node) const { return nodes_[node].count > 0; }
  void pairs_within(Index node, std::vector<std::pair<Index, Index>>& found) const;
  void pairs_between(Index a, Index b, std::vector<std::pair<Index, Index>>& found) const;
  Index build(const std::vector<Aabb>& boxes, Index begin, Index end);

  std::vector<Node> nodes_;
  std::vector<Index> items_;
  std::vector<Aabb> item_boxes_;
};

}  // namespace fbi::search
