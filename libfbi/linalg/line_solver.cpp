#include "linalg/line_solver.hpp"

#include <algorithm>

#include "linalg/lanes.hpp"
#include "mesh/exchange.hpp"

namespace fbi::linalg {
namespace {

constexpr int tag = 7302;
constexpr int together = 4;  // bundles in one loop: their chains of operations overlap

template <class Number>
MPI_Datatype mpi_type() {
  return sizeof(Number) == sizeof(double) ? MPI_DOUBLE : MPI_FLOAT;
}

}  // namespace

LineMatrices::LineMatrices(const std::vector<double>& coordinates, const std::array<double, 2>& robin,
                           const std::vector<double>& factor) {
  const std::size_t n = coordinates.size();
  k_diagonal.assign(n, 0.0);
  m_diagonal.assign(n, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = coordinates[i + 1] - coordinates[i];
    const double k = (factor.empty() ? 1.0 : factor[i]) / h;
    k_diagonal[i] += k;
    k_diagonal[i + 1] += k;
    k_off.push_back(-k);
    m_diagonal[i] += h / 3.0;
    m_diagonal[i + 1] += h / 3.0;
    m_off.push_back(h / 6.0);
  }
  k_diagonal.front() += robin[0];
  k_diagonal.back() += robin[1];
}

template <class Real>
Index LineSolver<Real>::bundle_begin(int member) const {
  return static_cast<Index>(mesh::even_begin(bundles_, member, static_cast<int>(group_.rank.size())));
}

template <class Real>
LineSolver<Real>::LineSolver(const Comm& comm, PlaneGroup group, const LineMatrices& line,
                             const std::vector<double>& lambda, Index level_mode)
    : comm_(comm.get()), group_(std::move(group)), modes_(static_cast<Index>(lambda.size())) {
  constexpr int width = lane_count<Real>;
  const int members = static_cast<int>(group_.rank.size()), me = group_.me;
  bundles_ = (modes_ + width - 1) / width;
  first_ = me == 0;
  last_ = me + 1 == members;
  const Index begin = group_.begin[me], end = group_.begin[me + 1];
  planes_ = end - begin;
  inner_ = last_ ? planes_ : planes_ - 1;
  const bool reverse = last_ && !first_;
  const bool arrow = !first_ && !last_;

  // The plane that is eliminated at step t, and the interval between the planes of steps t-1 and t.
  const auto plane = [&](Index t) { return reverse ? end - 1 - t : begin + t; };
  const auto interval = [&](Index t) { return reverse ? end - 1 - t : begin + t - 1; };
  for (Index t = 0; t <= inner_; ++t) {
    const Index i = interval(t);
    const bool exists = i >= 0 && i < static_cast<Index>(line.k_off.size());
    k_.push_back(exists ? static_cast<Real>(line.k_off[i]) : Real(0));
    m_.push_back(exists ? static_cast<Real>(line.m_off[i]) : Real(0));
  }
  const auto off = [&](Index i, double eigenvalue) { return line.k_off[i] + eigenvalue * line.m_off[i]; };
  const auto diagonal = [&](Index i, double eigenvalue, Index mode) {
    // The level of the singular mode is fixed at the first node; compatible right-hand sides notice nothing.
    return (line.k_diagonal[i] + eigenvalue * line.m_diagonal[i]) * (mode == level_mode && i == 0 ? 2.0 : 1.0);
  };

  lambda_.assign(static_cast<std::size_t>(bundles_) * width, Real(0));
  inverse_.assign(static_cast<std::size_t>(bundles_) * inner_ * width, Real(0));
  if (arrow) fill_.assign(inverse_.size(), Real(0));
  // Schur complements on the separators: left, between left and own, own. Lanes without a mode solve 1 x = 0.
  constexpr int numbers = 3;
  std::vector<double> schur(static_cast<std::size_t>(bundles_) * numbers * width, 0.0);
  for (Index mode = 0; mode < bundles_ * width; ++mode) {
    const Index bundle = mode / width, lane = mode % width;
    double* complement = &schur[static_cast<std::size_t>(bundle) * numbers * width + lane];
    double &left = complement[0], &between = complement[width], &own = complement[2 * width];
    if (mode >= modes_) {
      if (!last_) own = 1.0;
      continue;
    }
    const double eigenvalue = lambda[mode];
    lambda_[mode] = static_cast<Real>(eigenvalue);
    double previous = 0.0, fill = 0.0;
    if (!last_) own = diagonal(end - 1, eigenvalue, mode);
    if (arrow && inner_ == 0) between = off(interval(0), eigenvalue);
    for (Index t = 0; t < inner_; ++t) {
      const double coupling = t > 0 ? off(interval(t), eigenvalue) : 0.0;
      const double inverse = 1.0 / (diagonal(plane(t), eigenvalue, mode) - coupling * coupling * previous);
      const std::size_t at = (static_cast<std::size_t>(bundle) * inner_ + t) * width + lane;
      if (arrow) {
        fill = t == 0 ? off(interval(0), eigenvalue) : -coupling * previous * fill;
        fill_[at] = static_cast<Real>(fill);
        left -= fill * fill * inverse;
      }
      previous = inverse;
      inverse_[at] = static_cast<Real>(inverse);
    }
    if (members == 1 || inner_ == 0) continue;
    const double tail = off(interval(inner_), eigenvalue);
    (last_ ? left : own) -= tail * tail * previous;
    if (arrow) between = -fill * previous * tail;
  }
  lines_.resize(static_cast<std::size_t>(members == 1 ? std::min<Index>(together, bundles_) : bundles_) * planes_ *
                width);
  if (members == 1) return;

  separator_.assign(static_cast<std::size_t>(bundles_) * 2 * width, Real(0));
  std::vector<double> all;
  share(schur, numbers * width, all);
  const Index share = bundle_begin(me + 1) - bundle_begin(me);
  const int separators = members - 1;
  separator_inverse_.resize(static_cast<std::size_t>(share) * separators * width);
  separator_off_.resize(separator_inverse_.size());
  const auto complement = [&](int member, Index bundle, int number, int lane) {
    return all[((static_cast<std::size_t>(member) * share + bundle) * numbers + number) * width + lane];
  };
  for (Index b = 0; b < share; ++b)
    for (int lane = 0; lane < width; ++lane) {
      double previous = 0.0;
      for (int j = 0; j < separators; ++j) {
        const double coupling = j > 0 ? complement(j, b, 1, lane) : 0.0;
        const double pivot = complement(j, b, 2, lane) + complement(j + 1, b, 0, lane) - coupling * coupling * previous;
        previous = 1.0 / pivot;
        const std::size_t at = (static_cast<std::size_t>(b) * separators + j) * width + lane;
        separator_inverse_[at] = static_cast<Real>(previous);
        separator_off_[at] = static_cast<Real>(coupling);
      }
    }
}

template <class Real>
template <class Number>
void LineSolver<Real>::share(const std::vector<Number>& send, std::size_t numbers,
                             std::vector<Number>& received) const {
  const int members = static_cast<int>(group_.rank.size()), me = group_.me;
  const std::size_t mine = static_cast<std::size_t>(bundle_begin(me + 1) - bundle_begin(me)) * numbers;
  received.resize(mine * members);
  std::vector<MPI_Request> requests;
  for (int i = 0; i < members; ++i) {
    if (i == me || mine == 0) continue;
    MPI_Irecv(&received[mine * i], static_cast<int>(mine), mpi_type<Number>(), group_.rank[i], tag, comm_,
              &requests.emplace_back());
  }
  for (int i = 0; i < members; ++i) {
    const std::size_t first = bundle_begin(i) * numbers, count = bundle_begin(i + 1) * numbers - first;
    if (i == me)
      std::copy_n(send.begin() + first, count, received.begin() + mine * i);
    else if (count > 0)
      MPI_Isend(&send[first], static_cast<int>(count), mpi_type<Number>(), group_.rank[i], tag, comm_,
                &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

template <class Real>
template <class Number>
void LineSolver<Real>::collect(const std::vector<Number>& send, std::size_t numbers,
                               std::vector<Number>& received) const {
  const int members = static_cast<int>(group_.rank.size()), me = group_.me;
  const std::size_t mine = static_cast<std::size_t>(bundle_begin(me + 1) - bundle_begin(me)) * numbers;
  std::vector<MPI_Request> requests;
  for (int i = 0; i < members; ++i) {
    const std::size_t first = bundle_begin(i) * numbers, count = bundle_begin(i + 1) * numbers - first;
    if (i != me && count > 0)
      MPI_Irecv(&received[first], static_cast<int>(count), mpi_type<Number>(), group_.rank[i], tag, comm_,
                &requests.emplace_back());
  }
  for (int i = 0; i < members; ++i) {
    if (i == me)
      std::copy_n(send.begin() + mine * i, mine, received.begin() + bundle_begin(me) * numbers);
    else if (mine > 0)
      MPI_Isend(&send[mine * i], static_cast<int>(mine), mpi_type<Number>(), group_.rank[i], tag, comm_,
                &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

// Lines of modes -> planes of lanes, and back; the modes of `Width` bundles from bundle `first` on.
template <class Real>
template <int Width>
void LineSolver<Real>::load_lines(const Real* field, Index first, Real* lines) const {
  constexpr int lanes = lane_count<Real>;
  for (int b = 0; b < Width; ++b) {
    const Index mode = (first + b) * lanes, rows = std::min<Index>(lanes, modes_ - mode);
    Real* to = lines + static_cast<std::size_t>(b) * planes_ * lanes;
    for (Index p = 0; p < planes_; p += lanes) {
      const Index columns = std::min<Index>(lanes, planes_ - p);
      Lanes<Real> tile[lanes] = {};
      for (Index i = 0; i < rows; ++i) {
        const Real* from = field + static_cast<std::size_t>(mode + i) * planes_ + p;
        tile[i] = columns == lanes ? load(from) : load(from, columns);
      }
      transpose<Real>(tile);
      for (Index i = 0; i < columns; ++i) store(tile[i], to + static_cast<std::size_t>(p + i) * lanes);
    }
  }
}

template <class Real>
template <int Width>
void LineSolver<Real>::store_lines(const Real* lines, Index first, Real* field) const {
  constexpr int lanes = lane_count<Real>;
  for (int b = 0; b < Width; ++b) {
    const Index mode = (first + b) * lanes, rows = std::min<Index>(lanes, modes_ - mode);
    const Real* from = lines + static_cast<std::size_t>(b) * planes_ * lanes;
    for (Index p = 0; p < planes_; p += lanes) {
      const Index columns = std::min<Index>(lanes, planes_ - p);
      Lanes<Real> tile[lanes] = {};
      for (Index i = 0; i < columns; ++i) tile[i] = load(from + static_cast<std::size_t>(p + i) * lanes);
      transpose<Real>(tile);
      for (Index i = 0; i < rows; ++i) {
        Real* to = field + static_cast<std::size_t>(mode + i) * planes_ + p;
        if (columns == lanes)
          store(tile[i], to);
        else
          store(tile[i], to, columns);
      }
    }
  }
}

template <class Real>
template <int Width>
void LineSolver<Real>::eliminate(Index first, Real* lines) {
  constexpr int lanes = lane_count<Real>;
  const bool reverse = last_ && !first_, arrow = !first_ && !last_;
  const std::size_t line = static_cast<std::size_t>(planes_) * lanes, table = static_cast<std::size_t>(inner_) * lanes;
  Lanes<Real> y[Width] = {}, left[Width] = {}, lambda[Width];
  for (int b = 0; b < Width; ++b) lambda[b] = load(&lambda_[static_cast<std::size_t>(first + b) * lanes]);
  for (Index t = 0; t < inner_; ++t) {
    Real* row = lines + static_cast<std::size_t>(reverse ? planes_ - 1 - t : t) * lanes;
    const Real* inverse = &inverse_[(static_cast<std::size_t>(first) * inner_ + t) * lanes];
    for (int b = 0; b < Width; ++b) {
      Lanes<Real> value = load(row + b * line);
      if (t > 0) value -= (k_[t] + lambda[b] * m_[t]) * y[b];
      y[b] = value * load(inverse + b * table);
      store(y[b], row + b * line);
    }
    if (!arrow) continue;
    const Real* fill = &fill_[(static_cast<std::size_t>(first) * inner_ + t) * lanes];
    for (int b = 0; b < Width; ++b) left[b] -= load(fill + b * table) * y[b];
  }
  if (group_.rank.size() == 1) return;
  for (int b = 0; b < Width; ++b) {
    Real* separator = &separator_[static_cast<std::size_t>(first + b) * 2 * lanes];
    const Lanes<Real> tail = -(k_[inner_] + lambda[b] * m_[inner_]) * y[b];
    if (last_) {
      store(tail, separator);
      continue;
    }
    store(left[b], separator);
    store(tail + load(lines + b * line + static_cast<std::size_t>(planes_ - 1) * lanes), separator + lanes);
  }
}

template <class Real>
template <int Width>
void LineSolver<Real>::substitute(Index first, Real* lines) const {
  constexpr int lanes = lane_count<Real>;
  const bool reverse = last_ && !first_, arrow = !first_ && !last_, alone = group_.rank.size() == 1;
  const std::size_t line = static_cast<std::size_t>(planes_) * lanes, table = static_cast<std::size_t>(inner_) * lanes;
  Lanes<Real> x[Width] = {}, left[Width] = {}, lambda[Width];
  for (int b = 0; b < Width; ++b) {
    lambda[b] = load(&lambda_[static_cast<std::size_t>(first + b) * lanes]);
    if (alone) continue;
    const Real* separator = &separator_[static_cast<std::size_t>(first + b) * 2 * lanes];
    x[b] = load(separator + (last_ ? 0 : lanes));
    left[b] = load(separator);
    if (!last_) store(x[b], lines + b * line + static_cast<std::size_t>(planes_ - 1) * lanes);
  }
  for (Index t = inner_; t-- > 0;) {
    Real* row = lines + static_cast<std::size_t>(reverse ? planes_ - 1 - t : t) * lanes;
    const std::size_t at = (static_cast<std::size_t>(first) * inner_ + t) * lanes;
    for (int b = 0; b < Width; ++b) {
      Lanes<Real> coupled = (k_[t + 1] + lambda[b] * m_[t + 1]) * x[b];
      if (arrow) coupled += load(&fill_[at] + b * table) * left[b];
      x[b] = load(row + b * line) - load(&inverse_[at] + b * table) * coupled;
      store(x[b], row + b * line);
    }
  }
}

template <class Real>
void LineSolver<Real>::solve_separators() {
  constexpr int lanes = lane_count<Real>;
  share(separator_, 2 * lanes, received_);
  const int members = static_cast<int>(group_.rank.size()), separators = members - 1;
  const Index share = bundle_begin(group_.me + 1) - bundle_begin(group_.me);
  const auto at = [&](int member, Index bundle, int number) {
    return &received_[((static_cast<std::size_t>(member) * share + bundle) * 2 + number) * lanes];
  };
  for (Index b = 0; b < share; ++b) {
    const Real* inverse = &separator_inverse_[static_cast<std::size_t>(b) * separators * lanes];
    const Real* off = &separator_off_[static_cast<std::size_t>(b) * separators * lanes];
    Lanes<Real> value = {};
    for (int j = 0; j < separators; ++j) {
      value = (load(at(j, b, 1)) + load(at(j + 1, b, 0)) - load(off + j * lanes) * value) * load(inverse + j * lanes);
      store(value, at(j, b, 1));
    }
    for (int j = separators; j-- > 0;) {
      value = load(at(j, b, 1));
      if (j + 1 < separators) value -= load(inverse + j * lanes) * load(off + (j + 1) * lanes) * load(at(j + 1, b, 1));
      store(value, at(j, b, 1));
      store(value, at(j + 1, b, 0));
    }
  }
  collect(received_, 2 * lanes, separator_);
}

template <class Real>
void LineSolver<Real>::solve(Real* field) {
  constexpr int lanes = lane_count<Real>;
  if (planes_ == 0) return;
  const bool alone = group_.rank.size() == 1;
  const auto lines = [&](Index bundle) {
    return alone ? lines_.data() : &lines_[static_cast<std::size_t>(bundle) * planes_ * lanes];
  };
  const auto down = [&]<int Width>(Index b) {
    load_lines<Width>(field, b, lines(b));
    eliminate<Width>(b, lines(b));
  };
  const auto up = [&]<int Width>(Index b) {
    substitute<Width>(b, lines(b));
    store_lines<Width>(lines(b), b, field);
  };
  const auto for_bundles = [&](auto work) {
    Index b = 0;
    for (; b + together <= bundles_; b += together) work.template operator()<together>(b);
    for (; b < bundles_; ++b) work.template operator()<1>(b);
  };
  if (alone) {
    for_bundles([&]<int Width>(Index b) {
      down.template operator()<Width>(b);
      up.template operator()<Width>(b);
    });
    return;
  }
  for_bundles(down);
  solve_separators();
  for_bundles(up);
}

template class LineSolver<float>;
template class LineSolver<double>;

}  // namespace fbi::linalg
