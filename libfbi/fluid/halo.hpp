/// Values of nodes that several ranks share, in single precision.
#pragma once

#include <vector>

#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// Messages between the owners of nodes and the ranks that hold them as ghosts, four numbers a node. Arrays hold all
/// local nodes (owned, then ghosts), shape=(nodes,4). Sums run in the order of ranks, never of arrival. Cost: one
/// message to every neighbor, and its values.
class Halo {
 public:
  /// Collective.
  explicit Halo(const mesh::HexMesh& mesh);

  /// Ghosts = values of their owners. Collective.
  void update_ghosts(float* values) const;
  /// Owners += values of their ghosts, which keep theirs. Collective.
  void add_ghosts(float* values) const;

 private:
  struct Neighbor {
    int rank;
    std::vector<Index> owned;   ///< nodes of this rank that the neighbor has as ghosts
    std::vector<Index> ghosts;  ///< ghosts of this rank that the neighbor owns
  };
  /// Sends one list of each neighbor, receives the other into buffers_[i].
  void exchange(const float* values, std::vector<Index> Neighbor::*leaving,
                std::vector<Index> Neighbor::*arriving) const;

  Comm comm_;
  std::vector<Neighbor> neighbors_;  ///< ascending ranks; this rank itself where periodic images are ghosts
  mutable std::vector<std::vector<float>> sent_, arrived_;
  mutable std::vector<MPI_Request> requests_;
};

}  // namespace fbi::fluid
