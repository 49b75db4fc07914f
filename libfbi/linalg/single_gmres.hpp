/// Flexible GMRES in single precision, for linear solves that a double precision iteration around them corrects.
#pragma once

#include <functional>
#include <vector>

#include "base/comm.hpp"
#include "linalg/krylov.hpp"

namespace fbi::linalg {

/// Right-preconditioned flexible GMRES (Saad 1993) whose vectors are floats; sums are collected in double. PETSc has
/// one number type in a program, hence a method of our own. Memory: two vectors for each iteration, kept between
/// solves.
class SingleGmres {
 public:
  /// z = P^-1 (factor v) and w = A z in one call: preconditioners that split A know parts of w already. z and w have
  /// `room` numbers, of which the first `size` count; they are kept as they are for the next steps. Collective.
  using Step = std::function<void(const float* v, float factor, float* z, float* w)>;

  /// @param size     numbers of a vector on this rank
  /// @param room     numbers that the arrays of a step have, at least `size`
  /// @param restart  iterations after which the space starts anew
  SingleGmres(const Comm& comm, std::size_t size, std::size_t room, Step step, int restart);

  /// Solves A x = b from x = 0 until |b - A x| <= tolerance |b| by the recursion's estimate. Squares of the entries of
  /// b must be within the range of floats. A b that is zero gives x = 0; numbers that are not finite end the iteration
  /// unconverged, the same on every rank. At most `maximum` iterations. Collective.
  /// @param b          shape=(size), overwritten
  /// @param x          shape=(size)
  /// @param impatient  the caller has another way: ends as well, `stalled`, once ten iterations or more have come less
  ///                   than a third of the way to the tolerance (above 0) that `maximum` iterations would need by then
  KrylovResult solve(float* b, float* x, double tolerance, int maximum, bool impatient = false);

 private:
  /// The first vector of the basis = b; returns |b|. Collective.
  double start(const float* b);
  /// h_j = v_j . w for the first `count` basis vectors (times their factors), one reduction. Collective.
  void project(const float* w, int count, double* h) const;
  /// w -= sum_j h_j v_j; returns |w|. Collective.
  double remove(float* w, int count, const double* h) const;

  Comm comm_;
  std::size_t size_, room_;
  Step step_;
  int restart_;
  std::vector<std::vector<float>> basis_, directions_;
  std::vector<double> factor_;  ///< of each basis vector: its inverse length
};

}  // namespace fbi::linalg
