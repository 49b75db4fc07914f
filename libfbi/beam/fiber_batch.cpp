#include "beam/fiber_batch.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "beam/fiber_equations.hpp"
#include "beam/torsion_free_element.hpp"

namespace fbi::beam {
namespace {

using Lanes = fem::Batch;
using fem::batch_size;

constexpr int node_dofs = 6;
constexpr Index row_size = 2 * node_dofs;
// Part of a diagonal entry that must remain of it as a pivot; what is less may be round-off.
constexpr double least_pivot = 1e-13;

bool can_be_batched(const FiberEquations& equations, Index f) {
  const FiberParameters& group = equations.groups[equations.mesh.group[f]];
  const Fiber& fiber = equations.fibers[f];
  return group.formulation == Formulation::torsion_free && equations.parameters.scheme != TimeScheme::midpoint &&
         fiber.mass_damping == 0.0 && fiber.stiffness_damping == 0.0 && !fiber.moving_supports &&
         !equations.mesh.is_joined(f) && std::none_of(group.loads.begin(), group.loads.end(), [](const Load& load) {
           return load.type == LoadType::moment || load.follower;
         });
}

// What fibers of one batch have in common: the number of nodes, and what is held where.
std::vector<Index> shape_of(const Fiber& fiber) {
  std::vector<Index> shape = {fiber.nodes};
  for (const NodeSupport& support : fiber.supports) {
    const NodeConstraint& held = support.constraint;
    shape.insert(shape.end(), {support.node, 4 * held.position + 2 * held.along + held.direction});
  }
  return shape;
}

FiberBatch make_batch(const FiberEquations& equations, const Index* fibers, int lanes) {
  FiberBatch batch;
  batch.lanes = lanes;
  const Fiber& first = equations.fibers[fibers[0]];
  batch.nodes = first.nodes;
  batch.length.resize(static_cast<std::size_t>(batch.nodes) - 1);
  batch.matrix.resize(static_cast<std::size_t>(node_dofs * batch.nodes) * row_size);
  for (const NodeSupport& support : first.supports) {
    FiberBatch::Support& copy = batch.supports.emplace_back();
    copy.node = support.node;
    copy.held = support.constraint;
  }
  for (int lane = 0; lane < batch_size; ++lane) {
    const Index f = fibers[std::min(lane, lanes - 1)];
    const Fiber& fiber = equations.fibers[f];
    batch.fiber[lane] = f;
    batch.first_dof[lane] = fiber.first_dof();
    batch.section.axial_stiffness.set(lane, fiber.section.axial_stiffness);
    batch.section.bending_stiffness.set(lane, fiber.section.bending_stiffness);
    batch.section.mass_per_length.set(lane, fiber.section.mass_per_length);
    batch.shortest.set(lane, equations.shortest_element(fiber));
    for (std::size_t e = 0; e < batch.length.size(); ++e) batch.length[e].set(lane, equations.element_length(fiber)[e]);
    for (std::size_t s = 0; s < batch.supports.size(); ++s)
      for (int k = 0; k < 3; ++k) batch.supports[s].axis[k].set(lane, fiber.supports[s].constraint.axis[k]);
  }
  return batch;
}

// Nodal values of a batch, shape=(dofs), one field after the other, and sizes of forces.
struct Work {
  Lanes *dofs, *rate, *dead, *other;  // iterate; acceleration; loads at t_{n+1}; internal minus external force at t_n
  Lanes *internal, *full, *residual;
  Lanes scale, coordinate;
  std::vector<Lanes> storage;

  void resize(std::size_t size) {
    if (storage.size() < 7 * size) storage.resize(7 * size);
    Lanes* next = storage.data();
    for (Lanes** field : {&dofs, &rate, &dead, &other, &internal, &full, &residual}) {
      *field = next;
      next += size;
    }
  }
};

void gather(const FiberBatch& batch, const double* field, Lanes* out) {
  const Index size = node_dofs * batch.nodes;
  for (int lane = 0; lane < batch_size; ++lane) {
    const double* from = field + batch.first_dof[lane];
    for (Index i = 0; i < size; ++i) out[i].set(lane, from[i]);
  }
}

// to[first_dof + i] = in[i][lane] of the lanes that `take` allows.
template <class Take>
void scatter(const FiberBatch& batch, const Lanes* in, double* field, const Take& take) {
  const Index size = node_dofs * batch.nodes;
  for (int lane = 0; lane < batch.lanes; ++lane) {
    if (!take(lane)) continue;
    double* to = field + batch.first_dof[lane];
    for (Index i = 0; i < size; ++i) to[i] = in[i][lane];
  }
}

inline void project(const FiberBatch& batch, Lanes* x) {
  for (const FiberBatch::Support& support : batch.supports)
    project_node(support.held, support.axis, support.axis, x + node_dofs * support.node);
}

inline void enlarge(Lanes& largest, const Lanes* force, const Lanes& inverse_length) {
  for (int k = 0; k < node_dofs; ++k) largest = max(largest, k < 3 ? abs(force[k]) : abs(force[k]) * inverse_length);
}

// Projects the supports of element e out and adds it to the matrix.
inline void assemble(FiberBatch& batch, Index e, Lanes* tangent) {
  bool mirrored = false;
  Lanes position_scale = 0.0, tangent_scale = 0.0;
  for (int pass = 0; pass < 2; ++pass)
    for (const FiberBatch::Support& support : batch.supports) {
      const Index end = support.node - e;
      if (end != 0 && end != 1) continue;
      if (!mirrored) {
        torsion_free::mirror(tangent);
        for (int i = 0; i < element_dofs; ++i) {
          Lanes& scale = i % node_dofs < 3 ? position_scale : tangent_scale;
          scale = max(scale, abs(tangent[(element_dofs + 1) * i]));
        }
        mirrored = true;
      }
      if (pass == 0)
        project_element(support.held, support.axis, support.axis, tangent, static_cast<int>(end));
      else
        fill_element(support.held, support.axis, tangent, static_cast<int>(end), position_scale, tangent_scale);
    }
  Lanes* target = &batch.matrix[static_cast<std::size_t>(node_dofs * e) * row_size];
  for (int i = 0; i < node_dofs; ++i)
    for (int j = i; j < element_dofs; ++j) target[row_size * i + j] += tangent[element_dofs * i + j];
  target += node_dofs * row_size;
  for (int i = 0; i < node_dofs; ++i)
    for (int j = i; j < node_dofs; ++j)
      target[row_size * i + j] += tangent[element_dofs * (node_dofs + i) + node_dofs + j];
}

// Forces of a batch at the gathered iterate, and K_b on request: FiberEquations::evaluate.
FBI_KERNEL void evaluate_batch(FiberBatch& batch, const Level& level, Work& work, bool with_tangent) {
  const Index size = node_dofs * batch.nodes;
  for (Index i = 0; i < size; ++i) work.internal[i] = work.full[i] = 0.0;
  if (with_tangent) std::fill(batch.matrix.begin(), batch.matrix.end(), Lanes(0.0));
  Lanes largest = 0.0;
  ElementPropertiesOf<Lanes> element = batch.section;
  Lanes force[element_dofs], tangent[element_dofs * element_dofs];
  for (Index e = 0; e + 1 < batch.nodes; ++e) {
    element.length = batch.length[e];
    const Lanes inverse_length = 1.0 / element.length;
    const Index dof = node_dofs * e;
    std::fill_n(force, element_dofs, Lanes(0.0));
    if (with_tangent) std::fill_n(tangent, element_dofs * element_dofs, Lanes(0.0));
    torsion_free::add_axial(element, work.dofs + dof, force, with_tangent ? tangent : nullptr);
    torsion_free::add_bending(element, work.dofs + dof, force, with_tangent ? tangent : nullptr);
    for (int i = 0; i < element_dofs; ++i) {
      work.internal[dof + i] += force[i];
      work.full[dof + i] += level.internal * force[i];
    }
    enlarge(largest, force, inverse_length);
    enlarge(largest, force + node_dofs, inverse_length);
    if (with_tangent)
      for (int i = 0; i < element_dofs; ++i)
        for (int j = i - i % 3; j < element_dofs; ++j) tangent[element_dofs * i + j] *= level.internal;
    if (level.dynamic) {
      Lanes mass[4][4];
      torsion_free::scalar_mass(element, mass);
      const Lanes* rate = work.rate + dof;
      for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k)
          force[3 * i + k] =
              mass[i][0] * rate[k] + mass[i][1] * rate[3 + k] + mass[i][2] * rate[6 + k] + mass[i][3] * rate[9 + k];
      for (int i = 0; i < element_dofs; ++i) work.full[dof + i] += force[i];
      enlarge(largest, force, inverse_length);
      enlarge(largest, force + node_dofs, inverse_length);
      if (with_tangent)
        for (int i = 0; i < 4; ++i)
          for (int j = i; j < 4; ++j)
            for (int k = 0; k < 3; ++k) tangent[element_dofs * (3 * i + k) + 3 * j + k] += level.inertia * mass[i][j];
    }
    if (with_tangent) assemble(batch, e, tangent);
  }
  const Lanes inverse_shortest = 1.0 / batch.shortest;
  Lanes coordinate = 0.0;
  for (Index i = 0; i < size; i += node_dofs) {
    enlarge(largest, work.dead + i, inverse_shortest);
    for (int k = 0; k < 3; ++k) coordinate = max(coordinate, abs(work.dofs[i + k]));
  }
  for (Index i = 0; i < size; ++i) {
    work.full[i] += level.previous * work.other[i] - level.internal * work.dead[i];
    work.residual[i] = work.full[i];
  }
  project(batch, work.residual);
  work.scale = largest;
  work.coordinate = coordinate;
}

// K_b = L diag(d) L^T in place: rows of L^T right of the diagonal, 1/d on it, zero for pivots d that are not positive.
// `downhill`: L diag(|d|) L^T, zero for pivots next to zero. `ok`: lanes without zeros.
FBI_KERNEL void factorize_batch(FiberBatch& batch, bool downhill, bool* ok) {
  Lanes refused = 0.0;            // number of pivots
  Lanes diagonal[2 * node_dofs];  // of K_b, of this node and of the next one
  Lanes* matrix = batch.matrix.data();
  for (int i = 0; i < node_dofs; ++i) diagonal[node_dofs + i] = matrix[(row_size + 1) * i];
  for (Index node = 0; node < batch.nodes; ++node) {
    const int width = node + 1 < batch.nodes ? 2 * node_dofs : node_dofs;
    Lanes* rows = matrix + node_dofs * row_size * node;
    for (int i = 0; i < node_dofs; ++i) {
      diagonal[i] = diagonal[node_dofs + i];
      if (width > node_dofs) diagonal[node_dofs + i] = rows[row_size * node_dofs + (row_size + 1) * i];
    }
    for (int k = 0; k < node_dofs; ++k) {
      Lanes* pivot_row = rows + row_size * k;
      const Lanes least = least_pivot * abs(diagonal[k]);
      const Lanes size = downhill ? abs(pivot_row[k]) : pivot_row[k];
      Lanes inverse = 1.0 / select_greater(size, least, pivot_row[k], 1.0);
      inverse = select_greater(size, least, inverse, 0.0);
      refused += select_greater(abs(inverse), 0.0, 0.0, 1.0);
      for (int i = k + 1; i < width; ++i) {
        const Lanes factor = pivot_row[i] * inverse;
        Lanes* row = i < node_dofs ? rows + row_size * i : rows + row_size * i - node_dofs;
        for (int j = i; j < width; ++j) row[j] -= factor * pivot_row[j];
      }
      for (int i = k + 1; i < width; ++i) pivot_row[i] *= inverse;
      pivot_row[k] = abs(inverse);
    }
  }
  for (int lane = 0; lane < batch_size; ++lane) ok[lane] = refused[lane] == 0.0;
}

// x = L^-1 P x for columns that are zero before node `first`; x[i] is row i.
inline void forward(const FiberBatch& batch, Lanes* x, Index first) {
  for (Index node = first; node < batch.nodes; ++node) {
    const int width = node + 1 < batch.nodes ? 2 * node_dofs : node_dofs;
    const Lanes* row = &batch.matrix[static_cast<std::size_t>(node_dofs * node) * row_size];
    Lanes* part = x + node_dofs * node;
    for (int k = 0; k < node_dofs; ++k, row += row_size)
      for (int i = k + 1; i < width; ++i) part[i] -= row[i] * part[k];
  }
}

FBI_KERNEL void solve_batch(const FiberBatch& batch, Lanes* x) {
  project(batch, x);
  forward(batch, x, 0);
  for (Index node = batch.nodes - 1; node >= 0; --node) {
    const int width = node + 1 < batch.nodes ? 2 * node_dofs : node_dofs;
    const Lanes* rows = &batch.matrix[static_cast<std::size_t>(node_dofs * node) * row_size];
    Lanes* part = x + node_dofs * node;
    for (int k = node_dofs - 1; k >= 0; --k) {
      const Lanes* row = rows + row_size * k;
      Lanes sum = row[k] * part[k];
      for (int i = k + 1; i < width; ++i) sum -= row[i] * part[i];
      part[k] = sum;
    }
  }
  project(batch, x);
}

// D K_b^-1 D^T = Y^T diag(1/d) Y with Y = L^-1 P D^T.
// d: shape=(rows,2 nodes); first: the first node that a row acts on; y: shape=(3 rows,dofs), columns of Y one after the
// other; out: upper triangle of shape=(3 rows,3 rows).
FBI_KERNEL void compliance_batch(const FiberBatch& batch, const Lanes* d, Index rows, const Index* first, Lanes* y,
                                 Lanes* out) {
  const Index size = node_dofs * batch.nodes, columns = 3 * rows;
  for (Index r = 0; r < rows; ++r)
    for (int k = 0; k < 3; ++k) {
      Lanes* column = y + (3 * r + k) * size;
      std::fill_n(column, size, Lanes(0.0));
      for (Index i = 2 * first[r]; i < 2 * batch.nodes; ++i) column[3 * i + k] = d[2 * batch.nodes * r + i];
      project(batch, column);
      forward(batch, column, first[r]);
    }
  for (Index r = 0; r < rows; ++r) {
    const Lanes* left = y + 3 * r * size;
    for (Index s = r; s < rows; ++s) {
      const Lanes* right = y + 3 * s * size;
      Lanes sum[3][3];
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) sum[k][l] = 0.0;
      for (Index node = std::max(first[r], first[s]); node < batch.nodes; ++node) {
        const Lanes* row = &batch.matrix[static_cast<std::size_t>(node_dofs * node) * row_size];
        for (int i = 0; i < node_dofs; ++i) {
          const Index at = node_dofs * node + i;
          const Lanes a[3] = {left[at] * row[(row_size + 1) * i], left[size + at] * row[(row_size + 1) * i],
                              left[2 * size + at] * row[(row_size + 1) * i]};
          const Lanes b[3] = {right[at], right[size + at], right[2 * size + at]};
          for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l) sum[k][l] += a[k] * b[l];
        }
      }
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) out[columns * (3 * r + k) + 3 * s + l] = sum[k][l];
    }
  }
}

}  // namespace

FiberBatches::FiberBatches(const FiberEquations& equations)
    : batch_of_(equations.fibers.size(), -1), lane_of_(equations.fibers.size(), 0) {
  std::map<std::vector<Index>, std::vector<Index>> alike;
  for (Index f = 0; f < equations.mesh.fibers(); ++f)
    if (can_be_batched(equations, f)) alike[shape_of(equations.fibers[f])].push_back(f);
  for (const auto& [shape, fibers] : alike)
    for (std::size_t begin = 0; begin < fibers.size(); begin += batch_size) {
      const int lanes = static_cast<int>(std::min<std::size_t>(batch_size, fibers.size() - begin));
      for (int lane = 0; lane < lanes; ++lane) {
        batch_of_[fibers[begin + lane]] = static_cast<Index>(batches_.size());
        lane_of_[fibers[begin + lane]] = lane;
      }
      batches_.push_back(make_batch(equations, &fibers[begin], lanes));
    }
}

void FiberBatches::evaluate(FiberEquations& equations, bool with_tangent) {
  const Level& level = equations.level;
  const double alpha_m = equations.scheme.alpha_m;
  const auto all = [](int) { return true; };
  Work work;
  std::vector<double> part;
  for (FiberBatch& batch : batches_) {
    const std::size_t size = static_cast<std::size_t>(node_dofs * batch.nodes);
    work.resize(size);
    gather(batch, equations.dofs.data(), work.dofs);
    gather(batch, equations.load_values.dead.data(), work.dead);
    for (int lane = 0; lane < batch_size; ++lane) {
      const std::size_t first = batch.first_dof[lane];
      for (std::size_t i = 0; i < size; ++i) {
        work.rate[i].set(
            lane, (1 - alpha_m) * equations.acceleration[first + i] + alpha_m * equations.acceleration_n[first + i]);
        work.other[i].set(lane, equations.internal_n[first + i] - equations.external_n[first + i]);
      }
    }
    evaluate_batch(batch, level, work, with_tangent);
    scatter(batch, work.internal, equations.internal.data(), all);
    scatter(batch, work.full, equations.full.data(), all);
    scatter(batch, work.residual, equations.residual.data(), all);
    for (int lane = 0; lane < batch.lanes; ++lane) {
      const Index f = batch.fiber[lane];
      std::copy_n(&equations.load_values.dead[batch.first_dof[lane]], size, &equations.external[batch.first_dof[lane]]);
      equations.scale[f] = work.scale[lane];
      equations.round_off[f] = equations.round_off_of(f, work.coordinate[lane]);
    }
    if (!with_tangent) continue;
    factorize_batch(batch, equations.downhill, batch.factorized.data());
    for (int lane = 0; lane < batch.lanes; ++lane)
      if (batch.factorized[lane]) equations.singular[batch.fiber[lane]] = 0;
  }
}

void FiberBatches::solve(double* b) const {
  std::vector<Lanes> x;
  for (const FiberBatch& batch : batches_) {
    x.resize(static_cast<std::size_t>(node_dofs * batch.nodes));
    gather(batch, b, x.data());
    solve_batch(batch, x.data());
    scatter(batch, x.data(), b, [&batch](int lane) { return batch.factorized[lane]; });
  }
}

void FiberBatches::solve(Index fiber, double* b, Index columns) const {
  const FiberBatch& batch = batches_[batch_of_[fiber]];
  const Index lane = lane_of_[fiber];
  std::vector<Lanes> x(static_cast<std::size_t>(node_dofs * batch.nodes));
  // The lanes take one column each.
  FiberBatch copy = batch;
  for (Lanes& entry : copy.matrix) entry = Lanes(entry[static_cast<int>(lane)]);
  for (FiberBatch::Support& support : copy.supports)
    for (Lanes& axis : support.axis) axis = Lanes(axis[static_cast<int>(lane)]);
  for (Index begin = 0; begin < columns; begin += batch_size) {
    const int count = static_cast<int>(std::min<Index>(batch_size, columns - begin));
    for (std::size_t i = 0; i < x.size(); ++i)
      for (int c = 0; c < batch_size; ++c) x[i].set(c, c < count ? b[i * columns + begin + c] : 0.0);
    solve_batch(copy, x.data());
    for (std::size_t i = 0; i < x.size(); ++i)
      for (int c = 0; c < count; ++c) b[i * columns + begin + c] = x[i][c];
  }
}

void FiberBatches::compliance(const std::vector<const double*>& d, const std::vector<Index>& rows,
                              const std::function<void(Index, const double*)>& take) const {
  std::vector<Lanes> weights, y, block;
  std::vector<Index> first;
  std::vector<double> one;
  for (const FiberBatch& batch : batches_) {
    const Index functions = 2 * batch.nodes;
    Index most = 0;
    for (int lane = 0; lane < batch.lanes; ++lane)
      if (batch.factorized[lane]) most = std::max(most, rows[batch.fiber[lane]]);
    weights.assign(static_cast<std::size_t>(most) * functions, Lanes(0.0));
    first.assign(most, batch.nodes);
    for (int lane = 0; lane < batch.lanes; ++lane) {
      const Index f = batch.fiber[lane];
      if (!batch.factorized[lane]) continue;
      for (Index r = 0; r < rows[f]; ++r)
        for (Index i = 0; i < functions; ++i) {
          const double weight = d[f][static_cast<std::size_t>(r) * functions + i];
          weights[static_cast<std::size_t>(r) * functions + i].set(lane, weight);
          if (weight != 0.0) first[r] = std::min(first[r], i / 2);
        }
    }
    y.resize(static_cast<std::size_t>(3 * most) * 3 * functions);
    block.resize(9 * static_cast<std::size_t>(most) * most);
    compliance_batch(batch, weights.data(), most, first.data(), y.data(), block.data());
    for (int lane = 0; lane < batch.lanes; ++lane) {
      const Index f = batch.fiber[lane];
      if (!batch.factorized[lane]) continue;
      const Index columns = 3 * rows[f];
      one.resize(static_cast<std::size_t>(columns) * columns);
      for (Index i = 0; i < columns; ++i)
        for (Index j = i - i % 3; j < columns; ++j)
          one[i * columns + j] = one[j * columns + i] = block[static_cast<std::size_t>(3 * most * i + j)][lane];
      take(f, one.data());
    }
  }
}

}  // namespace fbi::beam
