/// VelocityLines on any mesh of hexahedra.
#pragma once

#include <cstdint>
#include <vector>

#include "fluid/halo.hpp"
#include "fsi/velocity_lines.hpp"

namespace fbi::fsi {

/// Lines of edges: each cell has a direction, that of most diffusion, streamline and viscous; a node is linked to the
/// two neighbors with which it shares most of it, where they want it as well. All velocities have the same lines: a
/// third of grad-div on the diagonal of L, and B = 1/4. To tell them apart takes three times the time here.
class MeshLines : public VelocityLines {
 public:
  /// Collective.
  explicit MeshLines(const fluid::FluidField& fluid);

  void renew(const VelocityWeight& weight) override;
  void apply(const float* r, float* x, const std::vector<char>* only = nullptr) const override;
  std::vector<char> reached(const std::vector<Index>& nodes) const override;
  std::vector<char> nodes_of(const std::vector<char>& lines) const override;
  std::vector<double> diagonal() override;
  int version() const override { return version_; }
  /// Local nodes of each line, shape=(lines); the longest lines first.
  std::vector<std::vector<Index>> lines() const;

 private:
  static constexpr int most_lanes = 4;  // lines side by side: each waits for its own last number
  struct CellShape {
    Eigen::Matrix3f gradient;  // of the coordinates along edges, one a row [1/length]
    Eigen::Array3f squares;
    float volume, inverse_size;
  };
  struct Edge {
    Index low, high;  // owned nodes
  };
  /// Lines next to each other, the longest first; node t of lane l is in slot first + most_lanes*t + l.
  struct Bundle {
    std::size_t first = 0;
    Index line = 0;  // number of the first one
    int lanes = 0;
    Index count[most_lanes] = {};
    bool operator==(const Bundle&) const = default;
  };
  LineCell cell_of(Index c, const CellFlow& flow) const;
  void find_edges();
  void choose(const std::vector<CellFlow>& flow);
  std::vector<Index> links(const std::vector<float>& strength) const;
  void set_lines(const std::vector<std::vector<Index>>& lines);
  void find_neighbors();
  void factorize();
  template <class Act>
  static void for_places(const Bundle& bundle, const Act& act);
  template <class Act>
  static void for_places_backwards(const Bundle& bundle, const Act& act);
  int link(Index first, Index second) const;
  std::size_t line_of(Index node) const {
    return static_cast<std::size_t>(places_[4 * static_cast<std::size_t>(node) + 1]);
  }

  const fluid::FluidField& fluid_;
  fluid::Halo halo_;
  std::vector<CellShape> shape_;         ///< shape=(local cells)
  std::vector<Edge> edges_;              ///< between owned nodes
  std::vector<std::int32_t> cell_edge_;  ///< -1: an end belongs to another rank, shape=(local cells,3,4)
  std::vector<std::int8_t> direction_;   ///< of lines in cells
  /// Where a node is: owner, line, place on it, nothing; numbers that floats hold exactly, shape=(local nodes,4).
  std::vector<float> places_;
  std::vector<Bundle> bundles_;
  std::vector<Index> slots_;  ///< nodes; -1: none
  Index line_count_ = 0;
  int version_ = 0;
  int renewals_ = 0, next_choice_ = 0;
  std::vector<float> rows_;  ///< as those of BoxLines, shape=(local nodes,4)
  // For each slot: coupling to the node before, 1/pivot, coupling to the one after over the pivot.
  std::vector<float> low_, inverse_, high_;
  // Neighbors of slot s along edges of no line: [begin, next begin).
  std::vector<Index> neighbor_begin_, neighbor_;
  std::vector<float> neighbor_area_;  ///< area of the slot's node over that of the neighbor
};

}  // namespace fbi::fsi
