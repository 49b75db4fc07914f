#include "coupling/interface_operator.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "linalg/block_inverses.hpp"

namespace fbi::coupling {

InterfaceOperator::InterfaceOperator(const mesh::FiberMesh& fibers)
    : first_row_(1, 0),
      is_dense_(fibers.fibers(), 0),
      blocks_(fibers.fibers()),
      inverses_(fibers.fibers()),
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
  row_.resize(rows);
  std::iota(row_.begin(), row_.end(), 0);
  active_.assign(rows, 0);
  law_.assign(9 * static_cast<std::size_t>(rows), 0.0);
  inverse_.assign(law_.size(), 0.0);
  for (Index p = 0; p < rows; ++p) {
    const Symmetric& s = coupling.interface_rows()[p];
    Law law;
    law << s[0], s[1], s[2], s[1], s[3], s[4], s[2], s[4], s[5];
    active_[p] = coupling.kappa()[p] > 0.0 && s[0] > 0.0 && law.topLeftCorner<2, 2>().determinant() > 0.0 &&
                 law.determinant() > 0.0;
    if (!active_[p]) law.setIdentity();
    const std::size_t at = 9 * static_cast<std::size_t>(p);
    const Law inverse = law.inverse();
    std::copy_n(law.data(), 9, law_.begin() + at);
    std::copy_n(inverse.data(), 9, inverse_.begin() + at);
  }
  std::fill(is_dense_.begin(), is_dense_.end(), 0);
  for (Group& group : groups_) {
    group.block.resize(0, 0);
    group.rows.clear();
    for (const Index f : group.fibers)
      for (Index p = first_row_[f]; p < first_row_[f + 1]; ++p) group.rows.push_back(p);
  }
}

void InterfaceOperator::add_law(const Index* rows, Index count, Block& block) const {
  for (Index p = 0; p < count; ++p)
    if (active_[rows[p]]) block.block<3, 3>(3 * p, 3 * p) += law(rows[p]);
}

void InterfaceOperator::switch_off(const Index* rows, Index count, Block& block) const {
  for (Index p = 0; p < count; ++p) {
    if (active_[rows[p]]) continue;
    block.middleRows(3 * p, 3).setZero();
    block.middleCols(3 * p, 3).setZero();
    block.block<3, 3>(3 * p, 3 * p).setIdentity();
  }
}

void InterfaceOperator::add_joined(Index group, double factor, const Block& compliance) {
  Block& block = groups_[group].block;
  const std::vector<Index>& rows = groups_[group].rows;
  const Index count = static_cast<Index>(rows.size());
  if (block.size() == 0) {
    block = Block::Zero(3 * count, 3 * count);
    add_law(rows.data(), count, block);
  }
  block += factor * compliance;
  switch_off(rows.data(), count, block);
}

void InterfaceOperator::add(Index fiber, double factor, const Eigen::Ref<const Block>& compliance) {
  Block& block = blocks_[fiber];
  const Index* rows = row_.data() + first_row_[fiber];
  const Index count = first_row_[fiber + 1] - first_row_[fiber];
  if (!is_dense_[fiber]) {
    block.setZero(3 * count, 3 * count);
    add_law(rows, count, block);
    is_dense_[fiber] = 1;
  }
  block += factor * compliance;
  switch_off(rows, count, block);
}

bool InterfaceOperator::factorize() {
  for (Index f = 0; f < fibers(); ++f)
    if (is_local(f)) blocks_[f].resize(0, 0);
  if (!linalg::invert(blocks_, inverses_)) return false;
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

void InterfaceOperator::clear_inactive(double* b) const {
  for (std::size_t p = 0; p < active_.size(); ++p)
    if (!active_[p]) std::fill_n(b + 3 * p, 3, 0.0);
}

void InterfaceOperator::solve(double* b) const {
  Eigen::VectorXd work;
  solve_joined(b);
  clear_inactive(b);
  for (Index f = 0; f < fibers(); ++f) {
    if (is_joined(f)) continue;
    const Index first = first_row_[f], rows = first_row_[f + 1] - first;
    if (is_local(f)) {
      for (Index p = first; p < first + rows; ++p) {
        Eigen::Map<Vec3> part(b + 3 * static_cast<std::size_t>(p));
        part = (Eigen::Map<const Law>(&inverse_[9 * static_cast<std::size_t>(p)]) * part).eval();
      }
    } else {
      Eigen::Map<Eigen::VectorXd> part(b + 3 * first, 3 * rows);
      work.noalias() = inverses_[f].lazyProduct(part);  // small: no call of a general product
      part = work;
    }
  }
}

void InterfaceOperator::apply(const double* lambda, double* out) const {
  apply_joined(lambda, out);
  for (Index f = 0; f < fibers(); ++f) {
    if (is_joined(f)) continue;
    const Index first = first_row_[f], rows = first_row_[f + 1] - first;
    if (is_local(f)) {
      for (Index p = first; p < first + rows; ++p)
        Eigen::Map<Vec3>(out + 3 * static_cast<std::size_t>(p)) =
            law(p) * Eigen::Map<const Vec3>(lambda + 3 * static_cast<std::size_t>(p));
    } else {
      Eigen::Map<const Eigen::VectorXd> part(lambda + 3 * first, 3 * rows);
      Eigen::Map<Eigen::VectorXd>(out + 3 * first, 3 * rows) = blocks_[f].lazyProduct(part);
    }
  }
}

void InterfaceOperator::apply_law(const double* lambda, double* out) const {
  for (Index p = 0; p < rows(); ++p)
    Eigen::Map<Vec3>(out + 3 * static_cast<std::size_t>(p)) =
        law(p) * Eigen::Map<const Vec3>(lambda + 3 * static_cast<std::size_t>(p));
}

}  // namespace fbi::coupling
