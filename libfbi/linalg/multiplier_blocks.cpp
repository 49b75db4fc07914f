#include "linalg/multiplier_blocks.hpp"

#include <algorithm>
#include <cmath>

#include "base/node_vector.hpp"

namespace fbi::linalg {

namespace {
constexpr double round_off = 1e-12;  // of entries of M, relative to the largest
}

bool MultiplierBlocks::suits(const MultiplierRows& m, const std::vector<InterfaceBlock>& s) {
  Index rows = 0;
  for (const InterfaceBlock& block : s) {
    if (block.dense == nullptr && block.rows > 0) return false;
    rows += block.rows;
  }
  double least = 0.0, most = 0.0;
  for (const double value : m.value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
  return rows == m.rows() && least >= -round_off * most;
}

/// M W M^T between rows of one block.
void MultiplierBlocks::couple_own(const std::vector<Index>& column_begin, const std::vector<Index>& column_row,
                                  const std::vector<double>& column_value, const std::vector<Index>& block_of) {
  const Index rows = m_.rows();
  own_begin_.assign(1, 0);
  own_row_.clear();
  own_value_.clear();
  couples_ = false;
  std::vector<Index> place(rows, -1);  // of an entry, within the present row
  for (Index p = 0; p < rows; ++p) {
    const std::size_t begin = own_row_.size();
    for (Index k = m_.begin[p]; k < m_.begin[p + 1]; ++k) {
      const std::size_t c = m_.column[k];
      const double* w = &m_.weight[3 * c];
      for (Index j = column_begin[c]; j < column_begin[c + 1]; ++j) {
        const Index q = column_row[j];
        if (block_of[q] != block_of[p]) {
          couples_ = true;
          continue;
        }
        if (place[q] < static_cast<Index>(begin)) {
          place[q] = static_cast<Index>(own_row_.size());
          own_row_.push_back(q);
          own_value_.insert(own_value_.end(), 3, 0.0);
        }
        const double product = m_.value[k] * column_value[j];
        for (int i = 0; i < 3; ++i) own_value_[3 * static_cast<std::size_t>(place[q]) + i] += product * w[i];
      }
    }
    own_begin_.push_back(static_cast<Index>(own_row_.size()));
  }
}

std::vector<double> MultiplierBlocks::lump(const std::vector<double>& column_total) {
  std::vector<double> others(lumped_.size(), 0.0);
  for (Index p = 0; p < m_.rows(); ++p) {
    const std::size_t at = 3 * static_cast<std::size_t>(p);
    for (Index k = m_.begin[p]; k < m_.begin[p + 1]; ++k) {
      const std::size_t c = m_.column[k];
      const double foreign = m_.others.empty() ? 0.0 : std::max(0.0, m_.value[k] * m_.others[c]);
      for (int i = 0; i < 3; ++i) {
        lumped_[at + i] += m_.value[k] * column_total[c] * m_.weight[3 * c + i];
        others[at + i] += foreign * m_.weight[3 * c + i];
      }
    }
    for (Index k = own_begin_[p]; k < own_begin_[p + 1]; ++k)
      for (int i = 0; i < 3; ++i) lumped_[at + i] -= own_value_[3 * static_cast<std::size_t>(k) + i];
    for (int i = 0; i < 3; ++i) lumped_[at + i] = couples_ ? std::max(0.0, lumped_[at + i]) : 0.0;
  }
  return others;
}

bool MultiplierBlocks::factorize(MultiplierRows m, const std::vector<InterfaceBlock>& s, bool alone) {
  m_ = std::move(m);
  const Index rows = m_.rows(), columns = m_.columns();
  blocks_.clear();
  std::vector<Index> block_of(rows, -1);
  for (const InterfaceBlock& block : s) {
    Block& copy = blocks_.emplace_back();
    copy.count = block.rows;
    copy.first = block.first;
    if (block.index != nullptr) copy.rows.assign(block.index, block.index + block.rows);
    for (Index i = 0; i < block.rows; ++i) block_of[copy.row(i)] = static_cast<Index>(blocks_.size()) - 1;
  }
  // Rows by column, and M^T 1.
  std::vector<Index> begin(static_cast<std::size_t>(columns) + 1, 0), row(m_.column.size());
  std::vector<double> value(m_.column.size()), total(columns, 0.0);
  for (const Index c : m_.column) ++begin[c + 1];
  for (Index c = 0; c < columns; ++c) begin[c + 1] += begin[c];
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index p = 0; p < rows; ++p)
    for (Index k = m_.begin[p]; k < m_.begin[p + 1]; ++k) {
      const Index c = m_.column[k];
      row[next[c]] = p;
      value[next[c]++] = m_.value[k];
      total[c] += m_.value[k];
    }
  couple_own(begin, row, value, block_of);

  lumped_.assign(3 * static_cast<std::size_t>(rows), 0.0);
  std::vector<double> others(lumped_.size(), 0.0);
  if (!alone) others = lump(total);
  value_.assign(m_.value.begin(), m_.value.end());
  weight_.assign(4 * static_cast<std::size_t>(columns), 0.0f);
  for (std::size_t c = 0; c < static_cast<std::size_t>(columns); ++c)
    for (int i = 0; i < 3; ++i) weight_[4 * c + i] = static_cast<float>(m_.weight[3 * c + i]);
  return invert_blocks(s, others);
}

bool MultiplierBlocks::invert_blocks(const std::vector<InterfaceBlock>& s, const std::vector<double>& others) {
  std::vector<DenseBlock> dense(blocks_.size()), inverses(blocks_.size());
  std::vector<Index> position(m_.rows(), -1);  // of a row within its block
  std::size_t entries = 0;
  for (std::size_t f = 0; f < blocks_.size(); ++f) {
    const Index n = blocks_[f].count;
    dense[f] = Eigen::Map<const DenseBlock>(s[f].dense, 3 * n, 3 * n);
    entries += 9 * static_cast<std::size_t>(n) * n;
    for (Index i = 0; i < n; ++i) position[blocks_[f].row(i)] = i;
    for (Index i = 0; i < n; ++i) {
      const std::size_t p = blocks_[f].row(i);
      for (Index k = own_begin_[p]; k < own_begin_[p + 1]; ++k)
        for (int d = 0; d < 3; ++d)
          dense[f](3 * i + d, 3 * position[own_row_[k]] + d) += own_value_[3 * static_cast<std::size_t>(k) + d];
      for (int d = 0; d < 3; ++d) dense[f](3 * i + d, 3 * i + d) += lumped_[3 * p + d] + others[3 * p + d];
    }
  }
  if (!invert(dense, inverses)) return false;
  inverses_.resize(entries);
  double* to = inverses_.data();
  for (std::size_t f = 0; f < blocks_.size(); ++f) {
    const Index n = 3 * blocks_[f].count;
    Eigen::Map<Eigen::MatrixXd>(to, n, n) = inverses[f];
    to += static_cast<std::size_t>(n) * n;
  }
  return true;
}

void MultiplierBlocks::apply_inverses(const double* b, double* x) {
  const double* inverse = inverses_.data();
  for (const Block& block : blocks_) {
    const std::size_t n = 3 * static_cast<std::size_t>(block.count);
    const double* from = b + 3 * static_cast<std::size_t>(block.first);
    double* to = x + 3 * static_cast<std::size_t>(block.first);
    if (!block.rows.empty()) {
      part_.resize(2 * n);
      from = part_.data();
      to = part_.data() + n;
      for (std::size_t i = 0; i < n; ++i) part_[i] = b[3 * static_cast<std::size_t>(block.rows[i / 3]) + i % 3];
    }
    const Eigen::Index size = static_cast<Eigen::Index>(n);
    Eigen::Map<Eigen::VectorXd>(to, size) = Eigen::Map<const Eigen::MatrixXd>(inverse, size, size)
                                                .lazyProduct(Eigen::Map<const Eigen::VectorXd>(from, size));
    inverse += n * n;
    for (std::size_t i = 0; i < n && !block.rows.empty(); ++i)
      x[3 * static_cast<std::size_t>(block.rows[i / 3]) + i % 3] = to[i];
  }
}

/// r += (L - E) y.
void MultiplierBlocks::add_others(const double* y, double* r) {
  using Four = NodeVector<float>;
  const Index rows = m_.rows();
  std::fill(spread_.begin(), spread_.end(), 0.0f);
  for (Index p = 0; p < rows; ++p) {
    const double* from = y + 3 * static_cast<std::size_t>(p);
    const Four three = {static_cast<float>(from[0]), static_cast<float>(from[1]), static_cast<float>(from[2]), 0.0f};
    for (Index k = m_.begin[p]; k < m_.begin[p + 1]; ++k) {
      float* to = &spread_[4 * static_cast<std::size_t>(m_.column[k])];
      store_node<float>(load_node(to) + value_[k] * three, to);
    }
  }
  for (std::size_t k = 0; k < spread_.size(); ++k) spread_[k] *= weight_[k];
  for (Index p = 0; p < rows; ++p) {
    const std::size_t at = 3 * static_cast<std::size_t>(p);
    double sum[3];
    for (int i = 0; i < 3; ++i) sum[i] = lumped_[at + i] * y[at + i];
    for (Index k = own_begin_[p]; k < own_begin_[p + 1]; ++k)
      for (int i = 0; i < 3; ++i)
        sum[i] += own_value_[3 * static_cast<std::size_t>(k) + i] * y[3 * static_cast<std::size_t>(own_row_[k]) + i];
    Four product = {};
    for (Index k = m_.begin[p]; k < m_.begin[p + 1]; ++k)
      product += value_[k] * load_node(&spread_[4 * static_cast<std::size_t>(m_.column[k])]);
    for (int i = 0; i < 3; ++i) r[at + i] += sum[i] - product[i];
  }
}

void MultiplierBlocks::solve(double* b, int steps) {
  const std::size_t size = 3 * static_cast<std::size_t>(m_.rows());
  sum_.resize(size);
  spread_.resize(weight_.size());
  apply_inverses(b, sum_.data());
  for (int step = 0; couples_ && step < steps; ++step) {
    right_.assign(b, b + size);
    add_others(sum_.data(), right_.data());
    apply_inverses(right_.data(), sum_.data());
  }
  std::copy_n(sum_.data(), size, b);
}

}  // namespace fbi::linalg
