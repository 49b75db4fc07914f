#include "fsi/mesh_lines.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "base/counters.hpp"
#include "base/timer.hpp"

namespace fbi::fsi {

namespace {

constexpr int most_renewals = 16;     // with the same lines: flows turn slowly
constexpr float mean_across = 0.25f;  // B

}  // namespace

MeshLines::MeshLines(const fluid::FluidField& fluid) : fluid_(fluid), halo_(fluid.mesh()) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  shape_.resize(mesh.local_cells());
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    const Mat3 edges = middle_edges(mesh, static_cast<Index>(c));
    const double volume = std::abs(edges.determinant());
    shape_[c].gradient = edges.inverse().cast<float>();
    shape_[c].squares = shape_[c].gradient.rowwise().squaredNorm().array();
    shape_[c].volume = static_cast<float>(volume);
    shape_[c].inverse_size = static_cast<float>(1.0 / std::cbrt(volume));
  }
  find_edges();
}

/// Edges between owned nodes, each once, and those of the cells.
void MeshLines::find_edges() {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const Index owned = mesh.owned_nodes;
  std::vector<std::vector<Index>> above(owned);
  const auto for_edges = [&](const auto& act) {
    for (std::size_t c = 0; c < shape_.size(); ++c)
      for (int d = 0; d < 3; ++d)
        for (int e = 0; e < 4; ++e) {
          const Index a = mesh.cells[8 * c + line_edges[d][e][0]], b = mesh.cells[8 * c + line_edges[d][e][1]];
          act(12 * c + 4 * d + e, std::min(a, b), std::max(a, b));
        }
  };
  for_edges([&](std::size_t, Index low, Index high) {
    if (high >= owned) return;
    std::vector<Index>& list = above[low];
    if (std::find(list.begin(), list.end(), high) == list.end()) list.push_back(high);
  });
  std::vector<std::int32_t> first(owned);
  for (Index a = 0; a < owned; ++a) {
    first[a] = static_cast<std::int32_t>(edges_.size());
    for (const Index b : above[a]) edges_.push_back({a, b});
  }
  cell_edge_.assign(12 * shape_.size(), -1);
  for_edges([&](std::size_t k, Index low, Index high) {
    if (high >= owned) return;
    const std::vector<Index>& list = above[low];
    cell_edge_[k] = first[low] + static_cast<std::int32_t>(std::find(list.begin(), list.end(), high) - list.begin());
  });
}

LineCell MeshLines::cell_of(Index c, const CellFlow& flow) const {
  const CellShape& shape = shape_[c];
  return {(shape.gradient * flow.velocity.cast<float>()).array(), shape.squares, shape.inverse_size,
          static_cast<float>(fluid_.tau_streamline(c))};
}

/// For each owned node its neighbors on a line, -1 for none, shape=(owned nodes,2): edges that are among the two
/// strongest of both ends.
std::vector<Index> MeshLines::links(const std::vector<float>& strength) const {
  const std::size_t owned = static_cast<std::size_t>(fluid_.mesh().owned_nodes);
  std::vector<std::array<std::int32_t, 2>> best(owned, {-1, -1});
  const auto offer = [&](Index node, std::int32_t edge) {
    std::array<std::int32_t, 2>& two = best[node];
    const auto weaker = [&](std::int32_t other) { return other < 0 || strength[other] < strength[edge]; };
    if (weaker(two[0]))
      two = {edge, two[0]};
    else if (weaker(two[1]))
      two[1] = edge;
  };
  for (std::size_t e = 0; e < edges_.size(); ++e) {
    if (!(strength[e] > 0.0f)) continue;
    offer(edges_[e].low, static_cast<std::int32_t>(e));
    offer(edges_[e].high, static_cast<std::int32_t>(e));
  }
  std::vector<Index> neighbors(2 * owned, -1);
  for (std::size_t a = 0; a < owned; ++a)
    for (int i = 0; i < 2; ++i) {
      const std::int32_t e = best[a][i];
      if (e < 0) continue;
      const Index other = edges_[e].low == static_cast<Index>(a) ? edges_[e].high : edges_[e].low;
      if (best[other][0] == e || best[other][1] == e) neighbors[2 * a + i] = other;
    }
  return neighbors;
}

void MeshLines::choose(const std::vector<CellFlow>& flow) {
  count("choices of lines");
  const float density = static_cast<float>(fluid_.parameters().density);
  const float viscosity = static_cast<float>(fluid_.parameters().viscosity);
  direction_.resize(shape_.size());
  std::vector<float> strength(edges_.size(), 0.0f);
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    const LineCell cell = cell_of(static_cast<Index>(c), flow[c]);
    const Eigen::Array3f diffusion = density * density * cell.tau * cell.rate.square() + viscosity * cell.squares;
    int d = 0;
    const float most = diffusion.maxCoeff(&d);
    direction_[c] = static_cast<std::int8_t>(d);
    for (int e = 0; e < 4; ++e)
      if (const std::int32_t edge = cell_edge_[12 * c + 4 * d + e]; edge >= 0)
        strength[edge] += shape_[c].volume * most;
  }
  const std::vector<Index> neighbors = links(strength);
  const std::size_t owned = neighbors.size() / 2;
  std::vector<char> taken(owned, 0);
  std::vector<std::vector<Index>> lines;
  const auto walk = [&](std::size_t start) {
    std::vector<Index>& line = lines.emplace_back();
    for (Index a = static_cast<Index>(start); a >= 0;) {
      line.push_back(a);
      taken[a] = 1;
      Index next = -1;
      for (int i = 1; i >= 0; --i)
        if (const Index b = neighbors[2 * static_cast<std::size_t>(a) + i]; b >= 0 && taken[b] == 0) next = b;
      a = next;
    }
  };
  for (std::size_t a = 0; a < owned; ++a)
    if (taken[a] == 0 && (neighbors[2 * a] < 0 || neighbors[2 * a + 1] < 0)) walk(a);
  for (std::size_t a = 0; a < owned; ++a)  // rings are left
    if (taken[a] == 0) walk(a);
  std::stable_sort(lines.begin(), lines.end(), [](const auto& a, const auto& b) { return a.size() > b.size(); });
  set_lines(lines);
}

void MeshLines::set_lines(const std::vector<std::vector<Index>>& lines) {
  std::vector<Index> slots;
  std::vector<Bundle> bundles;
  line_count_ = static_cast<Index>(lines.size());
  places_.assign(4 * static_cast<std::size_t>(fluid_.mesh().local_nodes()), -1.0f);
  const float owner = static_cast<float>(fluid_.mesh().comm.rank());
  for (std::size_t line = 0; line < lines.size(); line += most_lanes) {
    Bundle& bundle = bundles.emplace_back();
    bundle.first = slots.size();
    bundle.line = static_cast<Index>(line);
    bundle.lanes = static_cast<int>(std::min<std::size_t>(most_lanes, lines.size() - line));
    slots.resize(slots.size() + most_lanes * lines[line].size(), -1);
    for (int l = 0; l < bundle.lanes; ++l) {
      const std::vector<Index>& nodes = lines[line + l];
      bundle.count[l] = static_cast<Index>(nodes.size());
      for (std::size_t t = 0; t < nodes.size(); ++t) {
        slots[bundle.first + most_lanes * t + l] = nodes[t];
        const NodeVector<float> place = {owner, static_cast<float>(line + l), static_cast<float>(t), 0.0f};
        store_node<float>(place, &places_[4 * static_cast<std::size_t>(nodes[t])]);
      }
    }
  }
  halo_.update_ghosts(places_.data());
  if (slots == slots_ && bundles == bundles_) return;
  slots_ = std::move(slots);
  bundles_ = std::move(bundles);
  ++version_;
  find_neighbors();
}

/// 1 when `second` follows `first` on a line, -1 the other way round, else 0.
int MeshLines::link(Index first, Index second) const {
  const NodeVector<float> to = load_node(&places_[4 * static_cast<std::size_t>(second)]) -
                               load_node(&places_[4 * static_cast<std::size_t>(first)]);
  if (to[0] != 0.0f || to[1] != 0.0f) return 0;
  return to[2] == 1.0f ? 1 : to[2] == -1.0f ? -1 : 0;
}

void MeshLines::find_neighbors() {
  const std::vector<double>& volume = fluid_.lumped_volume();
  std::vector<Index> slot_of(fluid_.mesh().owned_nodes);
  for (std::size_t s = 0; s < slots_.size(); ++s)
    if (slots_[s] >= 0) slot_of[slots_[s]] = static_cast<Index>(s);
  neighbor_begin_.assign(slots_.size() + 1, 0);
  const auto for_pairs = [&](const auto& act) {
    for (const Edge& edge : edges_) {
      if (link(edge.low, edge.high) != 0) continue;
      act(edge.low, edge.high);
      act(edge.high, edge.low);
    }
  };
  for_pairs([&](Index a, Index) { ++neighbor_begin_[slot_of[a] + 1]; });
  for (std::size_t s = 0; s < slots_.size(); ++s) neighbor_begin_[s + 1] += neighbor_begin_[s];
  neighbor_.resize(neighbor_begin_.back());
  neighbor_area_.resize(neighbor_.size());
  std::vector<Index> next(neighbor_begin_.begin(), neighbor_begin_.end() - 1);
  for_pairs([&](Index a, Index b) {
    const Index k = next[slot_of[a]]++;
    neighbor_[k] = b;
    neighbor_area_[k] = static_cast<float>(volume[a] / volume[b]);
  });
}

void MeshLines::renew(const VelocityWeight& weight) {
  const Timed timed("velocity lines");
  const mesh::HexMesh& mesh = fluid_.mesh();
  const std::vector<CellFlow>& flow = weight.flow();
  if (renewals_ == next_choice_) {
    choose(flow);
    next_choice_ += std::clamp(renewals_, 1, most_renewals);
  }
  ++renewals_;
  const LineTerms terms(fluid_);
  rows_.assign(4 * static_cast<std::size_t>(mesh.local_nodes()), 0.0f);
  const auto turned = [](const NodeVector<float>& row) { return NodeVector<float>{row[1], row[0], row[2], row[3]}; };
  for (std::size_t c = 0; c < shape_.size(); ++c) {
    EdgeRows rows = terms.rows(cell_of(static_cast<Index>(c), flow[c]), flow[c], direction_[c]);
    const NodeVector<float> grad_div = {0.0f, 0.0f, rows.mean_grad_div, rows.mean_grad_div};
    rows.first += grad_div;
    rows.second += grad_div;
    const NodeVector<float> lump = {0.0f, 0.0f, rows.lump, rows.lump};
    const auto add = [&](Index node, const NodeVector<float>& row) {
      float* to = &rows_[4 * static_cast<std::size_t>(node)];
      store_node<float>(load_node(to) + shape_[c].volume * row, to);
    };
    for (const auto& ends : line_edges[direction_[c]]) {
      const Index first = mesh.cells[8 * c + ends[0]], second = mesh.cells[8 * c + ends[1]];
      const int way = link(first, second);
      if (way == 0) {
        add(first, NodeVector<float>{0.0f, 0.0f, rows.first[2], rows.first[3]} + lump);
        add(second, NodeVector<float>{0.0f, 0.0f, rows.second[2], rows.second[3]} + lump);
      } else {
        add(first, way > 0 ? rows.first : turned(rows.first));
        add(second, way > 0 ? rows.second : turned(rows.second));
      }
    }
  }
  halo_.add_ghosts(rows_.data());
  factorize();
}

/// Calls act(t, number of lanes that have a node t) in ascending order; the number is an integral constant.
template <class Act>
void MeshLines::for_places(const Bundle& bundle, const Act& act) {
  const auto pass = [&](auto lanes) {
    const Index begin = lanes == most_lanes ? 0 : bundle.count[lanes];
    for (Index t = begin; t < bundle.count[lanes - 1]; ++t) act(static_cast<std::size_t>(t), lanes);
  };
  pass(std::integral_constant<int, 4>{});
  pass(std::integral_constant<int, 3>{});
  pass(std::integral_constant<int, 2>{});
  pass(std::integral_constant<int, 1>{});
}

template <class Act>
void MeshLines::for_places_backwards(const Bundle& bundle, const Act& act) {
  const auto pass = [&](auto lanes) {
    const Index begin = lanes == most_lanes ? 0 : bundle.count[lanes];
    for (Index t = bundle.count[lanes - 1]; t-- > begin;) act(static_cast<std::size_t>(t), lanes);
  };
  pass(std::integral_constant<int, 1>{});
  pass(std::integral_constant<int, 2>{});
  pass(std::integral_constant<int, 3>{});
  pass(std::integral_constant<int, 4>{});
}

/// Pivots, from rows_.
void MeshLines::factorize() {
  low_.resize(slots_.size());
  inverse_.resize(slots_.size());
  high_.resize(slots_.size());
  constexpr float nothing[2] = {};
  for (const Bundle& bundle : bundles_)
    for (int l = 0; l < bundle.lanes; ++l) {
      LineElimination line(!is_given(fluid_, slots_[bundle.first + l]));
      for (Index t = 0; t < bundle.count[l]; ++t) {
        const std::size_t s = bundle.first + most_lanes * static_cast<std::size_t>(t) + l;
        const bool free_after = t + 1 < bundle.count[l] && !is_given(fluid_, slots_[s + most_lanes]);
        const LinePivot pivot = line.next(&rows_[4 * static_cast<std::size_t>(slots_[s])], nothing, free_after);
        low_[s] = pivot.low[0];
        inverse_[s] = pivot.inverse[0];
        high_[s] = pivot.high[0];
      }
    }
}

std::vector<double> MeshLines::diagonal() {
  // Of L^-1, from the last node of a line: 1/pivot + high (L^-1 of the next node) low/pivot.
  for (const Bundle& bundle : bundles_)
    for (int l = 0; l < bundle.lanes; ++l) {
      float next = 0.0f;
      for (Index t = bundle.count[l]; t-- > 0;) {
        const std::size_t s = bundle.first + most_lanes * static_cast<std::size_t>(t) + l;
        const float low_after = t + 1 < bundle.count[l] ? low_[s + most_lanes] : 0.0f;
        next = inverse_[s] * (1.0f + high_[s] * low_after * next);
        rows_[4 * static_cast<std::size_t>(slots_[s])] = (1.0f + mean_across) * next;
      }
    }
  halo_.update_ghosts(rows_.data());
  return diagonal_of(fluid_, rows_);
}

void MeshLines::apply(const float* r, float* x, const std::vector<char>* only) const {
  using Node = NodeVector<float>;
  for (const Bundle& bundle : bundles_) {
    if (only != nullptr) {
      const auto first = only->begin() + bundle.line;
      if (std::all_of(first, first + bundle.lanes, [](char wanted) { return wanted == 0; })) continue;
    }
    Node previous[most_lanes] = {};
    for_places(bundle, [&](std::size_t t, auto lanes) {
      for (int l = 0; l < lanes; ++l) {
        const std::size_t s = bundle.first + most_lanes * t + l, a = slots_[s];
        const Node here = load_node(r + 4 * a);
        Node across = {};
        for (Index k = neighbor_begin_[s]; k < neighbor_begin_[s + 1]; ++k)
          across += here - neighbor_area_[k] * load_node(r + 4 * static_cast<std::size_t>(neighbor_[k]));
        const Node right = here + 0.5f * mean_across * across;
        previous[l] = inverse_[s] * (right - low_[s] * previous[l]);
        store_node(three_and_one<float>(previous[l], load_node(x + 4 * a)), x + 4 * a);
      }
    });
    for (Node& value : previous) value = Node{};
    for_places_backwards(bundle, [&](std::size_t t, auto lanes) {
      for (int l = 0; l < lanes; ++l) {
        const std::size_t s = bundle.first + most_lanes * t + l, a = slots_[s];
        const Node here = load_node(x + 4 * a);
        previous[l] = here - high_[s] * previous[l];
        store_node(three_and_one<float>(previous[l], here), x + 4 * a);
      }
    });
  }
}

std::vector<char> MeshLines::reached(const std::vector<Index>& nodes) const {
  std::vector<char> touched(fluid_.mesh().owned_nodes, 0), lines(line_count_, 0);
  for (const Index node : nodes) touched[node] = 1;
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    if (slots_[s] < 0) continue;
    bool here = touched[slots_[s]] != 0;
    for (Index k = neighbor_begin_[s]; k < neighbor_begin_[s + 1]; ++k) here = here || touched[neighbor_[k]] != 0;
    if (here) lines[line_of(slots_[s])] = 1;
  }
  return lines;
}

std::vector<char> MeshLines::nodes_of(const std::vector<char>& lines) const {
  std::vector<char> nodes(fluid_.mesh().owned_nodes);
  for (std::size_t a = 0; a < nodes.size(); ++a) nodes[a] = lines[line_of(static_cast<Index>(a))];
  return nodes;
}

std::vector<std::vector<Index>> MeshLines::lines() const {
  std::vector<std::vector<Index>> lines(line_count_);
  for (const Bundle& bundle : bundles_)
    for (int l = 0; l < bundle.lanes; ++l)
      for (Index t = 0; t < bundle.count[l]; ++t)
        lines[bundle.line + l].push_back(slots_[bundle.first + most_lanes * static_cast<std::size_t>(t) + l]);
  return lines;
}

}  // namespace fbi::fsi
