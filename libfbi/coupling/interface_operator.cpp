#include "coupling/interface_operator.hpp"

#include <cmath>

namespace fbi::coupling {

InterfaceOperator::InterfaceOperator(const mesh::FiberMesh& fibers, double penalty)
    : penalty_(penalty),
      first_row_(1, 0),
      blocks_(fibers.fibers()),
      factors_(fibers.fibers()),
      groups_(fibers.joined.size()),
      group_(fibers.joined_group) {
  group_.resize(fibers.fibers(), -1);
  for (std::size_t g = 0; g < groups_.size(); ++g) groups_[g].fibers = fibers.joined[g];
}

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
  for (Group& group : groups_) {
    group.block.resize(0, 0);
    group.rows.clear();
    for (const Index f : group.fibers)
      for (Index p = first_row_[f]; p < first_row_[f + 1]; ++p) group.rows.push_back(p);
  }
}

void InterfaceOperator::add_joined(Index group, double factor, const Block& compliance) {
  Block& block = groups_[group].block;
  const std::vector<Index>& rows = groups_[group].rows;
  const Index count = static_cast<Index>(rows.size());
  if (block.size() == 0) block = Block::Zero(3 * count, 3 * count);
  block += factor * compliance;
  for (Index p = 0; p < count; ++p) {
    if (active_[rows[p]]) {
      for (int i = 0; i < 3; ++i) block(3 * p + i, 3 * p + i) += diagonal_[rows[p]];
      continue;
    }
    block.middleRows(3 * p, 3).setZero();
    block.middleCols(3 * p, 3).setZero();
    block.block(3 * p, 3 * p, 3, 3).setIdentity();
  }
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
  for (Group& group : groups_) {
    if (group.block.size() == 0) continue;
    if (!group.block.allFinite()) return false;
    group.factor.compute(group.block);
    if (!(group.factor.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0)) return false;
  }
  return true;
}

void InterfaceOperator::solve_joined(double* b) const {
  for (const Group& group : groups_) {
    if (group.block.size() == 0) continue;
    Eigen::VectorXd part(group.block.rows());
    for (std::size_t p = 0; p < group.rows.size(); ++p)
      for (int i = 0; i < 3; ++i)
        part[3 * static_cast<Index>(p) + i] = active_[group.rows[p]] ? b[3 * group.rows[p] + i] : 0.0;
    part = group.factor.solve(part).eval();
    for (std::size_t p = 0; p < group.rows.size(); ++p)
      for (int i = 0; i < 3; ++i) b[3 * group.rows[p] + i] = part[3 * static_cast<Index>(p) + i];
  }
}

void InterfaceOperator::apply_joined(const double* lambda, double* out) const {
  for (const Group& group : groups_) {
    if (group.block.size() == 0) continue;
    Eigen::VectorXd part(group.block.rows());
    for (std::size_t p = 0; p < group.rows.size(); ++p)
      for (int i = 0; i < 3; ++i) part[3 * static_cast<Index>(p) + i] = lambda[3 * group.rows[p] + i];
    part = (group.block * part).eval();
    for (std::size_t p = 0; p < group.rows.size(); ++p)
      for (int i = 0; i < 3; ++i) out[3 * group.rows[p] + i] = part[3 * static_cast<Index>(p) + i];
  }
}

void InterfaceOperator::solve(double* b) const {
  Eigen::VectorXd work;
  solve_joined(b);
  for (Index f = 0; f < fibers(); ++f) {
    if (is_joined(f)) continue;
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
  apply_joined(lambda, out);
  for (Index f = 0; f < fibers(); ++f) {
    if (is_joined(f)) continue;
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
