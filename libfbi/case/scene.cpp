#include "case/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/log.hpp"
#include "base/progress.hpp"
#include "fem/hex8.hpp"

namespace fbi::cases {
namespace {

constexpr int time_samples = 20;  // of prescribed velocities, to find the largest

/// What is known of the velocity beforehand, over the nodes of this rank.
struct Speeds {
  double largest = 0.0;   ///< prescribed on the boundary over the run, or given initially
  double at_start = 0.0;  ///< prescribed on the boundary at t = 0
  double change = 0.0;    ///< of a prescribed velocity in one step, largest at some sampled times
};

Speeds prescribed_speeds(const CaseParameters& parameters, const mesh::HexMesh& mesh, double dt) {
  Speeds speeds;
  const auto value = [](const std::array<const input::Expression*, 3>& v, const double* x, double t) {
    Vec3 velocity;
    for (int i = 0; i < 3; ++i) velocity[i] = v[i] != nullptr ? (*v[i])(x[0], x[1], x[2], t) : 0.0;
    return velocity;
  };
  for (const auto& [name, condition] : parameters.boundaries()) {
    if (condition.type != fluid::BoundaryType::inflow && condition.type != fluid::BoundaryType::mixed) continue;
    std::array<const input::Expression*, 3> v{};
    bool time_dependent = false;
    for (int i = 0; i < 3; ++i)
      if (condition.velocity[i]) {
        v[i] = &*condition.velocity[i];
        time_dependent = time_dependent || v[i]->depends_on_time();
      }
    const auto faces = mesh.faces.find(name);
    if (faces == mesh.faces.end()) continue;
    for (const mesh::HexMesh::LocalFace& face : faces->second)
      for (const int a : fem::hex8_faces[face.face]) {
        const double* x = mesh.node(mesh.cells[8 * static_cast<std::size_t>(face.cell) + a]);
        for (int k = 0; k <= (time_dependent ? time_samples : 0); ++k) {
          const double t = parameters.time.end * k / time_samples;
          const Vec3 velocity = value(v, x, t);
          speeds.largest = std::max(speeds.largest, velocity.norm());
          if (k == 0) speeds.at_start = std::max(speeds.at_start, velocity.norm());
          if (time_dependent && k < time_samples)
            speeds.change = std::max(speeds.change, (value(v, x, t + dt) - velocity).norm());
        }
      }
  }
  const input::VectorExpression& initial = parameters.fluid->initial_velocity;
  if (!initial[0].is_zero() || !initial[1].is_zero() || !initial[2].is_zero())
    for (Index a = 0; a < mesh.owned_nodes; ++a)
      speeds.largest =
          std::max(speeds.largest, value({&initial[0], &initial[1], &initial[2]}, mesh.node(a), 0.0).norm());
  return speeds;
}

/// Smallest side of the axis-aligned box around the mesh.
double smallest_extent(const mesh::HexMesh& mesh) {
  std::array<double, 6> ends;  // largest of -x, -y, -z, x, y, z
  ends.fill(-std::numeric_limits<double>::max());
  for (Index a = 0; a < mesh.local_nodes(); ++a)
    for (int d = 0; d < 3; ++d) {
      ends[d] = std::max(ends[d], -mesh.node(a)[d]);
      ends[d + 3] = std::max(ends[d + 3], mesh.node(a)[d]);
    }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 6, MPI_DOUBLE, MPI_MAX, mesh.comm.get());
  return std::min({ends[0] + ends[3], ends[1] + ends[4], ends[2] + ends[5]});
}

}  // namespace

Scene inspect(const Setup& setup) {
  const CaseParameters& parameters = setup.parameters;
  const mesh::HexMesh* fluid = setup.fluid_mesh.get();
  const mesh::FiberMesh& fibers = *setup.fiber_mesh;
  const beam::BeamField* beams = setup.beams.get();
  Scene scene;
  const Comm& comm = fibers.comm;
  const GlobalIndex every = parameters.output.every;
  scene.outputs = 2 + (every > 0 ? (setup.steps - 1) / every : 0);  // first, last and those between
  scene.direct = is_solved_directly(setup);
  scene.memory = memory_need(setup, scene.direct);
  scene.disk_per_output = 72.0 * static_cast<double>(fibers.global_elements * parameters.output.fiber_points) +
                          48.0 * static_cast<double>(fibers.global_nodes);
  scene.disk_per_checkpoint = 8.0 * 48.0 * static_cast<double>(fibers.global_nodes);
  scene.fibers = fibers.global_fibers;
  scene.fiber_dofs = 6 * fibers.global_nodes;
  if (beams != nullptr) {
    scene.highest_frequency = comm.max(beams->highest_frequency());
    double longest = 0.0;
    for (Index f = 0; f < fibers.fibers(); ++f) {
      double length = 0.0;
      for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e) length += fibers.element_length[e];
      longest = std::max(longest, length);
    }
    scene.fiber_length = comm.max(longest);
    for (const FiberGroup& group : parameters.fibers) {
      scene.largest_radius = std::max(scene.largest_radius, group.physics.section.radius);
      if (group.physics.formulation != beam::Formulation::torsion_free &&
          group.physics.formulation != beam::Formulation::simo_reissner)
        continue;
      const double stiffness = group.physics.material.young * group.physics.section.inertia;
      scene.stiffness = scene.stiffness == 0.0 ? stiffness : std::min(scene.stiffness, stiffness);
    }
  }
  if (fluid == nullptr) return scene;
  scene.fluid_nodes = fluid->global_nodes;
  scene.fluid_dofs = 4 * fluid->independent_nodes;
  scene.multiplier_dofs = beams != nullptr ? 3 * fibers.global_nodes : 0;
  scene.smallest_cell = setup.fluid->smallest_cell();
  const Speeds speeds = prescribed_speeds(parameters, *fluid, setup.dt);
  scene.speed = comm.max(speeds.largest);
  scene.start_speed = comm.max(speeds.at_start);
  scene.speed_change = comm.max(speeds.change);
  scene.height = smallest_extent(*fluid);
  scene.disk_per_output += 32.0 * static_cast<double>(scene.fluid_nodes);
  scene.disk_per_checkpoint += 96.0 * static_cast<double>(scene.fluid_nodes);
  if (setup.averages != nullptr) {
    const double bytes = 8.0 * RunningMean::components * static_cast<double>(scene.fluid_nodes);
    scene.memory.fluid += bytes;
    scene.disk_per_output += bytes;
    scene.disk_per_checkpoint += bytes;
  }
  return scene;
}

void print_scene(const Scene& scene, const Setup& setup) {
  const CaseParameters& parameters = setup.parameters;
  const double dt = setup.dt;
  if (scene.fluid_dofs > 0)
    log::info("fluid         %lld unknowns (%lld nodes), smallest cell %.4g", static_cast<long long>(scene.fluid_dofs),
              static_cast<long long>(scene.fluid_nodes), scene.smallest_cell);
  if (scene.fibers > 0)
    log::info("fibers        %lld with %lld unknowns, %lld multipliers", static_cast<long long>(scene.fibers),
              static_cast<long long>(scene.fiber_dofs), static_cast<long long>(scene.multiplier_dofs));
  if (scene.fluid_dofs > 0 && scene.largest_radius > 0.0)
    log::info(
        "resolution    h = %.2f fiber diameters (the fluid does not see the radius, only h: drag is that of a radius "
        "of 0.06 h to 0.6 h)",
        scene.smallest_cell / (2.0 * scene.largest_radius));
  if (scene.fluid_dofs > 0) {
    const double density = parameters.fluid->density, viscosity = parameters.fluid->viscosity;
    log::info("Reynolds      %.4g (largest prescribed speed %.4g, smallest extent %.4g)%s",
              density * scene.speed * scene.height / viscosity, scene.speed, scene.height,
              scene.largest_radius > 0.0 ? log::format(", %.4g on the fiber diameter",
                                                       density * scene.speed * 2.0 * scene.largest_radius / viscosity)
                                               .c_str()
                                         : "");
    if (dt > 0.0)
      log::info("CFL           %.3g (speed dt / h), mu dt/(rho h^2) = %.3g", scene.speed * dt / scene.smallest_cell,
                viscosity * dt / (density * scene.smallest_cell * scene.smallest_cell));
    const fluid::FluidParameters& fluid = *parameters.fluid;
    const bool given = std::any_of(fluid.initial_velocity.begin(), fluid.initial_velocity.end(),
                                   [](const input::Expression& v) { return !v.is_zero(); });
    if (dt > 0.0 && given && scene.speed * dt < 0.01 * scene.smallest_cell && fluid.tau_time &&
        fluid.pressure_stabilization == fluid::PressureStabilization::pspg)
      log::warning(
          "the time step is small (CFL below 0.01) and the initial velocity is given: with PSPG the pressure is rough, "
          "in "
          "the first steps in error by about 0.01/CFL; take larger steps, or, in slow flow, use "
          "\"pressure_stabilization\": \"projection\" (docs/pressure-stabilization.md)");
    if (scene.stiffness > 0.0)
      log::info("Cauchy        %.4g (rho U^2 d L^3 / (2 EI), longest fiber)",
                0.5 * density * scene.speed * scene.speed * 2.0 * scene.largest_radius *
                    std::pow(scene.fiber_length, 3) / scene.stiffness);
  }
  if (scene.highest_frequency > 0.0 && dt > 0.0 && parameters.beam_time.scheme != beam::TimeScheme::static_)
    log::info("fiber modes   highest omega dt = %.3g (implicit: no limit; above 1 it is not resolved)",
              scene.highest_frequency * dt);
  const double total = scene.memory.total();
  const int ranks = setup.fiber_mesh->comm.size();
  log::info("memory        about %s for all ranks together%s%s", memory_text(total).c_str(),
            ranks > 1 ? log::format(", %s a rank", memory_text(total / ranks).c_str()).c_str() : "",
            scene.memory.factors > 0.0 ? log::format(" (factors %s)", memory_text(scene.memory.factors).c_str()).c_str()
                                       : "");
  log::info("disk          about %s an output, %s for all %lld; %s a checkpoint, two are kept",
            memory_text(scene.disk_per_output).c_str(),
            memory_text(scene.disk_per_output * static_cast<double>(scene.outputs)).c_str(),
            static_cast<long long>(scene.outputs), memory_text(scene.disk_per_checkpoint).c_str());
}

void print_skipped(const CaseParameters& parameters, const fsi::System& system, bool box, bool direct) {
  std::string skipped;
  const auto skip = [&](bool condition, const char* text) {
    if (condition) skipped += std::string(skipped.empty() ? "" : "; ") + text;
  };
  skip(!system.has_fibers(), "no fibers: no search, no multipliers");
  skip(!system.has_fluid(), "no fluid: fibers alone");
  skip(system.is_coupled() && !system.fibers_move(),
       "fibers do not move: no beam solve, one search and one multiplier factor");
  skip(system.is_coupled() && system.scheme().direction == fsi::Direction::fiber_only,
       "fluid without fibers: no multipliers in its equations");
  skip(system.is_coupled() && system.fibers_move() && system.scheme().direction == fsi::Direction::fluid_only,
       "fibers without fluid: nothing condensed");
  if (system.has_fluid()) {
    skip(parameters.fluid->convective_form == fluid::ConvectiveForm::none,
         "no convection: tau and preconditioner once for each time step size");
    skip(direct, "direct solver: no preconditioner");
    skip(parameters.fluid_time.scheme == fluid::TimeScheme::steady, "steady: no history");
    skip(box, "box mesh: constant Jacobians");
  }
  skip(parameters.output.every == 0, "no output between first and last step");
  if (!skipped.empty()) log::info("skipped       %s", skipped.c_str());
}

}  // namespace fbi::cases
