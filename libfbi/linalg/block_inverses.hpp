/// Inverses of many small dense matrices, several at a time.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/types.hpp"

namespace fbi::linalg {

using DenseBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// inverses[f] = blocks[f]^-1, those of empty blocks are left alone. Symmetric positive definite blocks of one size are
/// inverted eight at a time without interchanges, others by LU. Returns false when one is singular or not finite.
bool invert(const std::vector<DenseBlock>& blocks, std::vector<DenseBlock>& inverses);

/// y = A x for a small A, shape=(n,n), its columns one after the other; what follows A is read, up to `read_beyond`
/// numbers, and not used.
void multiply_columns(Index n, const double* columns, const double* x, double* y);
inline constexpr std::size_t read_beyond = 15;
/// y = A x for a small A, shape=(n,n), row-major.
void multiply_rows(Index n, const double* rows, const double* x, double* y);

}  // namespace fbi::linalg
