/// Builds everything that a case needs from its file.
#pragma once

#include <memory>
#include <string>

#include "case/averages.hpp"
#include "case/schema.hpp"
#include "fsi/acceleration.hpp"
#include "fsi/step_control.hpp"
#include "fsi/system.hpp"

namespace fbi::cases {

/// The meshes and fields of one case on this rank. Members are absent where the case does not need them.
struct Setup {
  CaseParameters parameters;
  std::unique_ptr<mesh::HexMesh> fluid_mesh;
  std::unique_ptr<mesh::FiberMesh> fiber_mesh;  ///< always there, perhaps without fibers
  std::unique_ptr<fluid::FluidField> fluid;
  std::unique_ptr<beam::BeamField> beams;
  std::unique_ptr<fsi::System> system;
  std::unique_ptr<fsi::Acceleration> acceleration;  ///< null for monolithic
  std::unique_ptr<FlowAverages> averages;           ///< null unless asked for
  fsi::StepControl step_control;
  double dt = 0.0;  ///< 0: one steady solution
  GlobalIndex steps = 0;
};

/// From meshes that are distributed already (they move in). Throws Error(usage or geometry) on all ranks for
/// combinations that cannot be solved. Collective.
Setup make_setup(const CaseParameters& parameters, std::unique_ptr<mesh::HexMesh> fluid,
                 std::unique_ptr<mesh::FiberMesh> fibers);

/// Reads a case file written by fbi-gen. Collective.
Setup read_setup(const Comm& comm, const std::string& path);

/// State at t = 0 in all fields. Not for a restart. Collective.
void initialize(Setup& setup);

}  // namespace fbi::cases
