/// Fibers and their distribution over ranks.
#include "mesh/fiber_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "base/error.hpp"

namespace fbi::mesh {
namespace {

// `count` upright fibers at x = 0.5, 1.5, ..., with 1, 2, 3, 1, 2, 3, ... elements of length 0.1.
FiberMeshData upright(Index count) {
  FiberMeshData fibers;
  fibers.first_node = {0};
  for (Index f = 0; f < count; ++f) {
    const Index elements = 1 + f % 3;
    fibers.name.push_back(count == 1 ? "one" : "row/" + std::to_string(f));
    fibers.group.push_back(f % 2);
    for (Index n = 0; n <= elements; ++n) {
      fibers.position.insert(fibers.position.end(), {f + 0.5, 0.1 * n, 0.25});
      fibers.tangent.insert(fibers.tangent.end(), {0.0, 1.0, 0.0});
    }
    for (Index e = 0; e < elements; ++e) fibers.element_length.push_back(0.1 + 0.001 * f);
    fibers.first_node.push_back(static_cast<GlobalIndex>(fibers.position.size()) / 3);
  }
  return fibers;
}

FiberMesh distribute_whole(const Comm& comm, const FiberMeshData& whole, const HexMesh* fluid) {
  GlobalIndex fiber = 0, node = 0;
  const FiberMeshData chunk = chunk_of(comm, whole, fiber, node);
  return distribute(comm, chunk, fiber, node, fluid);
}

void check(const Comm& comm, const FiberMeshData& whole, const FiberMesh& mesh) {
  EXPECT_EQ(mesh.global_fibers, whole.fiber_count());
  EXPECT_EQ(mesh.global_nodes, static_cast<GlobalIndex>(whole.position.size()) / 3);
  EXPECT_EQ(mesh.global_elements, static_cast<GlobalIndex>(whole.element_length.size()));
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.fibers()}), mesh.global_fibers);
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.nodes()}), mesh.global_nodes);
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.elements()}), mesh.global_elements);
  EXPECT_TRUE(std::is_sorted(mesh.fiber_id.begin(), mesh.fiber_id.end()));
  const std::vector<double> dofs = mesh.reference_dofs();
  ASSERT_EQ(dofs.size(), 6 * static_cast<std::size_t>(mesh.nodes()));
  for (Index f = 0; f < mesh.fibers(); ++f) {
    const GlobalIndex id = mesh.fiber_id[f];
    EXPECT_EQ(mesh.name[f], whole.name[id]);
    EXPECT_EQ(mesh.group[f], whole.group[id]);
    EXPECT_EQ(mesh.first_node_id[f], whole.first_node[id]);
    ASSERT_EQ(mesh.first_node[f + 1] - mesh.first_node[f], whole.first_node[id + 1] - whole.first_node[id]);
    for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n)
      for (int d = 0; d < 3; ++d) {
        const GlobalIndex node = whole.first_node[id] + n - mesh.first_node[f];
        EXPECT_EQ(mesh.position[3 * n + d], whole.position[3 * node + d]);
        EXPECT_EQ(mesh.tangent[3 * n + d], whole.tangent[3 * node + d]);
        EXPECT_EQ(dofs[6 * n + d], whole.position[3 * node + d]);
        EXPECT_EQ(dofs[6 * n + 3 + d], whole.tangent[3 * node + d]);
      }
    for (Index e = mesh.first_element(f); e < mesh.first_element(f + 1); ++e)
      EXPECT_EQ(mesh.element_length[e], whole.element_length[whole.first_node[id] - id + e - mesh.first_element(f)]);
  }
}

TEST(Fibers, AloneTheySpreadEvenlyInFileOrder) {
  const Comm comm;
  const FiberMeshData whole = upright(11);
  const FiberMesh mesh = distribute_whole(comm, whole, nullptr);
  check(comm, whole, mesh);
  EXPECT_LE(std::abs(mesh.fibers() - 11.0 / comm.size()), 1.0);
}

TEST(Fibers, GoWhereTheirFluidIs) {
  const Comm comm;
  std::vector<double> x(13);
  for (int i = 0; i <= 12; ++i) x[i] = i;
  const HexMeshData box = make_box({x, {0.0, 1.0}, {0.0, 0.5}});
  const HexMesh fluid = distribute(comm, chunk_of(comm, box));
  const FiberMeshData whole = upright(12);
  const FiberMesh mesh = distribute_whole(comm, whole, &fluid);
  check(comm, whole, mesh);
  EXPECT_EQ(mesh.fibers(), fluid.local_cells());
  for (Index f = 0; f < mesh.fibers(); ++f) EXPECT_EQ(mesh.fiber_id[f], fluid.cell_id[f]);
}

TEST(Fibers, OneFiberLeavesRanksEmptyAndNoneWorksToo) {
  const Comm comm;
  check(comm, upright(1), distribute_whole(comm, upright(1), nullptr));
  check(comm, upright(0), distribute_whole(comm, upright(0), nullptr));
  const FiberMesh none = distribute_whole(comm, FiberMeshData{}, nullptr);
  EXPECT_EQ(none.global_fibers, 0);
  EXPECT_EQ(none.nodes(), 0);
}

TEST(Fibers, FiberBetweenRanksGoesToTheLowest) {
  const Comm comm;
  const HexMeshData box = make_box({std::vector<double>{0.0, 0.5, 1.0}, {0.0, 0.4}, {0.0, 0.4}});
  const HexMesh fluid = distribute(comm, chunk_of(comm, box));
  const FiberMesh mesh = distribute_whole(comm, upright(1), &fluid);  // stands at x = 0.5
  const GlobalIndex lowest_with_cells = -comm.max(GlobalIndex{fluid.local_cells() > 0 ? -comm.rank() : -comm.size()});
  EXPECT_EQ(mesh.fibers(), comm.rank() == lowest_with_cells ? 1 : 0);
}

TEST(Fibers, RefusesAFiberWithoutElement) {
  const Comm comm;
  FiberMeshData whole = upright(2);
  whole.name.push_back("dot");
  whole.group.push_back(0);
  whole.position.insert(whole.position.end(), {0.0, 0.0, 0.0});
  whole.tangent.insert(whole.tangent.end(), {0.0, 1.0, 0.0});
  whole.first_node.push_back(whole.first_node.back() + 1);
  EXPECT_THROW(distribute_whole(comm, whole, nullptr), Error);
}

}  // namespace
}  // namespace fbi::mesh
