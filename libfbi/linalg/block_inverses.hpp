/// Inverses of many small dense matrices, several at a time.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace fbi::linalg {

using DenseBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// inverses[f] = blocks[f]^-1, those of empty blocks are left alone. Symmetric positive definite blocks of one size are
/// inverted eight at a time without interchanges, others by LU. Returns false when one is singular or not finite.
bool invert(const std::vector<DenseBlock>& blocks, std::vector<DenseBlock>& inverses);

}  // namespace fbi::linalg
