#include "fsi/box_lines.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "linalg/owned_block.hpp"

namespace fbi::fsi {

namespace {

constexpr std::size_t most_lanes = 4;  // lines side by side: each waits for its own last number

}  // namespace

/// A few lines next to each other.
struct BoxLines::Bundle {
  std::size_t first, count, step, side;
  std::size_t line;      // number of the first one
  std::size_t place[2];  // of the first one in the two directions across
  /// A neighbor across: steps to it, and the area of a line's nodes over its own; 0 and 1 where there is none.
  struct Neighbor {
    std::size_t before, after;
    float before_area, after_area;
  };
  Neighbor along[most_lanes], across[most_lanes];  // the way the lanes lie, and the other
  std::size_t node(std::size_t t, std::size_t lane) const { return first + t * step + lane * side; }
};

bool BoxLines::supports(const mesh::HexMesh& mesh) {
  if (!mesh.box) return false;
  return !mesh.comm.any(linalg::owned_range(mesh).size() != static_cast<std::size_t>(mesh.owned_nodes));
}

BoxLines::BoxLines(const fluid::FluidField& fluid) : fluid_(fluid), halo_(fluid.mesh()) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const linalg::IndexBlock block = linalg::owned_range(mesh);
  for (int d = 0; d < 3; ++d) n_[d] = static_cast<std::size_t>(block.extent(d));
  stride_ = {1, n_[0], n_[0] * n_[1]};
  pivots_.resize(mesh.owned_nodes);
  shape_.resize(mesh.local_cells());
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    const Index* nodes = &mesh.cells[8 * c];
    const Vec3 edge = Eigen::Map<const Vec3>(mesh.node(nodes[6])) - Eigen::Map<const Vec3>(mesh.node(nodes[0]));
    shape_[c].inverse_edge = edge.cwiseInverse().cast<float>();
    shape_[c].volume = static_cast<float>(edge.prod());
    shape_[c].inverse_size = static_cast<float>(1.0 / std::cbrt(edge.prod()));
  }
}

/// Calls act(bundle, number of its lanes) for bundles that hold each line once; the number is an integral constant.
template <class Act>
void BoxLines::for_bundles(const Act& act) const {
  const int along = axis_ == 0 ? 1 : 0, other = axis_ == 2 ? 1 : 2;
  Bundle bundle;
  bundle.count = n_[axis_];
  bundle.step = stride_[axis_];
  bundle.side = stride_[along];
  if (bundle.count == 0) return;
  const std::vector<double>& volume = fluid_.lumped_volume();
  const auto neighbor = [&](std::size_t node, std::size_t place, std::size_t places, std::size_t step) {
    Bundle::Neighbor to = {place > 0 ? step : 0, place + 1 < places ? step : 0, 1.0f, 1.0f};
    to.before_area = static_cast<float>(volume[node] / volume[node - to.before]);
    to.after_area = static_cast<float>(volume[node] / volume[node + to.after]);
    return to;
  };
  for (std::size_t j = 0; j < n_[other]; ++j)
    for (std::size_t i = 0; i < n_[along];) {
      const std::size_t width = i + most_lanes <= n_[along] ? most_lanes : 1;
      bundle.first = i * stride_[along] + j * stride_[other];
      bundle.line = i + j * n_[along];
      bundle.place[0] = i;
      bundle.place[1] = j;
      for (std::size_t l = 0; l < width; ++l) {
        bundle.along[l] = neighbor(bundle.node(0, l), i + l, n_[along], bundle.side);
        bundle.across[l] = neighbor(bundle.node(0, l), j, n_[other], stride_[other]);
      }
      if (width == most_lanes)
        act(bundle, std::integral_constant<std::size_t, most_lanes>{});
      else
        act(bundle, std::integral_constant<std::size_t, 1>{});
      i += width;
    }
}

void BoxLines::renew(const VelocityWeight& weight) {
  const Timed timed("velocity lines");
  const mesh::HexMesh& mesh = fluid_.mesh();
  const std::vector<CellFlow>& flow = weight.flow();
  const LineTerms terms(fluid_);
  // int rho tau v_d^2/h_d^2: the direction of most streamline diffusion.
  double streamline[3] = {};
  tau_.resize(shape_.size());
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    const Eigen::Array3f rate = flow[c].velocity.cast<float>().array() * shape_[c].inverse_edge;
    tau_[c] = static_cast<float>(fluid_.tau_streamline(static_cast<Index>(c)));
    for (int d = 0; d < 3; ++d) streamline[d] += tau_[c] * (shape_[c].volume * rate[d] * rate[d]);
  }
  mesh.comm.sum(streamline, 3);
  axis_ = static_cast<int>(std::max_element(streamline, streamline + 3) - streamline);

  set_sides(terms);

  const std::size_t local = static_cast<std::size_t>(mesh.local_nodes());
  rows_.assign(4 * local, 0.0f);
  grad_div_.assign(4 * local, 0.0f);
  const auto add = [](const NodeVector<float>& amount, float* to) { store_node<float>(load_node(to) + amount, to); };
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    const Index* nodes = &mesh.cells[8 * c];
    const CellShape& shape = shape_[c];
    const LineCell cell = {flow[c].velocity.cast<float>().array() * shape.inverse_edge, shape.inverse_edge.square(),
                           shape.inverse_size, tau_[c]};
    const EdgeRows rows = terms.rows(cell, flow[c], axis_);
    const NodeVector<float> first = shape.volume * rows.first, second = shape.volume * rows.second;
    const float diffusion = shape.volume * rows.grad_div;
    const float share = 0.125f * shape.volume * static_cast<float>(flow[c].grad_div);
    for (const auto& ends : line_edges[axis_]) {
      const std::size_t a = 4 * static_cast<std::size_t>(nodes[ends[0]]);
      const std::size_t b = 4 * static_cast<std::size_t>(nodes[ends[1]]);
      add(first, &rows_[a]);
      add(second, &rows_[b]);
      add(NodeVector<float>{0.0f, diffusion, share, 0.0f}, &grad_div_[a]);
      add(NodeVector<float>{diffusion, 0.0f, share, 0.0f}, &grad_div_[b]);
    }
  }
  halo_.add_ghosts(rows_.data());
  halo_.add_ghosts(grad_div_.data());
  for_bundles([&](const Bundle& bundle, auto lanes) { factorize<decltype(lanes)::value>(bundle, terms); });
}

void BoxLines::set_sides(const LineTerms& terms) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  int side = 0;
  for (int d = 0; d < 3; ++d) {
    if (d == axis_) continue;
    std::vector<float>&square = side_square_[side], &across = side_across_[side];
    square.assign(n_[d], 0.0f);
    for (std::size_t i = 0; n_[d] > 1 && i < n_[d]; ++i) {
      const std::size_t before = i > 0 ? i - 1 : 0, after = std::min(i + 1, n_[d] - 1);
      const double length =
          mesh.node(static_cast<Index>(after * stride_[d]))[d] - mesh.node(static_cast<Index>(before * stride_[d]))[d];
      square[i] = static_cast<float>(std::pow(static_cast<double>(after - before) / length, 2));
    }
    across.resize(n_[d]);
    for (std::size_t i = 0; i < n_[d]; ++i) across[i] = terms.across(terms.viscosity() * square[i], 0.0f);
    ++side;
  }
}

/// Pivots of a few lines, from rows_ and grad_div_.
template <std::size_t Lanes>
void BoxLines::factorize(const Bundle& bundle, const LineTerms& terms) {
  const std::vector<double>& volume = fluid_.lumped_volume();
  LineElimination lines[Lanes];
  for (std::size_t l = 0; l < Lanes; ++l) lines[l] = LineElimination(!is_given(fluid_, bundle.node(0, l)));
  for (std::size_t t = 0; t < bundle.count; ++t)
    for (std::size_t l = 0; l < Lanes; ++l) {
      const std::size_t a = bundle.node(t, l);
      const bool free_after = t + 1 < bundle.count && !is_given(fluid_, a + bundle.step);
      LinePivot& pivot = pivots_[a];
      pivot = lines[l].next(&rows_[4 * a], &grad_div_[4 * a], free_after);
      const float tau = grad_div_[4 * a + 2] / static_cast<float>(volume[a]);
      for (int i = 0; i < 2; ++i) {
        const float square = side_square_[i][bundle.place[i] + (i == 0 ? l : 0)];
        pivot.across[i] = terms.across(terms.viscosity() * square, tau * square);
      }
    }
}

std::vector<double> BoxLines::diagonal() {
  // Of L^-1, from the last node of a line: 1/pivot + high (L^-1 of the next node) low/pivot.
  for_bundles([this](const Bundle& bundle, auto lanes) {
    float next[decltype(lanes)::value] = {};
    for (std::size_t t = bundle.count; t-- > 0;)
      for (std::size_t l = 0; l < lanes; ++l) {
        const std::size_t a = bundle.node(t, l);
        const float low_after = t + 1 < bundle.count ? pivots_[a + bundle.step].low[0] : 0.0f;
        next[l] = pivots_[a].inverse[0] * (1.0f + pivots_[a].high[0] * low_after * next[l]);
        rows_[4 * a] = (1.0f + side_across_[0][bundle.place[0] + l]) * next[l];
      }
  });
  halo_.update_ghosts(rows_.data());
  return diagonal_of(fluid_, rows_);
}

template <std::size_t Lanes>
void BoxLines::solve(const Bundle& bundle, const float* r, float* x) const {
  using Node = NodeVector<float>;
  using Pick = NodeVector<std::int32_t>;
  // Which numbers of a pivot belong to which velocity.
  Pick first = {0, 0, 0, 0}, own[2] = {{4, 4, 4, 4}, {4, 4, 4, 4}};
  first[axis_] = 1;
  own[0][axis_ == 0 ? 1 : 0] = 2;
  own[1][axis_ == 2 ? 1 : 2] = 3;
  const Pick second = first + 2;
  Node across[2][Lanes];
  for (std::size_t l = 0; l < Lanes; ++l) {
    across[0][l] = Node{} + side_across_[0][bundle.place[0] + l];
    across[1][l] = Node{} + side_across_[1][bundle.place[1]];
  }
  Node previous[Lanes] = {};
  for (std::size_t t = 0; t < bundle.count; ++t)
    for (std::size_t l = 0; l < Lanes; ++l) {
      const std::size_t a = bundle.node(t, l);
      const Node here = load_node(r + 4 * a), twice = here + here;
      const Bundle::Neighbor &p = bundle.along[l], &q = bundle.across[l];
      const Node along_p =
          twice - p.before_area * load_node(r + 4 * (a - p.before)) - p.after_area * load_node(r + 4 * (a + p.after));
      const Node along_q =
          twice - q.before_area * load_node(r + 4 * (a - q.before)) - q.after_area * load_node(r + 4 * (a + q.after));
      const Node high = pivots_[a].high_and_across(), low = pivots_[a].low_and_inverse();
      const Node b_p = __builtin_shuffle(high, across[0][l], own[0]),
                 b_q = __builtin_shuffle(high, across[1][l], own[1]);
      const Node right = here + 0.5f * (b_p * along_p + b_q * along_q);
      previous[l] = __builtin_shuffle(low, second) * (right - __builtin_shuffle(low, first) * previous[l]);
      store_node(three_and_one<float>(previous[l], load_node(x + 4 * a)), x + 4 * a);
    }
  for (Node& value : previous) value = Node{};
  for (std::size_t t = bundle.count; t-- > 0;)
    for (std::size_t l = 0; l < Lanes; ++l) {
      const std::size_t a = bundle.node(t, l);
      const Node here = load_node(x + 4 * a);
      previous[l] = here - __builtin_shuffle(pivots_[a].high_and_across(), first) * previous[l];
      store_node(three_and_one<float>(previous[l], here), x + 4 * a);
    }
}

void BoxLines::apply(const float* r, float* x, const std::vector<char>* only) const {
  for_bundles([&](const Bundle& bundle, auto lanes) {
    if (only != nullptr) {
      const auto first = only->begin() + static_cast<std::ptrdiff_t>(bundle.line);
      if (std::all_of(first, first + lanes, [](char wanted) { return wanted == 0; })) return;
    }
    solve<decltype(lanes)::value>(bundle, r, x);
  });
}

std::vector<char> BoxLines::reached(const std::vector<Index>& nodes) const {
  const int along = axis_ == 0 ? 1 : 0, other = axis_ == 2 ? 1 : 2;
  std::vector<char> lines(n_[along] * n_[other], 0);
  for (const Index node : nodes) {
    const std::size_t i = node / stride_[along] % n_[along], j = node / stride_[other] % n_[other];
    const std::size_t line = i + j * n_[along];
    lines[line] = 1;
    if (i > 0) lines[line - 1] = 1;
    if (i + 1 < n_[along]) lines[line + 1] = 1;
    if (j > 0) lines[line - n_[along]] = 1;
    if (j + 1 < n_[other]) lines[line + n_[along]] = 1;
  }
  return lines;
}

std::vector<char> BoxLines::nodes_of(const std::vector<char>& lines) const {
  const int along = axis_ == 0 ? 1 : 0, other = axis_ == 2 ? 1 : 2;
  std::vector<char> nodes(n_[0] * n_[1] * n_[2]);
  std::size_t a = 0;
  std::array<std::size_t, 3> place;
  for (place[2] = 0; place[2] < n_[2]; ++place[2])
    for (place[1] = 0; place[1] < n_[1]; ++place[1])
      for (place[0] = 0; place[0] < n_[0]; ++place[0]) nodes[a++] = lines[place[along] + place[other] * n_[along]];
  return nodes;
}

}  // namespace fbi::fsi
