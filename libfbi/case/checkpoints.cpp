#include "case/checkpoints.hpp"

#include "base/counters.hpp"
#include "base/log.hpp"
#include "base/timer.hpp"
#include "input/canonical.hpp"
#include "io/case_file.hpp"
#include "io/checkpoint.hpp"

namespace fbi::cases {
namespace {

/// Every distributed array of the state. Fluid vectors are copied into `storage`, fiber arrays are used in place.
struct StateList {
  std::vector<std::pair<std::string, Vec>> vectors;
  std::vector<std::vector<double>> storage;
  std::vector<io::StateArray> fluid, fibers;
};

/// @param averages  the running means belong to it
StateList list_state(Setup& setup, bool averages) {
  StateList list;
  if (setup.fluid != nullptr) {
    list.vectors = setup.fluid->state();
    list.storage.resize(list.vectors.size());
    for (std::size_t k = 0; k < list.vectors.size(); ++k) {
      list.storage[k].resize(4 * static_cast<std::size_t>(setup.fluid_mesh->owned_nodes));
      list.fluid.push_back({list.vectors[k].first, 4, &list.storage[k]});
    }
    if (averages) list.fluid.push_back(setup.averages->state());
  }
  if (setup.beams != nullptr) {
    for (auto& [name, values] : setup.system->fiber_state()) list.fibers.push_back({name, 6, values});
  }
  if (setup.acceleration != nullptr)
    for (auto& [name, values] : setup.acceleration->state()) list.fibers.push_back({name, 6, values});
  return list;
}

/// Every number of the state, the same on all ranks.
std::vector<std::pair<std::string, double*>> list_numbers(Setup& setup) {
  std::vector<std::pair<std::string, double*>> list = setup.system->scalars();
  for (const auto& number : setup.step_control.scalars()) list.push_back(number);
  if (setup.fluid != nullptr)
    for (const auto& number : setup.fluid->scalars()) list.push_back(number);
  return list;
}

/// Fingerprint of what a restart must share with the run it goes on from: the input without comments, title, output,
/// expected values, end time and what is done where a step does not converge.
std::string fingerprint_of_physics(const std::string& json) {
  return io::fingerprint(input::canonical_text(json, {"/title", "/output", "/expect", "/time/end", "/time/halvings"}));
}

}  // namespace

void save_checkpoint(Setup& setup, const io::RunPaths& paths, const std::string& json, GlobalIndex step, double time) {
  Timed timed("checkpoint");
  count("checkpoints");
  StateList list = list_state(setup, setup.averages != nullptr);
  for (std::size_t k = 0; k < list.vectors.size(); ++k) {
    const double* values = nullptr;
    FBI_PETSC(VecGetArrayRead(list.vectors[k].second, &values));
    std::copy_n(values, list.storage[k].size(), list.storage[k].begin());
    FBI_PETSC(VecRestoreArrayRead(list.vectors[k].second, &values));
  }
  io::CheckpointHeader header;
  header.step = step;
  header.time = time;
  header.case_fingerprint = fingerprint_of_physics(json);
  for (const auto& [name, value] : list_numbers(setup)) header.numbers[name] = *value;
  if (setup.averages != nullptr) setup.averages->save(header.numbers);
  if (setup.acceleration != nullptr) {
    const std::vector<double> history = setup.acceleration->history();
    if (!history.empty()) header.vectors["acceleration"] = history;
  }
  io::write_checkpoint(setup.fiber_mesh->comm, paths, header, setup.fluid_mesh.get(), list.fluid,
                       setup.fiber_mesh.get(), list.fibers);
  setup.system->drop_caches();
}

GlobalIndex load_checkpoint(Setup& setup, const io::RunPaths& paths, const std::string& json,
                            const std::string& which) {
  Timed timed("restart");
  const Comm& comm = setup.fiber_mesh->comm;
  const GlobalIndex step = io::find_checkpoint(comm, paths, which);
  bool averages = false;
  if (setup.acceleration != nullptr || setup.averages != nullptr) {  // which arrays there are is part of the state
    const io::CheckpointHeader header =
        io::read_checkpoint(comm, paths, step, fingerprint_of_physics(json), nullptr, {}, setup.fiber_mesh.get(), {});
    averages = setup.averages != nullptr && setup.averages->restore(header.numbers);
    if (setup.averages != nullptr && !averages)
      log::info("the checkpoint holds no running means: they begin anew at step %lld", static_cast<long long>(step));
    const auto history = header.vectors.find("acceleration");
    if (setup.acceleration != nullptr && history != header.vectors.end())
      setup.acceleration->set_history(history->second);
  }
  StateList list = list_state(setup, averages);
  const io::CheckpointHeader header =
      io::read_checkpoint(comm, paths, step, fingerprint_of_physics(json), setup.fluid_mesh.get(), list.fluid,
                          setup.fiber_mesh.get(), list.fibers);
  for (std::size_t k = 0; k < list.vectors.size(); ++k) {
    double* values = nullptr;
    FBI_PETSC(VecGetArray(list.vectors[k].second, &values));
    std::copy(list.storage[k].begin(), list.storage[k].end(), values);
    FBI_PETSC(VecRestoreArray(list.vectors[k].second, &values));
  }
  for (const auto& [name, value] : list_numbers(setup)) {
    const auto found = header.numbers.find(name);
    if (found != header.numbers.end()) *value = found->second;
  }
  if (setup.fluid != nullptr) setup.fluid->state_restored();
  setup.system->drop_caches();
  return step;
}

}  // namespace fbi::cases
