#include "case/setup.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/log.hpp"
#include "base/timer.hpp"
#include "io/case_file.hpp"
#include "linalg/graph_partition.hpp"
#include "mesh/face_translation.hpp"

namespace fbi::cases {
namespace {

/// dt and number of steps; a steady flow is one step, statics default to one load step to load factor 1.
void choose_steps(Setup& setup) {
  const CaseParameters& p = setup.parameters;
  if (p.fluid && p.fluid_time.scheme == fluid::TimeScheme::steady) {
    setup.dt = 0.0;
    setup.steps = 1;
    return;
  }
  const bool statics = !p.fluid && p.beam_time.scheme == beam::TimeScheme::static_;
  const double end = p.time.end > 0.0 ? p.time.end : (statics ? 1.0 : 0.0);
  setup.dt = p.time.step > 0.0 ? p.time.step : (statics ? end : 0.0);
  if (!(setup.dt > 0.0) || !(end > 0.0))
    throw Error(ExitCode::usage, "time.step and time.end are needed; give both in the case file");
  setup.steps = static_cast<GlobalIndex>(std::ceil(end / setup.dt - 1e-6));
  if (std::abs(static_cast<double>(setup.steps) * setup.dt - end) > 1e-6 * setup.dt)
    log::warning("time.end %g is not a multiple of time.step %g; the run ends at %g", end, setup.dt,
                 static_cast<double>(setup.steps) * setup.dt);
}

/// The input inside a case file; fbi-gen has checked it, but perhaps not that of this version.
CaseParameters parse_input(const io::CaseHeader& header, const std::string& path) {
  try {
    return parse_case(header.json, header.json_name);
  } catch (const Error& error) {
    throw Error(error.code(), "the input in \"" + path + "\" is refused; correct " + header.json_name +
                                  " and run fbi-gen again:\n" + error.what());
  }
}

/// Adds what the coupling needs to know of fluid and fibers.
coupling::CouplingParameters complete_coupling(const Setup& setup, const CaseParameters& parameters) {
  coupling::CouplingParameters coupling = parameters.coupling;
  for (const FiberGroup& group : parameters.fibers)
    coupling.radius.push_back(std::sqrt(group.physics.section.area / std::numbers::pi));
  if (setup.fluid == nullptr) return coupling;
  coupling.viscosity = parameters.fluid->viscosity;
  for (const auto& [name, condition] : parameters.boundaries())
    if (condition.type == fluid::BoundaryType::periodic && name < condition.with)
      coupling.periods.push_back(mesh::face_translation(*setup.fluid_mesh, name, condition.with));
  return coupling;
}

}  // namespace

Setup make_setup(const CaseParameters& parameters, std::unique_ptr<mesh::HexMesh> fluid,
                 std::unique_ptr<mesh::FiberMesh> fibers) {
  linalg::initialize_petsc();
  Setup setup;
  setup.parameters = parameters;
  setup.fluid_mesh = std::move(fluid);
  setup.fiber_mesh = std::move(fibers);
  choose_steps(setup);
  setup.step_control = fsi::StepControl(setup.dt > 0.0 ? parameters.time.halvings : 0);
  if (setup.fluid_mesh != nullptr) {
    Timed timed("fluid setup");
    setup.fluid = std::make_unique<fluid::FluidField>(*setup.fluid_mesh, *parameters.fluid, parameters.boundaries(),
                                                      parameters.fluid_time);
    if (parameters.output.averages)
      setup.averages = std::make_unique<FlowAverages>(*parameters.output.averages, *setup.fluid_mesh);
  }
  if (setup.fiber_mesh->global_fibers > 0) {
    Timed timed("fiber setup");
    std::vector<beam::FiberParameters> groups;
    for (const FiberGroup& group : parameters.fibers) groups.push_back(group.physics);
    if (parameters.buoyancy && parameters.fluid)
      for (beam::FiberParameters& group : groups) group.displaced_density = parameters.fluid->density;
    setup.beams =
        std::make_unique<beam::BeamField>(*setup.fiber_mesh, groups, parameters.beam_time, parameters.gravity);
  }
  if (setup.fluid == nullptr && setup.beams == nullptr)
    throw Error(ExitCode::usage, "the case has neither fluid nor fibers; there is nothing to solve");
  setup.system =
      std::make_unique<fsi::System>(setup.fluid.get(), setup.beams.get(), setup.fiber_mesh.get(),
                                    complete_coupling(setup, parameters), parameters.scheme, parameters.solver);
  const bool prescribed = std::any_of(parameters.fibers.begin(), parameters.fibers.end(), [](const FiberGroup& group) {
    return group.physics.formulation == beam::Formulation::prescribed;
  });
  if (setup.dt == 0.0 && (setup.system->fibers_move() || prescribed))
    throw Error(
        ExitCode::usage,
        "steady flow with fibers that move is not possible; set \"formulation\": \"fixed\" for every fiber, or use "
        "\"one_step_theta\" for time.fluid.scheme");
  if (setup.system->is_coupled() && parameters.scheme.scheme != fsi::Scheme::monolithic)
    setup.acceleration = fsi::make_acceleration(setup.fiber_mesh->comm, parameters.scheme);
  return setup;
}

Setup read_setup(const Comm& comm, const std::string& path) {
  Timed timed("read case");
  const io::CaseHeader header = io::read_case_header(comm, path);
  const CaseParameters parameters = parse_input(header, path);
  std::unique_ptr<mesh::HexMesh> fluid;
  if (header.has_mesh())
    fluid = std::make_unique<mesh::HexMesh>(
        linalg::distribute(comm, io::read_mesh_chunk(comm, path), parameters.partition()));
  std::unique_ptr<mesh::FiberMesh> fibers = std::make_unique<mesh::FiberMesh>(io::read_fibers(comm, path, fluid.get()));
  return make_setup(parameters, std::move(fluid), std::move(fibers));
}

void initialize(Setup& setup) {
  Timed timed("initial state");
  if (setup.fluid != nullptr) setup.fluid->initialize();
  if (setup.beams != nullptr)
    setup.beams->initialize(std::vector<double>(6 * static_cast<std::size_t>(setup.fiber_mesh->nodes()), 0.0));
}

}  // namespace fbi::cases
