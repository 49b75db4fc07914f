// Fibers that touch or cross, on any number of ranks.
#include "search/fiber_crossings.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace fbi::search {
namespace {

void add_line(mesh::FiberMeshData& fibers, const Vec3& from, const Vec3& to, int elements) {
  if (fibers.first_node.empty()) fibers.first_node.push_back(0);
  const Vec3 tangent = (to - from).normalized();
  for (int n = 0; n <= elements; ++n) {
    const Vec3 x = from + (to - from) * n / elements;
    fibers.position.insert(fibers.position.end(), x.data(), x.data() + 3);
    fibers.tangent.insert(fibers.tangent.end(), tangent.data(), tangent.data() + 3);
  }
  for (int e = 0; e < elements; ++e) fibers.element_length.push_back((to - from).norm() / elements);
  fibers.first_node.push_back(fibers.first_node.back() + elements + 1);
  fibers.name.push_back("fiber/" + std::to_string(fibers.name.size()));
  fibers.group.push_back(0);
}

mesh::FiberMesh spread(const Comm& comm, const mesh::FiberMeshData& data) {
  GlobalIndex first_fiber = 0, first_node = 0;
  const mesh::FiberMeshData chunk = mesh::chunk_of(comm, data, first_fiber, first_node);
  return mesh::distribute(comm, chunk, first_fiber, first_node, nullptr);
}

FiberPairs pairs_of(const mesh::FiberMesh& fibers, double radius) {
  FiberCrossings search(fibers, std::vector<double>(static_cast<std::size_t>(fibers.fibers()), radius));
  return search.find(fibers.reference_dofs());
}

TEST(SegmentDistance, CrossingSkewParallelAndPoints) {
  const Vec3 o(0, 0, 0), x(1, 0, 0), y(0, 1, 0), z(0, 0, 1);
  EXPECT_EQ(segment_distance(o, x, Vec3(0.5, -0.5, 0.25), y), 0.25);
  EXPECT_EQ(segment_distance(o, x, Vec3(2, -0.5, 0), y), 1.0);
  EXPECT_EQ(segment_distance(o, x, Vec3(0.25, 0.5, 0), x), 0.5);
  EXPECT_EQ(segment_distance(o, x, Vec3(3, 0, 0), x), 2.0);
  EXPECT_EQ(segment_distance(o, x, Vec3(3, 0, 0), -x), 1.0);
  EXPECT_EQ(segment_distance(o, Vec3::Zero(), z, Vec3::Zero()), 1.0);
  EXPECT_EQ(segment_distance(o, Vec3::Zero(), Vec3(0.5, 0, 2), x), std::sqrt(4.25));
  // against a search in both parameters
  std::mt19937 random(3);
  std::uniform_real_distribution<double> number(-1, 1);
  for (int trial = 0; trial < 200; ++trial) {
    Vec3 p[4];
    for (Vec3& v : p) v = Vec3(number(random), number(random), number(random));
    double least = 1e300;
    for (int i = 0; i <= 200; ++i)
      for (int j = 0; j <= 200; ++j)
        least = std::min(least, (p[0] + i / 200.0 * p[1] - p[2] - j / 200.0 * p[3]).norm());
    const double found = segment_distance(p[0], p[1], p[2], p[3]);
    EXPECT_LE(found, least + 1e-14);
    EXPECT_GE(found, least - 0.02);
  }
}

TEST(FiberCrossings, CountsPairsOnceAndNamesTheFirst) {
  const Comm world;
  mesh::FiberMeshData data;
  add_line(data, Vec3(0, 0, 0), Vec3(1, 0, 0), 3);
  add_line(data, Vec3(0.4, -0.5, 0.015), Vec3(0.4, 0.5, 0.015), 2);  // 0.015 above the first
  add_line(data, Vec3(0.6, -0.5, 0.03), Vec3(0.6, 0.5, 0.03), 4);    // 0.03 above it
  add_line(data, Vec3(0.3, 0.3, 0.02), Vec3(0.9, 0.3, 0.02), 5);     // near both others
  add_line(data, Vec3(0.3, 0.3, 3.0), Vec3(0.9, 0.3, 3.0), 5);       // far away
  const mesh::FiberMesh fibers = spread(world, data);
  const FiberPairs pairs = pairs_of(fibers, 0.01);
  EXPECT_EQ(pairs.count, 3);  // 0-1, 1-3, 2-3
  EXPECT_EQ(pairs.first[0], 0);
  EXPECT_EQ(pairs.first[1], 1);
  EXPECT_EQ(pairs_of(fibers, 0.016).count, 4);
  EXPECT_EQ(pairs_of(fibers, 0.0049).count, 1);  // 1 and 3 are 0.005, 2 and 3 0.01 apart
  EXPECT_EQ(pairs_of(fibers, 0.0024).count, 0);
  EXPECT_EQ(pairs_of(fibers, 0.002).first[0], -1);
}

TEST(FiberCrossings, CenterLinesThatMeetWithoutRadii) {
  const Comm world;
  mesh::FiberMeshData data;
  add_line(data, Vec3(0, 0, 0), Vec3(1, 0, 0), 3);
  add_line(data, Vec3(0.4, -0.5, 0), Vec3(0.4, 0.5, 0), 2);
  add_line(data, Vec3(0.4, -0.5, 1e-3), Vec3(0.4, 0.5, 1e-3), 2);
  EXPECT_EQ(pairs_of(spread(world, data), 0.0).count, 1);
}

// A bent fiber comes near where its chord does not.
TEST(FiberCrossings, FollowsTheCurve) {
  const Comm world;
  mesh::FiberMeshData data;
  add_line(data, Vec3(0, 0, 0), Vec3(1, 0, 0), 1);
  add_line(data, Vec3(0.5, 0.24, -1), Vec3(0.5, 0.24, 1), 1);
  const mesh::FiberMesh fibers = spread(world, data);
  FiberCrossings search(fibers, std::vector<double>(static_cast<std::size_t>(fibers.fibers()), 0.01));
  std::vector<double> dofs = fibers.reference_dofs();
  EXPECT_EQ(search.find(dofs).count, 0);
  for (Index f = 0; f < fibers.fibers(); ++f)
    if (fibers.fiber_id[f] == 0) {  // y = x (1 - x): 0.25 in the middle
      const std::size_t node = static_cast<std::size_t>(fibers.first_node[f]);
      dofs[6 * node + 4] = 1.0;
      dofs[6 * node + 10] = -1.0;
    }
  EXPECT_EQ(search.find(dofs).count, 1);
}

TEST(FiberCrossings, JoinedFibersAreMeantToMeet) {
  const Comm world;
  mesh::FiberMeshData data;
  add_line(data, Vec3(0, 0, 0), Vec3(1, 0, 0), 1);
  add_line(data, Vec3(1, 0, 0), Vec3(1, 1, 0), 1);
  add_line(data, Vec3(1, 0, 0), Vec3(1, 0, 1), 1);
  mesh::FiberMesh fibers = spread(Comm(MPI_COMM_SELF), data);
  EXPECT_EQ(pairs_of(fibers, 0.01).count, 3);
  fibers.joints.push_back({2, 1, mesh::JointType::position});
  EXPECT_EQ(pairs_of(fibers, 0.01).count, 2);
}

// Random fibers on all ranks: every pair, by distances of all pairs of segments.
TEST(FiberCrossings, AllPairsOfRandomFibers) {
  const Comm world;
  mesh::FiberMeshData data;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> place(0, 1);
  std::vector<Vec3> ends;
  const int count = 400;
  const double radius = 0.004;
  for (int f = 0; f < count; ++f) {
    const Vec3 from(place(random), place(random), place(random)), to(place(random), place(random), place(random));
    ends.push_back(from);
    ends.push_back(to);
    add_line(data, from, to, 1 + f % 4);
  }
  GlobalIndex expected = 0, first = -1;
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) {
      const double distance =
          segment_distance(ends[2 * a], ends[2 * a + 1] - ends[2 * a], ends[2 * b], ends[2 * b + 1] - ends[2 * b]);
      if (!(distance < 2 * radius)) continue;
      if (first < 0) first = a;
      ++expected;
    }
  const FiberPairs pairs = pairs_of(spread(world, data), radius);
  EXPECT_GT(expected, 100);
  EXPECT_EQ(pairs.count, expected);
  EXPECT_EQ(pairs.first[0], first);
}

TEST(FiberCrossings, NoFibers) {
  const Comm world;
  mesh::FiberMeshData data;
  data.first_node.push_back(0);
  EXPECT_EQ(pairs_of(spread(world, data), 0.01).count, 0);
}

}  // namespace
}  // namespace fbi::search
