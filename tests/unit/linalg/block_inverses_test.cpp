/// Inverses of many blocks: symmetric ones in batches, others and indefinite ones one by one, singular ones refused.
#include "linalg/block_inverses.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace fbi::linalg {
namespace {

// Blocks of three sizes mixed, 8 do not divide their numbers; every fifth is not symmetric, every seventh indefinite.
std::vector<DenseBlock> blocks() {
  std::srand(4);
  std::vector<DenseBlock> list(45);
  for (int f = 0; f < 45; ++f) {
    const Eigen::Index n = f % 11 == 10 ? 0 : f % 3 == 0 ? 9 : f % 3 == 1 ? 12 : 1;
    const DenseBlock part = DenseBlock::Random(n, n), asymmetric = DenseBlock::Random(n, n);
    list[f] = part * part.transpose() + 0.1 * DenseBlock::Identity(n, n);
    if (f % 5 == 4) list[f] += 0.05 * asymmetric;
    if (f % 7 == 6) list[f] -= 1.0 * DenseBlock::Identity(n, n);
  }
  return list;
}

TEST(BlockInverses, AreInverses) {
  const std::vector<DenseBlock> list = blocks();
  std::vector<DenseBlock> inverses(list.size());
  ASSERT_TRUE(invert(list, inverses));
  for (std::size_t f = 0; f < list.size(); ++f) {
    const Eigen::Index n = list[f].rows();
    ASSERT_EQ(inverses[f].rows(), n);
    EXPECT_LE((list[f] * inverses[f] - DenseBlock::Identity(n, n)).norm(), 1e-10) << f;
  }
}

TEST(BlockInverses, SingularAndNotANumberAreStatuses) {
  for (const double entry : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
    std::vector<DenseBlock> list = blocks(), inverses(list.size());
    list[22].row(2).setConstant(entry);
    list[22].col(2).setConstant(entry);
    EXPECT_FALSE(invert(list, inverses));
  }
}

}  // namespace
}  // namespace fbi::linalg
