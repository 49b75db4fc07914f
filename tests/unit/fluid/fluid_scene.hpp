/// A flow with every kind of boundary in a rough state, for tests of residual and tangent.
#pragma once

#include "fluid_fixture.hpp"

namespace fbi::fluid::test {

/// Options of a scene.
struct Option {
  const char* name;
  double warp;
  ConvectiveForm form;
  ViscousResidual viscous;
  TimeScheme scheme;
  double theta;
  void (*more)(FluidParameters&) = nullptr;  ///< sets what has no member here
};

/// A flow with every kind of boundary: the velocity points inwards on part of the outflow (backflow).
struct Scene {
  mesh::HexMesh mesh;
  FluidField field;
  Scene(const Comm& comm, const Option& option, bool general = false)
      : mesh(box_mesh(comm, {graded(0, 1.5, 5, 1.2), uniform(0, 1, 4), graded(0, 1, 3, 0.8)}, general, option.warp)),
        field(mesh, fluid_parameters(option), conditions(), {option.scheme, option.theta}) {
    field.initialize();
    const double dt = option.scheme == TimeScheme::steady ? 0.0 : 0.02;
    field.begin_step(0.02, dt);
    // a rough state on top, so that no term is small by chance
    linalg::VecHandle delta = field.create_vector();
    const auto add = [&](int seed) {
      fill(mesh, delta, [&](GlobalIndex node, int c) { return 0.3 * noise(node, c, seed); });
      drop_dirichlet(delta);
      field.increment(delta);
    };
    add(1);
    field.accept_step();
    field.begin_step(0.05, option.scheme == TimeScheme::steady ? 0.0 : 0.03);
    add(2);
    field.linearize();
  }
  void drop_dirichlet(Vec v) const {
    PetscScalar* array = nullptr;
    FBI_PETSC(VecGetArray(v, &array));
    for (Index k = 0; k < 4 * mesh.owned_nodes; ++k)
      if (field.is_dirichlet()[k]) array[k] = 0;
    FBI_PETSC(VecRestoreArray(v, &array));
  }
  static FluidParameters fluid_parameters(const Option& option) {
    FluidParameters p;
    p.density = 1.7;
    p.viscosity = 0.03;
    p.convective_form = option.form;
    p.viscous_residual = option.viscous;
    p.body_force = expressions("1+y", "0.5*t", "x*z");
    if (option.more != nullptr) option.more(p);
    p.initial_velocity = expressions("sin(3*y)+z", "cos(2*x)*z", "x-y");
    return p;
  }
  static BoundaryConditions conditions() {
    BoundaryConditions all;
    all["xmin"] = velocity(expressions("y*(1-y)*(1+t)", "0", "0.1*z"));
    all["xmax"] = of_type(BoundaryType::outflow);
    all["xmax"].backflow = true;
    all["xmax"].backflow_beta = 0.7;
    all["ymin"] = of_type(BoundaryType::no_slip);
    all["ymax"] = of_type(BoundaryType::slip);
    all["zmin"] = of_type(BoundaryType::traction);
    all["zmin"].traction = expressions("1", "y", "t");
    all["zmax"] = of_type(BoundaryType::mixed);
    all["zmax"].velocity[0] = input::Expression(0.25);
    all["zmax"].traction = expressions("5", "1", "x");
    return all;
  }
};

/// Largest difference of the tangent's action and central differences of the residual, relative to the former.
inline double tangent_error(Scene& scene, int seed) {
  linalg::VecHandle x = scene.field.create_vector(), y = scene.field.create_vector(),
                    plus = scene.field.create_vector(), minus = scene.field.create_vector();
  fill(scene.mesh, x, [&](GlobalIndex node, int c) { return noise(node, c, seed); });
  scene.drop_dirichlet(x);
  scene.field.apply_jacobian(x, y);
  const double step = 1e-5;
  FBI_PETSC(VecScale(x, step));
  scene.field.increment(x);
  scene.field.residual(plus);
  FBI_PETSC(VecScale(x, -2));
  scene.field.increment(x);
  scene.field.residual(minus);
  FBI_PETSC(VecAXPY(plus, -1, minus));
  FBI_PETSC(VecScale(plus, 1 / (2 * step)));
  FBI_PETSC(VecAXPY(plus, -1, y));
  return largest(plus) / largest(y);
}

}  // namespace fbi::fluid::test
