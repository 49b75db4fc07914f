/// Field output of a run: one file a step, a mesh file, an index and an XDMF description.
///
///     NAME.run/mesh.h5      /fluid/nodes, cells, box/x, y, z (of a box); /fibers/names, group, first_node,
///     first_point, reference_dofs, polylines NAME.run/000050.h5    /fluid/FIELD (nodes or (nodes,components));
///     /fibers/position, velocity, force (points,3), dofs (nodes,6) NAME.run.h5           /input, /provenance,
///     /steps/number, time, /outputs/000050 (link), /mesh (link), /history NAME.run.xdmf
///
/// Everything is in file order (node and fiber numbers of the case file), whatever the number of ranks.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "io/file_order.hpp"
#include "io/run_paths.hpp"
#include "io/xdmf.hpp"
#include "mesh/fiber_mesh.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::io {

/// Where a result comes from.
struct Provenance {
  std::string json;       ///< text of the input
  std::string json_name;  ///< its file name
  std::string version;    ///< of the program
  std::string command;    ///< command line
  int ranks = 1;
};

/// A field on the nodes of the fluid mesh that this rank writes (owned ones and images): component c of node n is
/// data[n * stride + offset + c].
struct NodeField {
  std::string name;
  int components = 1;  ///< 1, 3, or 6: a symmetric tensor xx, xy, xz, yy, yz, zz
  int stride = 1;
  int offset = 0;
  const double* data = nullptr;
  double averaged_over = 0.0;  ///< duration of which this is the mean [time]; 0 = of the moment
};

/// The fibers of this rank; `velocity` and `force` may be null and are then left out of every step.
struct FiberState {
  const std::vector<double>* dofs = nullptr;      ///< positions and tangents, shape=(nodes,6) [length]
  const std::vector<double>* velocity = nullptr;  ///< their rates, shape=(nodes,6)
  const std::vector<double>* force =
      nullptr;  ///< line force on the fiber at its nodes, linear between, shape=(nodes,3) [force/length]
};

/// Points on the Hermite center lines: `per_element` intervals an element, fiber after fiber, shape=(points,3). `dofs`
/// are positions and tangents or their rates, shape=(nodes,6).
std::vector<double> sample_center_lines(const mesh::FiberMesh& fibers, const std::vector<double>& dofs,
                                        int per_element);

/// Writes the results of one run. `fluid` and `fibers` may be null and outlive the writer. All members are collective
/// and throw Error(file) on all ranks or none.
class ResultWriter {
 public:
  /// A new run removes output and checkpoints of an older one of the same name; with `restart_step` outputs up to that
  /// step are kept. `fiber_points`: intervals per element on the written center lines.
  ResultWriter(const Comm& comm, const RunPaths& paths, const mesh::HexMesh* fluid, const mesh::FiberMesh* fibers,
               Provenance provenance, int fiber_points, std::optional<GlobalIndex> restart_step = std::nullopt);

  /// Writes the fields of a step, then index and XDMF.
  void write_step(GlobalIndex step, double time, const std::vector<NodeField>& fluid, const FiberState& fibers);

  /// Marks the run as complete and copies the history (NAME.run.csv, when there) into the index.
  void finish();

 private:
  void write_mesh_file() const;
  void write_index(bool complete) const;                                // rank 0
  void take_over_older_files(std::optional<GlobalIndex> restart_step);  // rank 0
  template <class Action>
  void on_rank_zero(Action action) const;

  Comm comm_;
  RunPaths paths_;
  const mesh::HexMesh* fluid_;
  const mesh::FiberMesh* fibers_;
  Provenance provenance_;
  int fiber_points_;
  GlobalIndex points_ = 0;  // of all ranks
  std::optional<FileOrder> nodes_, fiber_nodes_, fiber_point_order_;
  std::vector<XdmfStep> steps_;
  XdmfContent xdmf_;
  std::string started_;
};

}  // namespace fbi::io
