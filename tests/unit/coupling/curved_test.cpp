/// Fibers that are curved at rest: ds = |dr_0/dx| dx varies along an element.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "fem/quadrature.hpp"
#include "meshgen/patterns.hpp"
#include "record.hpp"
#include "scene.hpp"

namespace fbi::test {
namespace {

using coupling::Coupling;
using coupling::CouplingParameters;

/// Helices of three turns, each of the length `helix_length`, and a hoop.
mesh::FiberMeshData coils(Index elements) {
  cases::FiberGroup coil, hoop;
  coil.physics.name = "coil";
  coil.elements = elements;
  coil.curve.type = mesh::CurveType::expression;
  coil.curve.position = {input::Expression("0.3+0.11*cos(t)"), input::Expression("0.25+0.11*sin(t)"),
                         input::Expression("0.1+0.8*t/(6*pi)")};
  coil.curve.end = 6 * std::numbers::pi;
  coil.array.counts = {2, 3, 1};
  coil.array.spacing = Vec3(0.4, 0.25, 0);
  hoop.physics.name = "hoop";
  hoop.elements = 9;
  hoop.curve.type = mesh::CurveType::arc;
  hoop.curve.from = Vec3(0.9, 0.5, 0.5);
  hoop.curve.center = Vec3(0.5, 0.5, 0.5);
  hoop.curve.normal = Vec3(0, 0, 1);
  hoop.curve.angle = 2 * std::numbers::pi;
  mesh::FiberMeshData fibers;
  std::vector<std::string> warnings;
  meshgen::add_group(coil, 0, fibers, warnings);
  meshgen::add_group(hoop, 1, fibers, warnings);
  return fibers;
}

const double helix_length = std::hypot(6 * std::numbers::pi * 0.11, 0.8);
const double hoop_length = 0.8 * std::numbers::pi;

TEST(CurvedFibers, IdentitiesInPerturbedMesh) {
  const mesh::HexMeshData mesh = perturbed(cube(8), 0.025, 3);
  const Scene scene(mesh, coils(24));
  CouplingParameters parameters;
  parameters.gauss_points = 10;
  Coupling coupling(scene.fluid, scene.fibers, parameters);
  for (const bool bent : {false, true}) {
    const std::vector<double> dofs = bent ? waved(scene.fibers, 0.05) : moved(scene.fibers, Vec3::Zero());
    coupling.update(dofs);
    const double length = reference_length(scene);
    EXPECT_NEAR(coupling.coverage().covered, length, 1e-9 * length);
    EXPECT_EQ(coupling.coverage().fibers_outside, 0);
    EXPECT_LT(coupling.coverage().identity_error, 1e-14);
    EXPECT_LT(linear_field_error(scene, coupling, dofs), 1e-14);
    double kappa = 0.0;
    for (const double value : coupling.kappa()) kappa += value;
    EXPECT_NEAR(scene.comm.sum(kappa), coupling.coverage().covered, 1e-13 * length);
    if (bent) continue;
    record({.section = "Coupling",
            .id = "",
            .check = "M.1 = D.1 = kappa on helices and a hoop in a distorted mesh, largest difference",
            .source = "identity",
            .ours = coupling.coverage().identity_error,
            .error = coupling.coverage().identity_error,
            .bar = "1e-14"});
  }
}

/// The covered length is that of the helices: order 4 in the element, as their interpolation.
TEST(CurvedFibers, CoveredLengthOfHelices) {
  const double exact = 6 * helix_length + hoop_length;
  double last = 0.0, order = 0.0;
  for (const Index elements : {24, 48}) {
    const Scene scene(perturbed(cube(8), 0.025, 3), coils(elements));
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    coupling.update(moved(scene.fibers, Vec3::Zero()));
    double hoop = 0.0;  // its elements stay the same
    for (Index f = 0; f < scene.fibers.fibers(); ++f)
      if (scene.fibers.group[f] == 1)
        for (Index e = scene.fibers.first_element(f); e < scene.fibers.first_element(f + 1); ++e)
          hoop += scene.fibers.element_length[e];
    const double error = std::abs(coupling.coverage().covered - scene.comm.sum(hoop) - 6 * helix_length);
    if (last > 0.0) order = std::log2(last / error);
    last = error;
    EXPECT_NEAR(scene.comm.sum(hoop), hoop_length, 5e-4 * hoop_length);
  }
  EXPECT_NEAR(order, 4.0, 0.1);
  record({.section = "Coupling",
          .id = "",
          .check = "covered length of 6 helices of 3 turns, 24 and 48 elements each, in a distorted mesh",
          .source = "exact solution",
          .error = last / exact,
          .order = order,
          .bar = "order 4"});
}

}  // namespace
}  // namespace fbi::test
