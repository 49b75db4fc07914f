#include "case/crossing_fibers.hpp"

#include <cmath>
#include <numbers>

#include "base/log.hpp"
#include "base/timer.hpp"

namespace fbi::cases {
namespace {

bool has_several(const Setup& setup) { return setup.beams != nullptr && setup.fiber_mesh->global_fibers > 1; }

}  // namespace

std::vector<io::HistoryColumn> CrossingFibers::columns(const Setup& setup) {
  if (!has_several(setup)) return {};
  return {{"fibers:crossing", "-"}};
}

CrossingFibers::CrossingFibers(const Setup& setup) : setup_(setup) {
  if (!has_several(setup)) return;
  const mesh::FiberMesh& fibers = *setup.fiber_mesh;
  std::vector<double> radius;
  for (const Index group : fibers.group) {
    const beam::Section& section = setup.parameters.fibers[static_cast<std::size_t>(group)].physics.section;
    radius.push_back(section.radius > 0.0 ? section.radius : std::sqrt(section.area / std::numbers::pi));
  }
  search_ = std::make_unique<search::FiberCrossings>(fibers, std::move(radius));
}

std::string CrossingFibers::name_of(GlobalIndex fiber) const {
  const mesh::FiberMesh& fibers = *setup_.fiber_mesh;
  std::string name;
  for (Index f = 0; f < fibers.fibers(); ++f)
    if (fibers.fiber_id[f] == fiber) name = fibers.name[f];
  const Comm& comm = fibers.comm;
  const int owner = static_cast<int>(comm.max(static_cast<GlobalIndex>(name.empty() ? -1 : comm.rank())));
  int size = static_cast<int>(name.size());
  MPI_Bcast(&size, 1, MPI_INT, owner, comm.get());
  name.resize(static_cast<std::size_t>(size));
  MPI_Bcast(name.data(), size, MPI_CHAR, owner, comm.get());
  return name;
}

std::vector<double> CrossingFibers::values() {
  if (search_ == nullptr) return {};
  Timed timed("crossing fibers");
  const search::FiberPairs pairs = search_->find(setup_.beams->accepted_dofs());
  if (pairs.count > 0 && !warned_) {
    warned_ = true;
    const std::string first = name_of(pairs.first[0]), second = name_of(pairs.first[1]);
    log::warning(
        "%lld %s of fibers %s, for example \"%s\" and \"%s\"; there is no contact: they pass through each "
        "other (column fibers:crossing of the history)",
        static_cast<long long>(pairs.count), pairs.count == 1 ? "pair" : "pairs",
        pairs.count == 1 ? "touches or crosses" : "touch or cross", first.c_str(), second.c_str());
  }
  return {static_cast<double>(pairs.count)};
}

}  // namespace fbi::cases
