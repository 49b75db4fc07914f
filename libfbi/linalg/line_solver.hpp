/// Tridiagonal systems along one direction, one for each pair of modes of the other two, whose planes ranks share.
#pragma once

#include <array>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"

namespace fbi::linalg {

/// Tridiagonal stiffness K and mass M of linear elements along a line.
struct LineMatrices {
  std::vector<double> k_diagonal, k_off, m_diagonal, m_off;
  LineMatrices() = default;
  /// `robin[e]` is added to K at the low and the high end [1/length]; `factor` multiplies the stiffness of each
  /// interval (empty: 1).
  LineMatrices(const std::vector<double>& coordinates, const std::array<double, 2>& robin,
               const std::vector<double>& factor);
};

/// Ranks that hold the same modes on consecutive ranges of planes.
struct PlaneGroup {
  std::vector<int> rank;     ///< shape=(members), of the communicator
  std::vector<Index> begin;  ///< shape=(members+1): planes [begin[i], begin[i+1]) are on member i, none without planes
  int me = 0;
};

/// Solves (K + lambda_m M) x_m = b_m for every mode m. Each rank eliminates its planes down to the last one, the
/// separator to the next rank (the last rank: all its planes, from the end); the systems of the separators are shared
/// out by modes among the members. Two small messages of a plane's modes over the number of members to every other
/// member, whatever the number of planes.
template <class Real>
class LineSolver {
 public:
  /// `level_mode` >= 0: of that mode lambda is 0 and K singular; the solution is 0 on plane 0. Collective in the group.
  LineSolver(const Comm& comm, PlaneGroup group, const LineMatrices& line, const std::vector<double>& lambda,
             Index level_mode);
  /// In place; shape=(modes,planes of this rank). Collective in the group.
  void solve(Real* field);

 private:
  template <int Width>
  void load_lines(const Real* field, Index first, Real* lines) const;
  template <int Width>
  void store_lines(const Real* lines, Index first, Real* field) const;
  template <int Width>
  void eliminate(Index first, Real* lines);
  template <int Width>
  void substitute(Index first, Real* lines) const;
  void solve_separators();
  /// Sends each member its share of `send`, shape=(bundles,numbers of a bundle), and collects what the others send.
  template <class Number>
  void share(const std::vector<Number>& send, std::size_t numbers, std::vector<Number>& received) const;
  /// The way back of `share`.
  template <class Number>
  void collect(const std::vector<Number>& send, std::size_t numbers, std::vector<Number>& received) const;
  Index bundle_begin(int member) const;

  MPI_Comm comm_;
  PlaneGroup group_;
  Index modes_, bundles_;  // bundles of as many modes as a vector has lanes
  Index planes_, inner_;   // of this rank; of them, those it eliminates
  bool first_, last_;      // member of the group; the last one runs from the end and has no separator of its own
  std::vector<Real> lambda_;
  std::vector<Real> k_, m_;      // shape=(inner+1): couples inner plane t to t-1; 0: to the left separator
  std::vector<Real> inverse_;    // 1/pivot, shape=(bundles,inner,lanes)
  std::vector<Real> fill_;       // coupling to the left separator after elimination, likewise; members in the middle
  std::vector<Real> lines_;      // shape=(bundles,planes,lanes); on one rank those of a few bundles only
  std::vector<Real> separator_;  // shape=(bundles,2,lanes): the left one, this rank's own
  std::vector<Real> received_;   // shape=(members,bundles of this rank's share,2,lanes)
  std::vector<Real> separator_inverse_, separator_off_;  // shape=(share,separators,lanes)
};

extern template class LineSolver<float>;
extern template class LineSolver<double>;

}  // namespace fbi::linalg
