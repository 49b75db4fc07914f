#include "coupling/coupling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "coupling/cutting.hpp"
#include "coupling/fiber_side.hpp"
#include "coupling/interface_law.hpp"
#include "coupling/local_m.hpp"
#include "coupling/row_exchange.hpp"

namespace fbi::coupling {

namespace {

constexpr double allowed_outside = 0.01;   ///< of a fiber's length
constexpr double noticed_outside = 1e-9;   ///< of a fiber's length: less is round-off
constexpr double allowed_identity = 1e-8;  ///< of M.1 = kappa, relative

std::vector<GlobalIndex> row_offsets(const Comm& comm, Index rows) {
  std::vector<GlobalIndex> offsets(comm.size() + 1, 0);
  const GlobalIndex own = rows;
  MPI_Allgather(&own, 1, MPI_INT64_T, offsets.data() + 1, 1, MPI_INT64_T, comm.get());
  for (int r = 0; r < comm.size(); ++r) offsets[r + 1] += offsets[r];
  return offsets;
}

/// `text` of the lowest rank whose `mine` is true, on every rank. Collective.
std::string text_from(const Comm& comm, bool mine, const std::string& text) {
  const GlobalIndex root = -comm.max(static_cast<GlobalIndex>(mine ? -comm.rank() : -comm.size()));
  if (root >= comm.size()) return {};
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, static_cast<int>(root), comm.get());
  std::string result = comm.rank() == root ? text : std::string(length, ' ');
  MPI_Bcast(result.data(), length, MPI_CHAR, static_cast<int>(root), comm.get());
  return result;
}

}  // namespace

struct Coupling::Implementation {
  Implementation(const mesh::HexMesh& fluid_mesh, const mesh::FiberMesh& fiber_mesh, const CouplingParameters& given)
      : fluid(fluid_mesh),
        fibers(fiber_mesh),
        parameters(given),
        exchange(fluid_mesh.comm),
        cutting(fluid_mesh, exchange, parameters.periods),
        side(fiber_mesh, given.multiplier, given.gauss_points) {
    if (given.automatic) law = std::make_unique<OwnRadiusLaw>(fluid, exchange, parameters.viscosity);
    GlobalIndex sets = 0;
    for (const Index group : fibers.group) sets = std::max<GlobalIndex>(sets, group + 1);
    sets = exchange.comm().max(sets);
    worst.resize(sets);
    warned.resize(sets, false);
    elements.resize(fibers.elements());
    for (Index f = 0; f < fibers.fibers(); ++f) {
      for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e) {
        const Index node = e + f;
        double dofs[12];
        for (int n = 0; n < 2; ++n)
          for (int i = 0; i < 3; ++i) {
            dofs[6 * n + i] = fibers.position[3 * static_cast<std::size_t>(node + n) + i];
            dofs[6 * n + 3 + i] = fibers.tangent[3 * static_cast<std::size_t>(node + n) + i];
          }
        elements[e].curve = hermite_curve(dofs, dofs + 6, fibers.element_length[e]);
        elements[e].measure = make_measure(elements[e].curve);
        if (!parameters.radius.empty()) elements[e].radius = parameters.radius.at(fibers.group[f]);
      }
    }
    offsets = row_offsets(exchange.comm(), side.first_row(fibers.fibers()));
  }

  /// Cells of the given elements. Collective.
  void find_segments(const std::vector<ElementGeometry>& some, ElementSegments& result) {
    if (parameters.integration == Integration::element)
      cutting.place_points(some, side.rule(), result);
    else
      cutting.cut(some, result);
  }

  /// 1 for elements whose curve is, bit by bit, the one that was cut last: their segments are what a new search finds.
  std::vector<char> unchanged_elements() const {
    std::vector<char> kept(elements.size(), 0);
    for (std::size_t e = 0; e < cut_curves.size(); ++e) kept[e] = cut_curves[e] == elements[e].curve;
    return kept;
  }

  /// Cells of all elements, then the numbers of rows. Collective.
  void cut() {
    const std::vector<char> kept = unchanged_elements();
    const GlobalIndex reused = std::count(kept.begin(), kept.end(), 1);
    count_parts("elements cut", static_cast<GlobalIndex>(elements.size()) - reused);
    count_parts("elements with old segments", reused);
    if (reused == 0) {
      find_segments(elements, cuts);
    } else {
      std::vector<ElementGeometry> moved;
      for (std::size_t e = 0; e < elements.size(); ++e)
        if (!kept[e]) moved.push_back(elements[e]);
      ElementSegments news;
      find_segments(moved, news);
      merge_segments(kept, news, cuts);
    }
    cut_curves.resize(elements.size());
    for (std::size_t e = 0; e < elements.size(); ++e) cut_curves[e] = elements[e].curve;
    const Index rows = side.number_rows(cuts);
    if (!side.basis().is_lagrange()) offsets = row_offsets(exchange.comm(), rows);
    for (Index e = 0; e < fibers.elements(); ++e)
      elements[e].row = offsets[exchange.comm().rank()] + side.first_row_of_element(e);
  }

  void set_curves(const std::vector<double>& dofs) {
    for (Index f = 0; f < fibers.fibers(); ++f)
      for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e) {
        const double* first = &dofs[6 * static_cast<std::size_t>(e + f)];
        elements[e].curve = hermite_curve(first, first + 6, fibers.element_length[e]);
      }
  }

  /// D, kappa and the coverage of this rank's fibers.
  void integrate_fibers() {
    side.integrate(elements, cuts);
    own_coverage = Coverage();
    own_coverage.segments = side.segments();
    std::fill(worst.begin(), worst.end(), Worst());
    for (Index f = 0; f < fibers.fibers(); ++f) {
      const double covered = side.lengths()[2 * f], outside = side.lengths()[2 * f + 1];
      own_coverage.covered += covered;
      own_coverage.outside += outside;
      const double fraction = outside > 0.0 ? outside / (covered + outside) : 0.0;
      if (fraction > noticed_outside) ++own_coverage.fibers_outside;
      own_coverage.worst_fraction = std::max(own_coverage.worst_fraction, fraction);
      Worst& set = worst[fibers.group[f]];
      if (fraction > set.fraction) set = {fraction, f};
    }
  }

  /// S of the interface law. Collective.
  void renew_law() {
    const std::vector<double>& kappa = side.kappa();
    interface_rows.assign(kappa.size(), Symmetric{});
    if (law != nullptr) {
      if (has_stabilization) law->evaluate(stabilization, interface_rows);
      return;
    }
    for (std::size_t p = 0; p < kappa.size(); ++p) {
      const double value = kappa[p] / parameters.penalty;
      interface_rows[p] = {value, 0.0, 0.0, value, 0.0, value};
    }
  }

  /// Largest |M.1 - kappa| and |D.1 - kappa| on this rank [length]. Collective.
  double largest_identity_error() const {
    const std::vector<double>& kappa = side.kappa();
    std::vector<double> touched(m.row.size(), 0.0), sums(kappa.size(), 0.0);
    for (std::size_t i = 0; i < m.row.size(); ++i)
      for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k) touched[i] += m.value[k];
    rows->add_to_owners(touched.data(), 1, sums.data());
    double largest = 0.0;
    for (Index f = 0; f < fibers.fibers(); ++f) {
      const Index first = side.first_row(f), nodes = fibers.first_node[f + 1] - fibers.first_node[f];
      for (Index p = 0; p < side.first_row(f + 1) - first; ++p) {
        double d_sum = 0.0;
        for (Index j = 0; j < nodes; ++j) d_sum += side.d_block(f)[static_cast<std::size_t>(p) * 2 * nodes + 2 * j];
        largest = std::max({largest, std::abs(sums[first + p] - kappa[first + p]), std::abs(d_sum - kappa[first + p])});
      }
    }
    return largest;
  }

  /// Adds up the coverage of all ranks. Collective.
  void reduce_coverage() {
    const Comm& comm = exchange.comm();
    coverage = own_coverage;
    double sums[4] = {own_coverage.covered, own_coverage.outside, static_cast<double>(own_coverage.fibers_outside),
                      static_cast<double>(own_coverage.segments)};
    comm.sum(sums, 4);
    coverage.covered = sums[0];
    coverage.outside = sums[1];
    coverage.fibers_outside = static_cast<GlobalIndex>(sums[2]);
    coverage.segments = static_cast<GlobalIndex>(sums[3]);
    const double own[3] = {own_coverage.worst_fraction, largest_identity_error(),
                           side.kappa().empty() ? 0.0 : *std::max_element(side.kappa().begin(), side.kappa().end())};
    double largest[3];
    MPI_Allreduce(own, largest, 3, MPI_DOUBLE, MPI_MAX, comm.get());
    coverage.worst_fraction = largest[0];
    coverage.identity_error = largest[2] > 0.0 ? largest[1] / largest[2] : 0.0;
    coverage.worst_fiber.clear();
    if (!seen && fibers.global_fibers > 0 && !(coverage.covered > 0.0) && parameters.outside == Outside::allow) {
      // Linear and pointwise multipliers are zero until a fiber enters; those of higher order have no such safe start.
      if (side.basis().order() > 1)
        throw Error(
            ExitCode::geometry,
            "no part of any fiber lies in the fluid: quadratic and cubic multipliers have no equations; move the "
            "fibers into the fluid, or use \"multiplier\": \"linear\"");
      log::warning("no part of any fiber lies in the fluid: nothing is coupled until a fiber enters it");
    }
    seen = true;
    if (coverage.worst_fraction > noticed_outside) report_outside();
  }

  /// Name of the fiber of set `group` that lies outside most (of several the first in the file), on every rank;
  /// `fraction` is its part outside. Collective.
  std::string worst_of(std::size_t group, double& fraction) const {
    const Comm& comm = exchange.comm();
    fraction = comm.max(worst[group].fraction);
    const bool candidate = worst[group].fiber >= 0 && worst[group].fraction == fraction;
    const GlobalIndex id = candidate ? fibers.fiber_id[worst[group].fiber] : std::numeric_limits<GlobalIndex>::max();
    const GlobalIndex first = -comm.max(-id);
    const bool mine = candidate && id == first;
    return text_from(comm, mine, mine ? fibers.name[worst[group].fiber] : std::string());
  }

  /// Names the worst fiber, warns once for each fiber set, and throws where more is outside than allowed. The same on
  /// every rank. Collective.
  void report_outside() {
    for (std::size_t group = 0; group < worst.size(); ++group) {
      double fraction = 0.0;
      const std::string name = worst_of(group, fraction);
      if (fraction == coverage.worst_fraction && coverage.worst_fiber.empty()) coverage.worst_fiber = name;
      if (fraction <= noticed_outside || warned[group]) continue;
      if (fraction > allowed_outside && parameters.outside == Outside::error) continue;  // the error says it
      warned[group] = true;
      log::warning(
          "fiber '%s' lies %.3g %% outside the fluid mesh (fibers that reach outside: %lld): no fluid force acts there",
          name.c_str(), 100.0 * fraction, static_cast<long long>(coverage.fibers_outside));
    }
    if (coverage.worst_fraction > allowed_outside && parameters.outside == Outside::error)
      throw Error(ExitCode::geometry,
                  log::format("fiber '%s' lies %.3g %% outside the fluid mesh (allowed: %g %% of its length): move it, "
                              "enlarge the channel, or allow it with \"outside\": \"allow\"",
                              coverage.worst_fiber.c_str(), 100.0 * coverage.worst_fraction, 100.0 * allowed_outside));
  }

  const mesh::HexMesh& fluid;
  const mesh::FiberMesh& fibers;
  CouplingParameters parameters;
  search::SparseExchange exchange;
  Cutting cutting;
  FiberSide side;
  std::unique_ptr<OwnRadiusLaw> law;         ///< null for a number epsilon
  std::vector<CellViscosity> stabilization;  ///< shape=(local cells), for the law
  bool has_stabilization = false;
  std::vector<Symmetric> interface_rows;
  std::vector<GlobalIndex> offsets;       ///< first row of each rank, shape=(ranks+1)
  std::vector<ElementGeometry> elements;  ///< of this rank's fibers
  std::vector<Curve> cut_curves;          ///< of the elements, that `cuts` belong to; empty at first
  ElementSegments cuts;
  Pieces pieces;
  LocalM m;
  std::unique_ptr<RowExchange> rows;
  Coverage own_coverage, coverage;
  struct Worst {
    double fraction = 0.0;  ///< outside
    Index fiber = -1;       ///< local
  };
  std::vector<Worst> worst;  ///< of each fiber set, on this rank
  std::vector<bool> warned;  ///< for each fiber set
  bool seen = false;         ///< some positions have been searched
};

Coupling::Coupling(const mesh::HexMesh& fluid, const mesh::FiberMesh& fibers, const CouplingParameters& parameters)
    : implementation_(std::make_unique<Implementation>(fluid, fibers, parameters)) {}

Coupling::~Coupling() = default;

void Coupling::update(const std::vector<double>& dofs) {
  const Timed timed("coupling operators");
  Implementation& my = *implementation_;
  const bool finite = std::all_of(dofs.begin(), dofs.end(), [](double value) { return std::isfinite(value); });
  if (my.exchange.comm().any(!finite))
    throw Error(ExitCode::diverged,
                "the fibers have positions that are not numbers: reduce the time step or the loads");
  count("searches");
  my.set_curves(dofs);
  {
    const Timed search("search and cut");
    my.cut();
  }
  my.integrate_fibers();
  Index failed = 0;
  {
    const Timed assembly("integrate M");
    count("builds of M");
    my.cutting.deliver(my.elements, my.cuts, my.pieces);
    failed = my.parameters.kernel == Operator::ring
                 ? assemble_ring_m(my.fluid, my.pieces, my.side.rule(), my.side.basis(), my.cutting, my.exchange, my.m)
                 : assemble_m(my.fluid, my.pieces, my.side.rule(), my.side.basis(), my.m);
    if (my.law != nullptr) my.law->set_points(my.pieces, my.side.rule(), my.side.basis(), my.offsets);
  }
  my.rows = std::make_unique<RowExchange>(my.exchange, my.offsets, my.m.row);
  my.reduce_coverage();
  if (my.exchange.comm().any(failed > 0) || my.coverage.identity_error > allowed_identity)
    throw Error(
        ExitCode::geometry,
        log::format("the coupling operators violate M.1 = kappa by %.2g: a fluid cell crossed by a fiber is inverted "
                    "or degenerate; check the mesh",
                    my.coverage.identity_error));
  my.renew_law();
}

bool Coupling::needs_stabilization() const { return implementation_->law != nullptr; }

void Coupling::set_stabilization(std::vector<CellViscosity> cells) {
  implementation_->stabilization = std::move(cells);
  implementation_->has_stabilization = true;
  if (implementation_->rows != nullptr) implementation_->renew_law();
}

const std::vector<Symmetric>& Coupling::interface_rows() const { return implementation_->interface_rows; }
std::vector<double> Coupling::at_nodes(const std::vector<double>& lambda) const {
  return implementation_->side.at_nodes(lambda);
}
bool Coupling::has_fixed_rows() const { return implementation_->side.basis().is_lagrange(); }

Index Coupling::rows() const { return first_row_of(implementation_->fibers.fibers()); }
GlobalIndex Coupling::first_row() const { return implementation_->offsets[implementation_->exchange.comm().rank()]; }
GlobalIndex Coupling::global_rows() const { return implementation_->offsets.back(); }
Index Coupling::first_row_of(Index fiber) const { return implementation_->side.first_row(fiber); }
const std::vector<double>& Coupling::kappa() const { return implementation_->side.kappa(); }
const std::vector<double>& Coupling::d_block(Index fiber) const { return implementation_->side.d_block(fiber); }
const LocalM& Coupling::local_m() const { return implementation_->m; }
const Coverage& Coupling::coverage() const { return implementation_->coverage; }

template <class T>
void Coupling::interpolate(const T* nodal, double* out) const {
  const LocalM& m = implementation_->m;
  std::vector<double> touched(3 * m.row.size());
  for (std::size_t i = 0; i < m.row.size(); ++i) {
    // Four sums, so that none waits for the last one.
    NodeVector<T> sums[4] = {};
    const auto add = [&](Index k, NodeVector<T>& sum) {
      sum += static_cast<T>(m.value[k]) * load_node(nodal + 4 * static_cast<std::size_t>(m.node[k]));
    };
    Index k = m.begin[i];
    for (; k + 4 <= m.begin[i + 1]; k += 4)
      for (int j = 0; j < 4; ++j) add(k + j, sums[j]);
    for (; k < m.begin[i + 1]; ++k) add(k, sums[0]);
    const NodeVector<T> sum = (sums[0] + sums[1]) + (sums[2] + sums[3]);
    for (int c = 0; c < 3; ++c) touched[3 * i + c] = sum[c];
  }
  std::fill(out, out + 3 * static_cast<std::size_t>(rows()), 0.0);
  implementation_->rows->add_to_owners(touched.data(), 3, out);
}

template <class T>
void Coupling::spread(const double* lambda, T* nodal, double scale) const {
  const LocalM& m = implementation_->m;
  std::vector<double> touched(3 * m.row.size(), 0.0);
  implementation_->rows->copy_from_owners(lambda, 3, touched.data());
  for (std::size_t i = 0; i < m.row.size(); ++i) {
    const double* l = &touched[3 * i];
    const NodeVector<T> force = {static_cast<T>(scale * l[0]), static_cast<T>(scale * l[1]),
                                 static_cast<T>(scale * l[2]), T(0)};
    for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k) {
      T* f = nodal + 4 * static_cast<std::size_t>(m.node[k]);
      store_node<T>(load_node(f) + static_cast<T>(m.value[k]) * force, f);
    }
  }
}

template void Coupling::interpolate(const double*, double*) const;
template void Coupling::interpolate(const float*, double*) const;
template void Coupling::spread(const double*, double*, double) const;
template void Coupling::spread(const double*, float*, double) const;

void Coupling::apply_d(const std::vector<double>& q, double* out) const {
  const mesh::FiberMesh& fibers = implementation_->fibers;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    const std::size_t first = fibers.first_node[f], nodes = fibers.first_node[f + 1] - first;
    const double* d = d_block(f).data();
    for (Index p = first_row_of(f); p < first_row_of(f + 1); ++p, d += 2 * nodes) {
      double sum[3] = {0.0, 0.0, 0.0};
      for (std::size_t j = 0; j < nodes; ++j)
        for (int i = 0; i < 3; ++i)
          sum[i] += d[2 * j] * q[6 * (first + j) + i] + d[2 * j + 1] * q[6 * (first + j) + 3 + i];
      for (int i = 0; i < 3; ++i) out[3 * static_cast<std::size_t>(p) + i] = sum[i];
    }
  }
}

void Coupling::add_d_transposed(const double* lambda, std::vector<double>& q, double scale) const {
  const mesh::FiberMesh& fibers = implementation_->fibers;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    const std::size_t first = fibers.first_node[f], nodes = fibers.first_node[f + 1] - first;
    const double* d = d_block(f).data();
    for (Index p = first_row_of(f); p < first_row_of(f + 1); ++p, d += 2 * nodes)
      for (std::size_t j = 0; j < nodes; ++j)
        for (int i = 0; i < 3; ++i) {
          const double force = scale * lambda[3 * static_cast<std::size_t>(p) + i];
          q[6 * (first + j) + i] += d[2 * j] * force;
          q[6 * (first + j) + 3 + i] += d[2 * j + 1] * force;
        }
  }
}

}  // namespace fbi::coupling
