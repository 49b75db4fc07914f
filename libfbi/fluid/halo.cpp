#include "fluid/halo.hpp"

#include <algorithm>
#include <cstring>
#include <map>

#include "mesh/exchange.hpp"

namespace fbi::fluid {

namespace {
constexpr int tag = 30;
}

Halo::Halo(const mesh::HexMesh& mesh) : comm_(mesh.comm) {
  const std::vector<GlobalIndex> begins = mesh::chunk_begins(comm_, mesh.first_node, mesh.independent_nodes);
  std::vector<GlobalIndex> wanted(mesh.node_number.begin() + mesh.owned_nodes, mesh.node_number.end());
  std::vector<int> owner(wanted.size());
  std::map<int, Neighbor> neighbors;
  const auto neighbor = [&](int rank) -> Neighbor& {
    return neighbors.try_emplace(rank, Neighbor{rank, {}, {}}).first->second;
  };
  for (std::size_t k = 0; k < wanted.size(); ++k) {
    // Ranks without nodes share their begin with the next one: the last rank that begins here is the owner.
    owner[k] = static_cast<int>(std::upper_bound(begins.begin(), begins.end() - 1, wanted[k]) - begins.begin()) - 1;
    neighbor(owner[k]).ghosts.push_back(mesh.owned_nodes + static_cast<Index>(k));
  }
  const mesh::RankLists<GlobalIndex> asked = mesh::exchange(comm_, mesh::make_lists(comm_.size(), wanted, owner));
  for (int rank = 0; rank < comm_.size(); ++rank)
    for (int k = asked.first[rank]; k < asked.first[rank + 1]; ++k)
      neighbor(rank).owned.push_back(static_cast<Index>(asked.data[k] - mesh.first_node));
  for (auto& [rank, lists] : neighbors) neighbors_.push_back(std::move(lists));
  sent_.resize(neighbors_.size());
  arrived_.resize(neighbors_.size());
}

void Halo::exchange(const float* values, std::vector<Index> Neighbor::*leaving,
                    std::vector<Index> Neighbor::*arriving) const {
  requests_.clear();
  for (std::size_t i = 0; i < neighbors_.size(); ++i) {
    const Neighbor& neighbor = neighbors_[i];
    arrived_[i].resize(4 * (neighbor.*arriving).size());
    if (neighbor.rank != comm_.rank() && !arrived_[i].empty())
      MPI_Irecv(arrived_[i].data(), static_cast<int>(arrived_[i].size()), MPI_FLOAT, neighbor.rank, tag, comm_.get(),
                &requests_.emplace_back());
  }
  for (std::size_t i = 0; i < neighbors_.size(); ++i) {
    const Neighbor& neighbor = neighbors_[i];
    const bool here = neighbor.rank == comm_.rank();
    std::vector<float>& out = here ? arrived_[i] : sent_[i];
    const std::vector<Index>& nodes = neighbor.*leaving;
    out.resize(4 * nodes.size());
    for (std::size_t k = 0; k < nodes.size(); ++k)
      std::memcpy(&out[4 * k], values + 4 * static_cast<std::size_t>(nodes[k]), 4 * sizeof(float));
    if (!here && !out.empty())
      MPI_Isend(out.data(), static_cast<int>(out.size()), MPI_FLOAT, neighbor.rank, tag, comm_.get(),
                &requests_.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
}

void Halo::update_ghosts(float* values) const {
  exchange(values, &Neighbor::owned, &Neighbor::ghosts);
  for (std::size_t i = 0; i < neighbors_.size(); ++i)
    for (std::size_t k = 0; k < neighbors_[i].ghosts.size(); ++k)
      std::memcpy(values + 4 * static_cast<std::size_t>(neighbors_[i].ghosts[k]), &arrived_[i][4 * k],
                  4 * sizeof(float));
}

void Halo::add_ghosts(float* values) const {
  exchange(values, &Neighbor::ghosts, &Neighbor::owned);
  for (std::size_t i = 0; i < neighbors_.size(); ++i)
    for (std::size_t k = 0; k < neighbors_[i].owned.size(); ++k)
      for (int c = 0; c < 4; ++c)
        values[4 * static_cast<std::size_t>(neighbors_[i].owned[k]) + c] += arrived_[i][4 * k + c];
}

}  // namespace fbi::fluid
