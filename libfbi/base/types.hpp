/// Types that every room uses.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace fbi {

/// Number of something on this rank.
using Index = std::int32_t;
/// Number of something over all ranks, and every number in a file.
using GlobalIndex = std::int64_t;

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;

}  // namespace fbi
