/// Approximate inverse of the fluid's velocity block: lines of nodes the way the flow goes.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "base/node_vector.hpp"
#include "fluid/fluid_field.hpp"
#include "fsi/velocity_weight.hpp"

namespace fbi::fsi {

/// V = L^-1 (1 + sum B D): L has, along lines of nodes, the tridiagonal matrices of linear elements of
///   rho (sigma + v_d d/dx) u + rho tau v_d dw/dx (rho sigma u + rho v_d du/dx) + mu du/dx dw/dx,
/// lumped across, with tau_C du/dx dw/dx for the velocity along the line, plus a diagonal for what acts across:
/// viscosity, streamline diffusion, half of the reaction rho |dv|/h. Each D is a second difference (-1/2, 1, -1/2)
/// of forces over areas along edges that belong to no line; it undoes what lumping does to the mass of rough fields,
/// and less of it (B, a number for each velocity) where viscosity acts and, on the velocity along the edge, grad-div.
///
/// A diagonal is too small, by up to 20, for fields that are rough across the flow and smooth along it; fibers make
/// such fields. Lines end where the nodes of a rank do.
class VelocityLines {
 public:
  virtual ~VelocityLines() = default;

  /// Renews L for the present time step and tau, with the flow that W was renewed for. Collective.
  virtual void renew(const VelocityWeight& weight) = 0;
  /// The first three numbers of every node of x = V r; the fourth ones of x stay. r is zero where the velocity is
  /// given, x is then not: that is left to the caller. Shapes=(owned nodes,4); r and x differ.
  /// @param only  lines of x to compute, shape=(lines); null: all
  virtual void apply(const float* r, float* x, const std::vector<char>* only = nullptr) const = 0;
  /// 1 for lines where x is not zero when r is zero but at the given owned nodes, shape=(lines).
  virtual std::vector<char> reached(const std::vector<Index>& nodes) const = 0;
  /// 1 for owned nodes on the given lines, shape=(owned nodes).
  virtual std::vector<char> nodes_of(const std::vector<char>& lines) const = 0;
  /// Diagonal of V for fields that are rough in one direction across and that grad-div does not act on, zero where the
  /// velocity is given, shape=(local nodes,3). Collective.
  virtual std::vector<double> diagonal() = 0;
  /// A number that changes when the lines get other nodes.
  virtual int version() const = 0;
};

/// The lines that suit the mesh of `fluid`: BoxLines or MeshLines. Collective.
std::unique_ptr<VelocityLines> make_velocity_lines(const fluid::FluidField& fluid);

/// What the terms of L need of a cell; along its edges run coordinates from 0 to 1.
struct LineCell {
  Eigen::Array3f rate;     ///< of the coordinates in the flow [1/time]
  Eigen::Array3f squares;  ///< of the coordinates' gradients [1/length^2]
  float inverse_size;      ///< V^(-1/3) [1/length]
  float tau;               ///< FluidField::tau_streamline()
};

/// What one of the four edges of a cell in a direction adds to rows of L, over the volume of the cell: coupling to the
/// node before, to the one after, diagonal, diagonal without convection.
struct EdgeRows {
  NodeVector<float> first, second;  ///< of the ends of the edge, when the line goes from the first to the second
  float lump = 0.0f;                ///< beside both diagonals, where they are not neighbors on a line
  /// Beside both diagonals, and taken from the couplings, for the velocity along the line.
  float grad_div = 0.0f;
  float mean_grad_div = 0.0f;  ///< beside both diagonals in place of that, where all velocities have the same lines
};

/// Terms of L, for one state of the fluid.
class LineTerms {
 public:
  explicit LineTerms(const fluid::FluidField& fluid);
  EdgeRows rows(const LineCell& cell, const CellFlow& flow, int direction) const;

  /// B: what the mass of a field that is half rough has, consistent, over lumped mass (1/2 without the rest).
  /// @param viscosity  mu/h^2, h: length of the edge
  /// @param grad_div   tau_C/h^2, or 0 for velocities across the edge
  float across(float viscosity, float grad_div) const {
    const float inertia = density_ * sigma_;
    return std::max(
        least_across,
        (inertia + lumped_viscosity * viscosity) / (2.0f / 3.0f * inertia + 2.0f * (viscosity + grad_div)) - 1.0f);
  }
  float viscosity() const { return viscosity_; }

  static constexpr float least_pivot = 0.1f;  ///< of the diagonal without convection

 private:
  static constexpr float reaction_part = 0.5f;             // of rho |dv|/h
  static constexpr float lumped_viscosity = 16.0f / 9.0f;  // on the diagonal of L, over mu/h^2
  static constexpr float least_across = -0.25f;            // 1 + sum B D stays positive
  float density_, viscosity_, sigma_;
};

inline EdgeRows LineTerms::rows(const LineCell& cell, const CellFlow& flow, int direction) const {
  const float stabilised = density_ * density_ * cell.tau;
  const float along = cell.rate[direction];
  // A quarter of the volume belongs to every edge, an eighth to every node; int (dN_a/dx)^2 is V/(9 h^2).
  const float mass = 0.25f * density_ * sigma_;
  const float convection = 0.125f * density_ * along;
  const float diffusion = 0.25f * (stabilised * along * along + viscosity_ * cell.squares[direction]);
  const float inertia = 0.125f * stabilised * along * sigma_;  // tau v_d dw/dx rho sigma u
  Eigen::Array3f others = viscosity_ * cell.squares + stabilised * cell.rate.square();
  others[direction] = 0.0f;
  const float across =
      others.sum() / 9.0f + reaction_part / 8.0f * density_ * static_cast<float>(flow.difference) * cell.inverse_size;
  const float bound = mass / 3.0f + diffusion + across;
  const float forwards = mass / 6.0f + convection - diffusion - inertia;
  const float backwards = mass / 6.0f - convection - diffusion + inertia;
  EdgeRows rows;
  rows.first = NodeVector<float>{0.0f, forwards, bound - convection - inertia, bound};
  rows.second = NodeVector<float>{backwards, 0.0f, bound + convection + inertia, bound};
  rows.lump = mass / 6.0f;
  rows.grad_div = 0.25f * static_cast<float>(flow.grad_div) * cell.squares[direction];
  rows.mean_grad_div = static_cast<float>(flow.grad_div) / 27.0f * cell.squares.sum();
  return rows;
}

/// Nodes of a hex8 that follow each other along a direction.
inline constexpr int line_edges[3][4][2] = {
    {{0, 1}, {3, 2}, {4, 5}, {7, 6}}, {{0, 3}, {1, 2}, {4, 7}, {5, 6}}, {{0, 4}, {1, 5}, {2, 6}, {3, 7}}};

/// Whether all velocities of a node are given.
inline bool is_given(const fluid::FluidField& fluid, std::size_t node) {
  const char* dirichlet = &fluid.is_dirichlet()[4 * node];
  return dirichlet[0] != 0 && dirichlet[1] != 0 && dirichlet[2] != 0;
}

/// What solves need of a node, for velocities across the line and for the one along it.
struct alignas(32) LinePivot {
  float low[2] = {};      ///< coupling to the node before
  float inverse[2] = {};  ///< 1/pivot
  float high[2] = {};     ///< coupling to the node after, over the pivot
  float across[2] = {};   ///< B of the velocity along the edges in the two directions across, of BoxLines
  NodeVector<float> low_and_inverse() const { return load_node(low); }
  NodeVector<float> high_and_across() const { return load_node(high); }
};

/// Elimination along one line, node by node; couplings are left out where the velocity is given.
class LineElimination {
 public:
  /// For a line whose first node is free, or not.
  explicit LineElimination(bool free = false) : free_(free) {}
  /// @param row         of L at the next node: coupling before, after, diagonal, the same without convection
  /// @param grad_div    of the velocity along the line: diffusion to the node before, to the one after
  /// @param free_after  there is a node behind it, and it is free
  LinePivot next(const float* row, const float* grad_div, bool free_after) {
    using Node = NodeVector<float>;  // across, along, and both again
    const bool before = free_ && free_before_, after = free_ && free_after;
    const float both = grad_div[0] + grad_div[1];
    const Node extra = {0.0f, 1.0f, 0.0f, 1.0f};
    const Node low = before ? row[0] - grad_div[0] * extra : Node{};
    const Node high = after ? row[1] - grad_div[1] * extra : Node{};
    const Node pivot = row[2] + both * extra - low * ratio_, least = LineTerms::least_pivot * (row[3] + both * extra);
    const Node inverse = 1.0f / (pivot > least ? pivot : least);
    ratio_ = high * inverse;
    free_before_ = free_;
    free_ = free_after;
    LinePivot result;
    for (int i = 0; i < 2; ++i) {
      result.low[i] = low[i];
      result.inverse[i] = inverse[i];
      result.high[i] = ratio_[i];
    }
    return result;
  }

 private:
  NodeVector<float> ratio_ = {};
  bool free_before_ = false, free_;
};

/// The first of the four numbers of a node for each velocity, 0 where it is given, shape=(local nodes,3).
std::vector<double> diagonal_of(const fluid::FluidField& fluid, const std::vector<float>& nodal);

}  // namespace fbi::fsi
