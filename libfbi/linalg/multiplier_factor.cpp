#include "linalg/multiplier_factor.hpp"

#include <cholmod.h>
#include <umfpack.h>

#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "linalg/minimal_residuals.hpp"

namespace fbi::linalg {
namespace {

constexpr int most_steps = 16;   // for the rows of all ranks
constexpr double enough = 1e-3;  // residual that ends them, relative: S^-1 makes much of it

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

/// Rows of M that have an entry in each column, by column.
struct Columns {
  std::vector<Index> begin, row;
  std::vector<double> value;
  explicit Columns(const MultiplierRows& m) : begin(static_cast<std::size_t>(m.columns()) + 1, 0) {
    row.resize(m.column.size());
    value.resize(m.column.size());
    for (const Index c : m.column) ++begin[c + 1];
    for (Index c = 0; c < m.columns(); ++c) begin[c + 1] += begin[c];
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (Index p = 0; p < m.rows(); ++p)
      for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k) {
        row[next[m.column[k]]] = p;
        value[next[m.column[k]]++] = m.value[k];
      }
  }
};

/// T with entries ordered (row, direction), both triangles: for each row the 3 x 3 blocks of its neighbors in M W M^T
/// (diagonal) and of S, collected in a table of all rows.
Sparse assemble(const MultiplierRows& m, const std::vector<InterfaceBlock>& s) {
  const Index rows = m.rows();
  const Columns columns(m);
  struct Place {
    const InterfaceBlock* block = nullptr;
    Index at = 0;  // row within the block
  };
  std::vector<Place> place(rows);
  for (const InterfaceBlock& block : s)
    for (Index p = 0; p < block.rows; ++p)
      place[block.index != nullptr ? block.index[p] : block.first + p] = {&block, p};

  std::vector<std::array<double, 9>> sum(rows);
  std::vector<Index> last(rows, -1), neighbors;
  Sparse t(3 * rows, 3 * rows);
  t.reserve(static_cast<Eigen::Index>(9 * m.value.size() / 2));
  for (Index p = 0; p < rows; ++p) {
    neighbors.clear();
    const auto block_of = [&](Index q) -> std::array<double, 9>& {
      if (last[q] != p) {
        last[q] = p;
        sum[q].fill(0.0);
        neighbors.push_back(q);
      }
      return sum[q];
    };
    for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k) {
      const std::size_t c = m.column[k];
      const double* w = &m.weight[3 * c];
      for (Index j = columns.begin[c]; j < columns.begin[c + 1]; ++j) {
        std::array<double, 9>& entry = block_of(columns.row[j]);
        const double product = m.value[k] * columns.value[j];
        for (int i = 0; i < 3; ++i) entry[4 * i] += product * w[i];
      }
    }
    if (!m.others.empty()) {
      std::array<double, 9>& entry = block_of(p);
      for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k) {
        const std::size_t c = m.column[k];
        const double product = std::max(0.0, m.value[k] * m.others[c]);
        for (int i = 0; i < 3; ++i) entry[4 * i] += product * m.weight[3 * c + i];
      }
    }
    if (const InterfaceBlock* block = place[p].block; block != nullptr) {
      const Index at = place[p].at;
      if (block->dense == nullptr) {
        std::array<double, 9>& entry = block_of(p);
        for (int i = 0; i < 9; ++i) entry[i] += block->local[9 * static_cast<std::size_t>(at) + i];
      } else {
        for (Index q = 0; q < block->rows; ++q) {
          std::array<double, 9>& entry = block_of(block->index != nullptr ? block->index[q] : block->first + q);
          for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
              entry[3 * i + j] += block->dense[static_cast<std::size_t>(3 * at + i) * (3 * block->rows) + 3 * q + j];
        }
      }
    }
    std::sort(neighbors.begin(), neighbors.end());
    for (int i = 0; i < 3; ++i) {
      t.startVec(3 * p + i);
      for (const Index q : neighbors)
        for (int j = 0; j < 3; ++j)
          if (i == j || sum[q][3 * i + j] != 0.0) t.insertBack(3 * p + i, 3 * q + j) = sum[q][3 * i + j];
    }
  }
  t.finalize();
  return t;
}

}  // namespace

struct MultiplierFactor::Implementation {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  void* numeric = nullptr;  // UMFPACK
  Sparse t;                 // row-major T; its arrays read as columns are T^T, which UMFPACK solves as the transpose
  Index size = 0;
  std::unique_ptr<MultiplierBlocks> blocks;  // in place of factors
  std::unique_ptr<RowOverlap> overlap;       // whose rows the factors are of
  MinimalResiduals residuals;                // of solve_all
  std::vector<std::vector<double>> answers;  // directions there, shape=(own rows,3)

  Implementation() {
    cholmod_start(&common);
    common.print = 0;
    common.final_ll = 1;  // LL^T, so that an indefinite matrix is noticed
    common.try_catch = 1;
  }
  ~Implementation() {
    clear();
    cholmod_finish(&common);
  }
  void clear() {
    if (factor != nullptr) cholmod_free_factor(&factor, &common);
    if (numeric != nullptr) umfpack_di_free_numeric(&numeric);
    factor = nullptr;
    numeric = nullptr;
    t = Sparse();
  }

  bool cholesky() {
    const Sparse symmetric = 0.5 * (t + Sparse(t.transpose()));
    cholmod_sparse view{};
    view.nrow = view.ncol = size;
    view.nzmax = symmetric.nonZeros();
    view.p = const_cast<int*>(symmetric.outerIndexPtr());
    view.i = const_cast<int*>(symmetric.innerIndexPtr());
    view.x = const_cast<double*>(symmetric.valuePtr());
    view.stype = 1;  // the upper triangle of the (symmetric) matrix is used
    view.itype = CHOLMOD_INT;
    view.xtype = CHOLMOD_REAL;
    view.dtype = CHOLMOD_DOUBLE;
    view.sorted = 1;
    view.packed = 1;
    factor = cholmod_analyze(&view, &common);
    if (factor == nullptr) return false;
    cholmod_factorize(&view, factor, &common);
    if (common.status == CHOLMOD_OK && factor->minor == factor->n) return true;
    cholmod_free_factor(&factor, &common);
    factor = nullptr;
    return false;
  }

  bool factorize(const MultiplierRows& m, const std::vector<InterfaceBlock>& s) {
    t = assemble(m, s);
    for (Index k = 0; k < t.nonZeros(); ++k)
      if (!std::isfinite(t.valuePtr()[k])) return false;
    return cholesky() || lu();
  }

  void solve(double* b) {
    if (factor != nullptr) {
      cholmod_dense right{};
      right.nrow = right.d = size;
      right.ncol = 1;
      right.nzmax = size;
      right.x = b;
      right.xtype = CHOLMOD_REAL;
      right.dtype = CHOLMOD_DOUBLE;
      cholmod_dense* x = cholmod_solve(CHOLMOD_A, factor, &right, &common);
      std::copy_n(static_cast<const double*>(x->x), size, b);
      cholmod_free_dense(&x, &common);
      return;
    }
    std::vector<double> x(size);
    umfpack_di_solve(UMFPACK_Aat, t.outerIndexPtr(), t.innerIndexPtr(), t.valuePtr(), x.data(), b, numeric, nullptr,
                     nullptr);
    std::copy(x.begin(), x.end(), b);
  }

  /// product = T z on own rows. Collective.
  void apply(const std::vector<double>& z, std::vector<double>& product) {
    const std::vector<double>& all = overlap->bring(z.data());
    product.resize(z.size());
    const int* begin = t.outerIndexPtr();
    for (std::size_t i = 0; i < z.size(); ++i) {
      double sum = 0.0;
      for (int k = begin[i]; k < begin[i + 1]; ++k) sum += t.valuePtr()[k] * all[t.innerIndexPtr()[k]];
      product[i] = sum;
    }
  }

  /// b <- T^-1 b by minimal residuals, each direction the answer of the factors to the residual. Collective.
  void solve_all(double* b) {
    const std::size_t own = 3 * static_cast<std::size_t>(overlap->own_rows());
    std::vector<double> rest(b, b + own);
    residuals.start();
    for (int i = 0; i < most_steps; ++i) {
      if (i == static_cast<int>(answers.size())) answers.emplace_back();
      std::vector<double>& all = overlap->bring(rest.data());
      if (size > 0) solve(all.data());
      answers[i].assign(all.begin(), all.begin() + static_cast<std::ptrdiff_t>(own));
      apply(answers[i], residuals.product());
      const MinimalResiduals::State state = residuals.step(overlap->comm(), rest, enough);
      if (state == MinimalResiduals::State::not_finite) {
        std::fill_n(b, own, std::numeric_limits<double>::quiet_NaN());
        return;
      }
      if (state != MinimalResiduals::State::goes_on) break;
    }
    std::fill_n(b, own, 0.0);
    const std::vector<double> c = residuals.coefficients();
    for (std::size_t i = 0; i < c.size(); ++i)
      for (std::size_t k = 0; k < own; ++k) b[k] += c[i] * answers[i][k];
  }

  bool lu() {
    void* symbolic = nullptr;
    if (umfpack_di_symbolic(size, size, t.outerIndexPtr(), t.innerIndexPtr(), t.valuePtr(), &symbolic, nullptr,
                            nullptr) != 0)
      return false;
    const int status =
        umfpack_di_numeric(t.outerIndexPtr(), t.innerIndexPtr(), t.valuePtr(), symbolic, &numeric, nullptr, nullptr);
    umfpack_di_free_symbolic(&symbolic);
    return status == UMFPACK_OK;
  }
};

MultiplierFactor::MultiplierFactor() : implementation_(std::make_unique<Implementation>()) {}
MultiplierFactor::~MultiplierFactor() = default;

bool MultiplierFactor::factorize(MultiplierRows m, const std::vector<InterfaceBlock>& s, Use use) {
  Implementation& self = *implementation_;
  self.clear();
  self.overlap.reset();
  self.size = 3 * m.rows();
  const bool by_blocks = self.size > 0 && use != Use::exact && MultiplierBlocks::suits(m, s);
  if (!by_blocks) self.blocks.reset();
  if (self.size == 0) return true;
  if (by_blocks) {
    if (self.blocks == nullptr) self.blocks = std::make_unique<MultiplierBlocks>();
    return self.blocks->factorize(std::move(m), s, use == Use::preconditioner);
  }
  return self.factorize(m, s);
}

void MultiplierFactor::clear() {
  implementation_->clear();
  implementation_->blocks.reset();
  implementation_->overlap.reset();
  implementation_->size = 0;
}

bool MultiplierFactor::factorize(std::unique_ptr<RowOverlap> overlap) {
  Implementation& self = *implementation_;
  self.clear();
  self.blocks.reset();
  self.overlap = std::move(overlap);
  self.size = 3 * self.overlap->rows().rows();
  const bool done = self.size == 0 || self.factorize(self.overlap->rows(), self.overlap->blocks());
  self.overlap->release();
  return done;
}

void MultiplierFactor::solve(double* b) const {
  Implementation& self = *implementation_;
  if (self.overlap != nullptr) {
    self.solve_all(b);
    return;
  }
  if (self.size == 0) return;
  if (self.blocks != nullptr) return self.blocks->solve(b);
  self.solve(b);
}

void MultiplierFactor::precondition(double* b) const {
  if (implementation_->size > 0 && implementation_->blocks != nullptr) return implementation_->blocks->solve(b, 0);
  solve(b);
}

bool MultiplierFactor::is_approximate() const {
  return implementation_->blocks != nullptr && !implementation_->blocks->is_exact();
}

GlobalIndex MultiplierFactor::factor_entries() const {
  if (implementation_->blocks != nullptr) return implementation_->blocks->entries();
  return implementation_->factor != nullptr ? static_cast<GlobalIndex>(implementation_->common.lnz) : 0;
}

}  // namespace fbi::linalg
