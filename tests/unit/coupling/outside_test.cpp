// What lies outside the fluid: measured, allowed up to a hundredth of a fiber, refused beyond.
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "scene.hpp"

namespace fbi::test {
namespace {

using coupling::Coupling;
using coupling::CouplingParameters;
using coupling::Outside;

TEST(Outside, HalfOutsideIsAnErrorThatNamesTheFiber) {
  for (const double amount : {0.0, 0.03}) {
    mesh::FiberMeshData fibers = random_lines(6, 0.2, 0.8, 2, 21);
    add_line(fibers, Vec3(0.3, 0.4, 0.5), Vec3(0.3, 1.6, 0.5), 4, "stalk/3", 1);
    const mesh::HexMeshData mesh = amount > 0 ? perturbed(cube(4), amount, 22) : cube(4);
    const Scene scene(mesh, fibers);
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    try {
      coupling.update(moved(scene.fibers, Vec3::Zero()));
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::geometry);
      EXPECT_NE(std::string(error.what()).find("'stalk/3' lies 50 %"), std::string::npos) << error.what();
    }
    CouplingParameters allow;
    allow.outside = Outside::allow;
    Coupling allowed(scene.fluid, scene.fibers, allow);
    allowed.update(moved(scene.fibers, Vec3::Zero()));
    EXPECT_NEAR(allowed.coverage().outside, 0.6, 1e-13);
    EXPECT_NEAR(allowed.coverage().covered, reference_length(scene) - 0.6, 1e-13);
    EXPECT_NEAR(allowed.coverage().worst_fraction, 0.5, 1e-13);
    EXPECT_EQ(allowed.coverage().worst_fiber, "stalk/3");
    EXPECT_EQ(allowed.coverage().fibers_outside, 1);
    EXPECT_LT(allowed.coverage().identity_error, 1e-14);
    const double zeros = static_cast<double>(std::count(allowed.kappa().begin(), allowed.kappa().end(), 0.0));
    EXPECT_EQ(scene.comm.sum(zeros), 2.0);  // nodes at y = 1.3 and 1.6 touch no covered part
  }
}

TEST(Outside, LessThanAHundredthIsAllowed) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.3, 0.51, 0.5), Vec3(0.3, 1.004, 0.5), 2);
  const Scene scene(cube(4), fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update(moved(scene.fibers, Vec3::Zero()));
  EXPECT_NEAR(coupling.coverage().outside, 0.004, 1e-13);
  EXPECT_EQ(coupling.coverage().fibers_outside, 1);
}

TEST(Outside, LeavingAndReenteringIsMeasured) {
  for (const double amount : {0.0, 0.03}) {
    mesh::FiberMeshData fibers;
    add_line(fibers, Vec3(0.3, 0.9, 0.5), Vec3(0.6, 0.9, 0.5), 1, "arch");
    const mesh::HexMeshData mesh = amount > 0 ? perturbed(cube(4), amount, 23) : cube(4);
    const Scene scene(mesh, fibers);
    CouplingParameters allow;
    allow.outside = Outside::allow;
    Coupling coupling(scene.fluid, scene.fibers, allow);
    // y(x) = 0.9 + 0.2 (1 - x^2) by tangents of slope -+0.4: outside where |x| < sqrt(1/2).
    std::vector<double> dofs = moved(scene.fibers, Vec3::Zero());
    if (!dofs.empty()) {
      dofs[4] = 0.4 / 0.15;
      dofs[10] = -0.4 / 0.15;
    }
    coupling.update(dofs);
    EXPECT_NEAR(coupling.coverage().worst_fraction, std::sqrt(0.5), 1e-14);
    EXPECT_NEAR(coupling.coverage().outside, 0.3 * std::sqrt(0.5), 1e-14);
  }
}

TEST(Outside, BoundaryCountsAsInsideToABillionthOfACell) {
  for (const bool general : {false, true}) {
    mesh::FiberMeshData fibers;
    add_line(fibers, Vec3(0.3, 0.0, 0.5), Vec3(0.3, 0.5, 0.5), 2);   // foot on the floor
    add_line(fibers, Vec3(0.2, 0.3, 0.0), Vec3(0.9, 0.35, 0.0), 2);  // lying on a wall
    const Scene scene(cube(4, general), fibers);
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    coupling.update(moved(scene.fibers, Vec3(0.0, -2e-10, -2e-10)));
    EXPECT_EQ(coupling.coverage().outside, 0.0);
    CouplingParameters allow;
    allow.outside = Outside::allow;
    Coupling below(scene.fluid, scene.fibers, allow);
    below.update(moved(scene.fibers, Vec3(0.0, 0.0, -2e-9)));
    EXPECT_NEAR(below.coverage().worst_fraction, 1.0, 1e-14);
  }
}

TEST(Outside, WhollyOutside) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(3.0, 3.0, 3.0), Vec3(3.5, 3.0, 3.0), 2, "lost");
  const Scene scene(cube(3, true), fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  EXPECT_THROW(coupling.update(moved(scene.fibers, Vec3::Zero())), Error);
}

}  // namespace
}  // namespace fbi::test
