/// A whole case: the parameters of all rooms, parsed and validated from one JSON file. Free of PETSc, HDF5 and MPI
/// calls.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "beam/parameters.hpp"
#include "coupling/parameters.hpp"
#include "fluid/parameters.hpp"
#include "fsi/parameters.hpp"
#include "mesh/parameters.hpp"

namespace fbi::cases {

/// The box channel, perhaps with a cylinder in it, and its boundary conditions.
struct Channel {
  mesh::BoxParameters box;
  std::optional<mesh::CylinderParameters> cylinder;
  fluid::BoundaryConditions boundaries;  ///< by face name xmin ... zmax (and cylinder); all must be given
};

/// A hexahedral mesh from a file with its boundary conditions.
struct MeshFile {
  mesh::MeshFileParameters source;
  fluid::BoundaryConditions boundaries;  ///< by face-set name of the mesh; every face set must be given
};

/// One entry of "fibers": geometry and physics.
struct FiberGroup {
  mesh::CurveParameters curve;
  mesh::ArrayParameters array;
  Index elements = 0;  ///< per fiber
  beam::FiberParameters physics;
};

/// Something recorded in every row of the history.
struct Probe {
  std::string fiber;  ///< name such as "patch/112/7"; empty for a point
  beam::End at = beam::End::end;
  Vec3 point = Vec3::Zero();
  bool forces = false;  ///< fiber probe: drag (force of the fluid on the fiber) and clamp reaction instead of the tip
};

/// Force of the fluid on some faces, recorded in every row of the history.
struct ForceOutput {
  std::string name;                ///< of the columns
  std::vector<std::string> faces;  ///< names of face sets
  std::optional<Vec3> about;       ///< moment about this point as well [length]
  double speed = 0.0;              ///< of the coefficients, > 0 when these are wanted [length/time]
  double area = 0.0;               ///< of the coefficients [length^2]
};

/// Running means of the flow, taken during the run.
struct Averages {
  double from = 0.0;  ///< steps that begin earlier do not count [time]
  Index every = 1;    ///< one in so many steps is taken in
};

struct Output {
  Index every = 0;                   ///< field output every N steps; 0 = first and last only
  Index checkpoint = 0;              ///< checkpoint every N steps; 0 = only at the end and by wall time
  double checkpoint_minutes = 30.0;  ///< checkpoint by wall time [min]
  Index fiber_points = 8;            ///< points per element on the written center line
  std::vector<Probe> probes;
  std::vector<ForceOutput> forces;
  std::optional<Averages> averages;  ///< missing = none
};

/// A number the run must reproduce.
struct Expectation {
  std::string quantity;  ///< a column of the history
  std::string source;    ///< where the value is from
  double value = 0.0;
  double tolerance = 0.0;  ///< relative when `relative`, else absolute
  bool relative = true;
  std::optional<double> time;   ///< at this time; missing = at the end
  std::string reduce = "last";  ///< last, max, min, max_abs over all steps (ignored when `time` is given)
};

struct CaseParameters {
  std::string title;
  std::optional<fluid::FluidParameters> fluid;  ///< missing = beam-only run
  std::optional<Channel> channel;               ///< either this or `mesh` is given exactly when `fluid` is
  std::optional<MeshFile> mesh;
  std::vector<FiberGroup> fibers;  ///< empty = fluid-only run
  std::vector<mesh::JointParameters> joints;  ///< between fibers
  Vec3 gravity = Vec3::Zero();     ///< acts on the fibers [length/time^2]
  bool buoyancy = false;           ///< the weight of the displaced fluid is taken off that of the fibers
  coupling::CouplingParameters coupling;
  fsi::SchemeParameters scheme;
  fsi::SolverParameters solver;
  fsi::TimeParameters time;
  fluid::FluidTimeParameters fluid_time;
  beam::BeamTimeParameters beam_time;
  Output output;
  std::vector<Expectation> expect;

  /// Conditions of the channel or of the mesh file.
  const fluid::BoundaryConditions& boundaries() const { return mesh ? mesh->boundaries : channel->boundaries; }

  /// How the cells of the channel or of the mesh file are placed on ranks.
  mesh::Partition partition() const {
    if (mesh) return mesh->source.partition;
    return channel && channel->cylinder ? channel->cylinder->partition : mesh::Partition::coordinates;
  }
};

/// Parses and validates the text of a case file. All errors at once: throws Error(usage) whose text holds one line
/// "name:line:column: path: what; what to do" for each. `name` is the file name used in them.
CaseParameters parse_case(const std::string& text, const std::string& name);

/// JSON Schema (draft 2020-12) of the case file, for editors.
std::string case_json_schema();

/// The input reference as Markdown, generated from the same field tables.
std::string case_reference();

}  // namespace fbi::cases
