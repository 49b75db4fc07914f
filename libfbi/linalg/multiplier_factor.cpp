#include "linalg/multiplier_factor.hpp"

#include <cholmod.h>
#include <umfpack.h>

#include <Eigen/SparseCore>
#include <cmath>

namespace fbi::linalg {
namespace {

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor, int>;

/// T with entries ordered (row, direction), both triangles.
Sparse assemble(const MultiplierRows& m, const std::vector<InterfaceBlock>& s) {
  const Index rows = m.rows();
  const Sparse matrix = Eigen::Map<const Sparse>(rows, m.columns(), static_cast<Index>(m.value.size()), m.begin.data(),
                                                 m.column.data(), m.value.data());
  std::vector<Eigen::Triplet<double, int>> entries;
  for (int i = 0; i < 3; ++i) {
    Eigen::VectorXd weight(m.columns());
    for (Index c = 0; c < m.columns(); ++c) weight[c] = m.weight[3 * static_cast<std::size_t>(c) + i];
    const Sparse scaled = matrix * weight.asDiagonal();
    const Sparse product = scaled * Sparse(matrix.transpose());
    if (i == 0) entries.reserve(3 * product.nonZeros());
    for (Index p = 0; p < rows; ++p)
      for (Sparse::InnerIterator entry(product, p); entry; ++entry)
        entries.emplace_back(3 * p + i, 3 * entry.col() + i, entry.value());
  }
  for (const InterfaceBlock& block : s) {
    if (block.dense == nullptr) {
      for (Index p = 0; p < block.rows; ++p)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) {
            const double value = block.local[9 * static_cast<std::size_t>(p) + 3 * i + j];
            if (i == j || value != 0.0)
              entries.emplace_back(3 * (block.first + p) + i, 3 * (block.first + p) + j, value);
          }
    } else {
      const Index n = 3 * block.rows;
      const auto row = [&block](Index a) {
        return 3 * (block.index != nullptr ? block.index[a / 3] : block.first + a / 3) + a % 3;
      };
      for (Index a = 0; a < n; ++a)
        for (Index b = 0; b < n; ++b)
          entries.emplace_back(row(a), row(b), block.dense[static_cast<std::size_t>(a) * n + b]);
    }
  }
  Sparse t(3 * rows, 3 * rows);
  t.setFromTriplets(entries.begin(), entries.end());
  return t;
}

}  // namespace

struct MultiplierFactor::Implementation {
  cholmod_common common;
  cholmod_factor* factor = nullptr;
  void* numeric = nullptr;  // UMFPACK
  Sparse t;                 // row-major T; its arrays read as columns are T^T, which UMFPACK solves as the transpose
  Index size = 0;

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

bool MultiplierFactor::factorize(const MultiplierRows& m, const std::vector<InterfaceBlock>& s) {
  Implementation& self = *implementation_;
  self.clear();
  self.size = 3 * m.rows();
  if (self.size == 0) return true;
  self.t = assemble(m, s);
  for (Index k = 0; k < self.t.nonZeros(); ++k)
    if (!std::isfinite(self.t.valuePtr()[k])) return false;
  return self.cholesky() || self.lu();
}

void MultiplierFactor::solve(double* b) const {
  const Implementation& self = *implementation_;
  if (self.size == 0) return;
  if (self.factor != nullptr) {
    cholmod_dense right{};
    right.nrow = right.d = self.size;
    right.ncol = 1;
    right.nzmax = self.size;
    right.x = b;
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_common* common = &implementation_->common;
    cholmod_dense* x = cholmod_solve(CHOLMOD_A, self.factor, &right, common);
    std::copy_n(static_cast<const double*>(x->x), self.size, b);
    cholmod_free_dense(&x, common);
    return;
  }
  std::vector<double> x(self.size);
  umfpack_di_solve(UMFPACK_Aat, self.t.outerIndexPtr(), self.t.innerIndexPtr(), self.t.valuePtr(), x.data(), b,
                   self.numeric, nullptr, nullptr);
  std::copy(x.begin(), x.end(), b);
}

GlobalIndex MultiplierFactor::factor_entries() const {
  return implementation_->factor != nullptr ? static_cast<GlobalIndex>(implementation_->common.lnz) : 0;
}

}  // namespace fbi::linalg
