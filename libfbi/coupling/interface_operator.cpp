#include "coupling/interface_operator.hpp"

#include <cmath>

namespace fbi::coupling {

InterfaceOperator::InterfaceOperator(const mesh::FiberMesh& fibers, double penalty)
    : penalty_(penalty), first_row_(1, 0), blocks_(fibers.fibers()), factors_(fibers.fibers()) {}

void InterfaceOperator::reset(const Coupling& coupling) {
  const Index fibers = static_cast<Index>(blocks_.size());
  first_row_.resize(fibers + 1);
  for (Index f = 0; f <= fibers; ++f) first_row_[f] = coupling.first_row_of(f);
  const Index rows = coupling.rows();
  diagonal_.assign(rows, 0.0);
  active_.assign(rows, 0);
  for (Index p = 0; p < rows; ++p) {
    const double kappa = coupling.kappa()[p];
    active_[p] = kappa > 0.0;
    diagonal_[p] = active_[p] ? kappa / penalty_ : 1.0;
  }
  for (Block& block : blocks_) block.resize(0, 0);
}

void InterfaceOperator::add(Index fiber, double factor, const Block& compliance) {
  Block& block = blocks_[fiber];
  const Index first = first_row_[fiber], rows = first_row_[fiber + 1] - first;
  if (block.size() == 0) {
    block = Block::Zero(3 * rows, 3 * rows);
    for (Index p = 0; p < rows; ++p)
      for (int i = 0; i < 3; ++i) block(3 * p + i, 3 * p + i) = diagonal_[first + p];
  }
  block += factor * compliance;
  for (Index p = 0; p < rows; ++p) {
    if (active_[first + p]) continue;
    block.middleRows(3 * p, 3).setZero();
    block.middleCols(3 * p, 3).setZero();
    block.block(3 * p, 3 * p, 3, 3).setIdentity();
  }
}

bool InterfaceOperator::factorize() {
  for (std::size_t f = 0; f < blocks_.size(); ++f) {
    if (blocks_[f].size() == 0) continue;
    if (!blocks_[f].allFinite()) return false;
    factors_[f].compute(blocks_[f]);
    const double smallest = factors_[f].matrixLU().diagonal().cwiseAbs().minCoeff();
    if (!(smallest > 0.0)) return false;
  }
  return true;
}

void InterfaceOperator::solve(double* b) const {
  Eigen::VectorXd work;
  for (Index f = 0; f < fibers(); ++f) {
    const Index first = first_row_[f], rows = first_row_[f + 1] - first;
    for (Index p = 0; p < rows; ++p)
      if (!active_[first + p])
        for (int i = 0; i < 3; ++i) b[3 * (first + p) + i] = 0.0;
    if (blocks_[f].size() == 0) {
      for (Index p = 0; p < rows; ++p)
        for (int i = 0; i < 3; ++i) b[3 * (first + p) + i] /= diagonal_[first + p];
    } else {
      Eigen::Map<Eigen::VectorXd> part(b + 3 * first, 3 * rows);
      work = factors_[f].solve(part);
      part = work;
    }
  }
}

void InterfaceOperator::apply(const double* lambda, double* out) const {
  for (Index f = 0; f < fibers(); ++f) {
    const Index first = first_row_[f], rows = first_row_[f + 1] - first;
    if (blocks_[f].size() == 0) {
      for (Index p = 0; p < rows; ++p)
        for (int i = 0; i < 3; ++i) out[3 * (first + p) + i] = diagonal_[first + p] * lambda[3 * (first + p) + i];
    } else {
      Eigen::Map<const Eigen::VectorXd> part(lambda + 3 * first, 3 * rows);
      Eigen::Map<Eigen::VectorXd>(out + 3 * first, 3 * rows) = blocks_[f] * part;
    }
  }
}

}  // namespace fbi::coupling
