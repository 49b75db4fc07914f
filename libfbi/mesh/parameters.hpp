/// Parameters of the generated box channel and of fiber curves and arrays (what the generator makes).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "input/expression.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::mesh {

/// How the cells of one direction of a box are spread.
enum class Grading {
  uniform,    ///< equal cells
  geometric,  ///< each cell `ratio` times the one before it
  tanh,       ///< finer towards both ends; `ratio` = largest cell / smallest cell
};

struct GradingParameters {
  Grading type = Grading::uniform;
  double ratio = 1.0;
};

/// A box of hexahedra, [origin, origin + size].
struct BoxParameters {
  Vec3 origin = Vec3::Zero();                  ///< [length]
  Vec3 size = Vec3::Zero();                    ///< [length]
  std::array<Index, 3> elements = {0, 0, 0};   ///< cells along x, y, z
  std::array<GradingParameters, 3> grading{};  ///< along x, y, z
  bool general =
      false;  ///< true: treat as a general hexahedral mesh, the box fast path is not taken (for tests and timing)
};

/// How the cells of a mesh that is no box are placed on ranks.
enum class Partition {
  coordinates,  ///< recursive bisection of the cell centers
  graph,        ///< few faces between ranks: partition of the graph of neighboring cells
};

/// A coordinate axis.
enum class Axis { x, y, z };

/// A circular cylinder that stands across a channel, from wall to wall. A square block of rings lies around it; the
/// rest of the channel is a lattice that continues the cells at the sides of the block.
struct CylinderParameters {
  std::array<double, 2> center = {0.0, 0.0};  ///< in the order x, y, z without the axis [length]
  Axis axis = Axis::z;
  double radius = 0.0;  ///< [length]
  Index around = 0;     ///< cells around the circle, a multiple of 8; all other cells of the section follow from it
  Index layers = 1;     ///< equal cells along the axis
  double first = 0.5;   ///< thickness of the cells at the cylinder, relative to their length along the circle
  double block = 0.0;   ///< half width of the block [length]; 0: three radii, or 3/4 of the way to the nearest wall
  Partition partition = Partition::coordinates;
};

/// A mesh file of gmsh.
struct MeshFileParameters {
  std::string file;    ///< path, relative to the folder of the case file
  double scale = 1.0;  ///< coordinates of the file are multiplied by it
  Partition partition = Partition::coordinates;
};

enum class CurveType {
  line,        ///< from, to
  arc,         ///< part of a circle, or all of it
  expression,  ///< formulas of a parameter
  spline       ///< through points
};

/// Center line of one fiber, or of the first fiber of an array.
struct CurveParameters {
  CurveType type = CurveType::line;
  Vec3 from = Vec3::Zero();            ///< start of a line or arc [length]
  Vec3 to = Vec3::Zero();              ///< end of a line, or of an arc through three points [length]
  bool through_points = false;         ///< the arc is given by from, through, to; else by from, center, normal, angle
  Vec3 through = Vec3::Zero();         ///< a point of the arc between from and to [length]
  Vec3 center = Vec3::Zero();          ///< of the arc's circle [length]
  Vec3 normal = Vec3::Zero();          ///< axis about which the arc turns by the right-hand rule
  double angle = 0.0;                  ///< by which it turns [rad]
  input::VectorExpression position{};  ///< x, y, z as formulas of the parameter t [length]
  double begin = 0.0, end = 1.0;       ///< range of the parameter t
  std::vector<Vec3> points;            ///< of a spline [length]
};

/// Copies of a curve: fiber (i,j,k) is moved by (i,j,k)*spacing, componentwise.
struct ArrayParameters {
  std::array<Index, 3> counts = {1, 1, 1};
  Vec3 spacing = Vec3::Zero();  ///< [length]
};

/// Two nodes that are joined, or all nodes that lie at one place.
struct JointParameters {
  std::string fiber[2];                         ///< names of the two fibers; of groups too when touching
  bool at_end[2] = {true, false};               ///< end or start of each fiber
  std::optional<double> arc_length[2];          ///< place on each fiber instead of an end [length]
  std::optional<double> touching;               ///< join all nodes nearer to each other than this [length]
  JointType type = JointType::position;
};

}  // namespace fbi::mesh
