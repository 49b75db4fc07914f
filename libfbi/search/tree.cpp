#include "search/tree.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace fbi::search {

namespace {
constexpr Index leaf_size = 4;
}

Tree::Tree(const std::vector<Aabb>& boxes) {
  items_.resize(boxes.size());
  std::iota(items_.begin(), items_.end(), 0);
  if (boxes.empty()) return;
  nodes_.reserve(boxes.size());
  build(boxes, 0, static_cast<Index>(boxes.size()));
  item_boxes_.reserve(boxes.size());
  for (const Index item : items_) item_boxes_.push_back(boxes[item]);
}

Index Tree::build(const std::vector<Aabb>& boxes, Index begin, Index end) {
  const Index self = static_cast<Index>(nodes_.size());
  nodes_.emplace_back();
  Aabb all, centers;
  for (Index i = begin; i < end; ++i) {
    const Aabb& box = boxes[items_[i]];
    all.include(box);
    const double center[3] = {0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1]),
                              0.5 * (box.low[2] + box.high[2])};
    centers.include(center);
  }
  nodes_[self].box = all;
  if (end - begin <= leaf_size) {
    nodes_[self].first = begin;
    nodes_[self].count = end - begin;
    return self;
  }
  int axis = 0;
  for (int i = 1; i < 3; ++i)
    if (centers.high[i] - centers.low[i] > centers.high[axis] - centers.low[axis]) axis = i;
  const Index middle = begin + (end - begin) / 2;
  std::nth_element(items_.begin() + begin, items_.begin() + middle, items_.begin() + end, [&](Index a, Index b) {
    const double ca = boxes[a].low[axis] + boxes[a].high[axis], cb = boxes[b].low[axis] + boxes[b].high[axis];
    return ca < cb || (ca == cb && a < b);
  });
  build(boxes, begin, middle);
  nodes_[self].first = build(boxes, middle, end);
  return self;
}

void Tree::overlapping(const Aabb& box, std::vector<Index>& found) const {
  if (nodes_.empty()) return;
  std::array<Index, 64> stack;  // depth of the tree is at most 32: every split halves the boxes
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const Index number = stack[--top];
    const Node& node = nodes_[number];
    if (!node.box.overlaps(box)) continue;
    if (node.count > 0) {
      for (Index i = node.first; i < node.first + node.count; ++i)
        if (item_boxes_[i].overlaps(box)) found.push_back(items_[i]);
    } else {
      stack[top++] = node.first;
      stack[top++] = number + 1;
    }
  }
}

void Tree::pairs(std::vector<std::pair<Index, Index>>& found) const {
  if (!nodes_.empty()) pairs_within(0, found);
}

void Tree::pairs_within(Index node, std::vector<std::pair<Index, Index>>& found) const {
  if (!is_leaf(node)) {
    pairs_within(node + 1, found);
    pairs_within(nodes_[node].first, found);
    pairs_between(node + 1, nodes_[node].first, found);
    return;
  }
  const Index begin = nodes_[node].first, end = begin + nodes_[node].count;
  for (Index i = begin; i < end; ++i)
    for (Index j = i + 1; j < end; ++j)
      if (item_boxes_[i].overlaps(item_boxes_[j])) found.push_back(std::minmax(items_[i], items_[j]));
}

void Tree::pairs_between(Index a, Index b, std::vector<std::pair<Index, Index>>& found) const {
  const Node &left = nodes_[a], &right = nodes_[b];
  if (!left.box.overlaps(right.box)) return;
  if (!is_leaf(a)) {
    pairs_between(a + 1, b, found);
    pairs_between(left.first, b, found);
  } else if (!is_leaf(b)) {
    pairs_between(a, b + 1, found);
    pairs_between(a, right.first, found);
  } else {
    for (Index i = left.first; i < left.first + left.count; ++i) {
      if (!item_boxes_[i].overlaps(right.box)) continue;
      for (Index j = right.first; j < right.first + right.count; ++j)
        if (item_boxes_[i].overlaps(item_boxes_[j])) found.push_back(std::minmax(items_[i], items_[j]));
    }
  }
}

}  // namespace fbi::search
