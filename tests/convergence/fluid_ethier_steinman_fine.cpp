// The finest pair of meshes that a sparse factorisation allows in minutes: orders in space of velocity and pressure.
#include "convergence/ethier_steinman.hpp"

namespace fbi::fluid::test {
namespace {

TEST(EthierSteinmanFine, OrderInSpace) {
  linalg::initialize_petsc();
  const Errors order =
      orders(space_errors(uniform(-1, 1, 16), 0, true, 40), space_errors(uniform(-1, 1, 24), 0, true, 40), 1.5);
  EXPECT_GE(order.velocity, 1.9);
  EXPECT_GE(order.pressure, 1.4);
}

}  // namespace
}  // namespace fbi::fluid::test
