/// A case from its JSON text to fields in memory, stepped one step at a time: the fixture of the coupled tests.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <functional>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/log.hpp"
#include "case/setup.hpp"
#include "fluid/ghosted.hpp"
#include "fsi/time_loop.hpp"
#include "linalg/graph_partition.hpp"
#include "mesh/fiber_mesh.hpp"
#include "meshgen/scene.hpp"

namespace fbi::test {

using Json = nlohmann::json;

inline Json parse_json(const std::string& text) { return Json::parse(text, nullptr, true, true); }

/// A case of the repository as a JSON value, "single-beam" for cases/single-beam/single-beam.json.
inline Json read_case(const std::string& name) {
  std::ifstream stream(std::string(FBI_SOURCE_DIR) + "/cases/" + name + "/" + name + ".json");
  return parse_json(std::string(std::istreambuf_iterator<char>(stream), {}));
}

/// The single fiber in the oscillating channel, merged with `changes` (JSON merge patch; objects only).
inline Json single_beam(const std::string& changes = "{}") {
  Json json = read_case("single-beam");
  json.merge_patch(parse_json(changes));
  return json;
}

/// The same on a mesh of 24 x 12 x 2 cells with 4 elements: for what does not depend on resolution.
inline Json small_beam(const std::string& changes = "{}") {
  Json json = single_beam();
  json["channel"]["elements"] = {24, 12, 2};
  json["fibers"][0]["elements"] = 4;
  json.merge_patch(parse_json(changes));
  return json;
}

/// Inflow 4 y (1-y) speed sin(pi t/half_period) along x: it reverses after half_period.
inline void set_inflow(Json& json, double speed, double half_period) {
  json["channel"]["boundaries"]["xmin"]["velocity"] = {
      log::format("4*y*(1-y)*%.17g*sin(pi*t/%.17g)", speed, half_period), "0", "0"};
}

/// Tolerances at which the answer of a step is that of its equations to about ten digits.
inline void tighten(Json& json, double newton = 1e-11, double krylov = 1e-8) {
  json["solver"]["newton_tolerance"] = newton;
  json["solver"]["newton_absolute_tolerance"] = 1e-15;
  json["solver"]["newton_iterations"] = 30;
  json["solver"]["krylov_tolerance"] = krylov;
  json["solver"]["krylov_iterations"] = 400;
  json["time"]["beam"]["tolerance"] = 1e-14;
  if (json["coupling"].value("scheme", "monolithic") != "monolithic") {
    json["coupling"]["tolerance"] = 10 * newton;  // the fluid must be more exact than what is asked of its forces
    json["coupling"]["absolute_tolerance"] = 0.0;
  }
}

/// Prints a measured number and keeps it as a property of the test.
inline void report(const std::string& name, double value) {
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const std::string text = log::format("%.6g", value);
  if (rank == 0) std::printf("[ measured ] %s = %s\n", name.c_str(), text.c_str());
  std::string key = name;
  for (char& c : key)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  ::testing::Test::RecordProperty(key, text);
}

/// Largest |a - b| relative to the largest |b|.
inline double relative_difference(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double difference = 0.0, scale = 0.0;
  for (std::size_t k = 0; k < std::min(a.size(), b.size()); ++k) {
    difference = std::max(difference, std::abs(a[k] - b[k]));
    scale = std::max(scale, std::abs(b[k]));
  }
  return scale > 0.0 ? difference / scale : difference;
}

/// Solution of a case on all ranks, by file numbers: what runs on different ranks are compared by.
struct Snapshot {
  std::vector<double> velocity;      ///< shape=(fluid nodes,3)
  std::vector<double> pressure;      ///< shape=(fluid nodes)
  std::vector<double> displacement;  ///< of position and tangent, shape=(fiber nodes,6)
  std::vector<double> lambda;        ///< at the nodes, shape=(fiber nodes,3)
};

/// A case at t = 0 on a communicator, and what the tests ask of it.
class CoupledCase {
 public:
  /// `change` may alter the mesh before it is distributed.
  explicit CoupledCase(const Json& json, MPI_Comm mpi = MPI_COMM_WORLD,
                       const std::function<void(mesh::HexMeshData&)>& change = {})
      : text_(json.dump(2)), comm_(mpi) {
    log::configure(comm_.rank() == 0, true);
    const cases::CaseParameters parameters = cases::parse_case(text_, "test.json");
    std::vector<std::string> warnings;
    meshgen::Scene scene = meshgen::make_scene(parameters, warnings);
    std::unique_ptr<mesh::HexMesh> fluid;
    if (change) change(scene.fluid);
    if (parameters.fluid)
      fluid = std::make_unique<mesh::HexMesh>(
          linalg::distribute(comm_, mesh::chunk_of(comm_, scene.fluid), parameters.partition()));
    GlobalIndex first_fiber = 0, first_node = 0;
    const mesh::FiberMeshData chunk = mesh::chunk_of(comm_, scene.fibers, first_fiber, first_node);
    auto fibers =
        std::make_unique<mesh::FiberMesh>(mesh::distribute(comm_, chunk, first_fiber, first_node, fluid.get()));
    setup = cases::make_setup(parameters, std::move(fluid), std::move(fibers));
    cases::initialize(setup);
  }

  /// Solves the next step without accepting it.
  fsi::StepReport solve() {
    clock_ = {step_ + 1, static_cast<double>(step_ + 1) * setup.dt, setup.dt};
    return fsi::solve_step(*setup.system, setup.acceleration.get(), clock_);
  }
  void accept() {
    setup.system->accept_step();
    ++step_;
  }
  /// Solves and accepts; a step that does not converge fails the test.
  fsi::StepReport step() {
    fsi::StepReport result = solve();
    EXPECT_TRUE(result.converged) << "step " << step_ + 1 << ": residual " << result.residual << " after "
                                  << result.newton << " Newton and " << result.coupling_iterations
                                  << " coupling iterations";
    accept();
    return result;
  }
  void run(int steps) {
    for (int k = 0; k < steps && !::testing::Test::HasFailure(); ++k) step();
  }
  /// Goes on from the accepted state of another run of the same meshes.
  void continue_from(CoupledCase& other) {
    const auto to = fluid().state(), from = other.fluid().state();
    for (std::size_t k = 0; k < to.size(); ++k) FBI_PETSC(VecCopy(from[k].second, to[k].second));
    const auto numbers = fluid().scalars(), other_numbers = other.fluid().scalars();
    for (std::size_t k = 0; k < numbers.size(); ++k) *numbers[k].second = *other_numbers[k].second;
    fluid().state_restored();
    const auto arrays = beams().state(), other_arrays = other.beams().state();
    for (std::size_t k = 0; k < arrays.size(); ++k) *arrays[k].second = *other_arrays[k].second;
    system().force_old() = other.system().force_old();
    system().force_older() = other.system().force_older();
    system().force_oldest() = other.system().force_oldest();
    system().last_motion() = other.system().last_motion();
    system().drop_caches();
    step_ = other.step_;
  }
  void set_step(GlobalIndex step) { step_ = step; }  ///< after a restart

  fsi::System& system() { return *setup.system; }
  fluid::FluidField& fluid() { return *setup.fluid; }
  beam::BeamField& beams() { return *setup.beams; }
  coupling::Coupling& coupling() { return setup.system->coupling(); }
  const mesh::FiberMesh& fibers() const { return *setup.fiber_mesh; }
  const Comm& comm() const { return comm_; }
  const std::string& text() const { return text_; }
  GlobalIndex steps_done() const { return step_; }
  double time() const { return static_cast<double>(step_) * setup.dt; }

  /// Displacement of the end of fiber number `id`. Collective.
  Vec3 tip(GlobalIndex id = 0) {
    Vec3 tip = Vec3::Zero();
    for (Index f = 0; f < fibers().fibers(); ++f) {
      if (fibers().fiber_id[f] != id) continue;
      const std::size_t node = fibers().first_node[f + 1] - 1;
      for (int i = 0; i < 3; ++i) tip[i] = beams().accepted_dofs()[6 * node + i] - fibers().position[3 * node + i];
    }
    comm_.sum(tip.data(), 3);
    return tip;
  }
  /// Sum of the position parts of a nodal array of all fibers, shape=(fiber nodes,6). Collective.
  Vec3 total(const std::vector<double>& nodal) {
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < nodal.size(); k += 6) sum += Vec3(nodal[k], nodal[k + 1], nodal[k + 2]);
    comm_.sum(sum.data(), 3);
    return sum;
  }
  /// Force of the fluid on all fibers at the accepted state. Collective.
  Vec3 drag() { return total(system().force_old()); }

  /// The whole accepted solution on every rank. Collective; for small meshes.
  Snapshot snapshot() {
    Snapshot result;
    if (setup.fluid != nullptr) {
      const mesh::HexMesh& mesh = *setup.fluid_mesh;
      result.velocity.assign(3 * static_cast<std::size_t>(mesh.global_nodes), 0.0);
      result.pressure.assign(static_cast<std::size_t>(mesh.global_nodes), 0.0);
      fluid::LocalArray u(fluid().accepted());
      for (Index n = 0; n < mesh.owned_nodes; ++n) {
        const std::size_t from = 4 * static_cast<std::size_t>(n), to = static_cast<std::size_t>(mesh.node_id[n]);
        for (int i = 0; i < 3; ++i) result.velocity[3 * to + i] = u[from + i];
        result.pressure[to] = u[from + 3];
      }
      comm_.sum(result.velocity.data(), static_cast<int>(result.velocity.size()));
      comm_.sum(result.pressure.data(), static_cast<int>(result.pressure.size()));
    }
    if (setup.beams != nullptr) {
      const std::vector<double> reference = fibers().reference_dofs();
      // Of any basis: rows of gauss_point are as many as the cuts, of a fiber in a face between cells one more or less.
      const std::vector<double> line_force = system().is_coupled() ? system().line_force() : std::vector<double>();
      result.displacement.assign(6 * static_cast<std::size_t>(fibers().global_nodes), 0.0);
      result.lambda.assign(3 * static_cast<std::size_t>(fibers().global_nodes), 0.0);
      for (Index f = 0; f < fibers().fibers(); ++f)
        for (Index n = fibers().first_node[f]; n < fibers().first_node[f + 1]; ++n) {
          const std::size_t to = static_cast<std::size_t>(fibers().first_node_id[f] + n - fibers().first_node[f]);
          const std::size_t from = n;
          for (int i = 0; i < 6; ++i)
            result.displacement[6 * to + i] = beams().accepted_dofs()[6 * from + i] - reference[6 * from + i];
          if (system().is_coupled())
            for (int i = 0; i < 3; ++i) result.lambda[3 * to + i] = line_force[3 * from + i];
        }
      comm_.sum(result.displacement.data(), static_cast<int>(result.displacement.size()));
      comm_.sum(result.lambda.data(), static_cast<int>(result.lambda.size()));
    }
    return result;
  }

  cases::Setup setup;

 private:
  std::string text_;
  Comm comm_;
  GlobalIndex step_ = 0;
  fsi::StepClock clock_;
};

}  // namespace fbi::test
