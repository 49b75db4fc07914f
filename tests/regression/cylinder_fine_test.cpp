/// Steady flow past a cylinder at Reynolds number 20 on the mesh of cases/dfg-2d-1.
#include "record.hpp"
#include "regression/cylinder.hpp"

namespace fbi::test {
namespace {

TEST(CylinderFine, drag_lift_and_pressure_at_re_20) {
  const Cylinder coarse = steady_cylinder(64), fine = steady_cylinder(128), &exact = reference_2d_1;
  const Cylinder order = {std::log2((coarse.drag - exact.drag) / (fine.drag - exact.drag)), not_given,
                          std::log2((coarse.pressure - exact.pressure) / (fine.pressure - exact.pressure))};
  record_2d_1("128", fine, order, {0.0005, 0.005, 0.001});
  EXPECT_GT(order.drag, 1.8);
  EXPECT_GT(order.pressure, 0.8);
}

}  // namespace
}  // namespace fbi::test
