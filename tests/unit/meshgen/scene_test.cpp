/// Scenes: names of arrays, node order, refusals.
#include "meshgen/scene.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"

using namespace fbi;

namespace {

cases::FiberGroup group(const std::string& name, const Vec3& from, const Vec3& to,
                        std::array<Index, 3> counts = {1, 1, 1}, const Vec3& spacing = Vec3::Zero()) {
  cases::FiberGroup g;
  g.curve.from = from;
  g.curve.to = to;
  g.array.counts = counts;
  g.array.spacing = spacing;
  g.elements = 2;
  g.physics.name = name;
  g.physics.section.radius = 0.01;
  return g;
}

std::string refusal(const cases::CaseParameters& parameters, ExitCode code = ExitCode::geometry) {
  std::vector<std::string> warnings;
  try {
    const meshgen::Scene scene = meshgen::make_scene(parameters, warnings);
    meshgen::check_probes(parameters.output, scene.fibers);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    return error.what();
  }
  return "none";
}

cases::CaseParameters unit_box() {
  cases::CaseParameters p;
  p.fluid.emplace();
  p.channel.emplace();
  p.channel->box.size = Vec3::Ones();
  p.channel->box.elements = {4, 4, 4};
  return p;
}

}  // namespace

TEST(Scene, NamesAndPlacesOfArrays) {
  cases::CaseParameters p;
  p.fibers.push_back(group("single", {9, 0, 0}, {9, 1, 0}));
  p.fibers.push_back(group("patch", {0, 0, 0}, {0, 1, 0}, {3, 1, 2}, {0.5, 7, 0.25}));
  p.fibers.push_back(group("row", {0, 0, 5}, {0, 1, 5}, {1, 2, 1}, {0, 3, 0}));
  std::vector<std::string> warnings;
  const mesh::FiberMeshData fibers = meshgen::make_scene(p, warnings).fibers;
  EXPECT_TRUE(warnings.empty());
  EXPECT_EQ(fibers.name, (std::vector<std::string>{"single", "patch/0/0", "patch/0/1", "patch/1/0", "patch/1/1",
                                                   "patch/2/0", "patch/2/1", "row/0", "row/1"}));
  EXPECT_EQ(fibers.group, (std::vector<Index>{0, 1, 1, 1, 1, 1, 1, 2, 2}));
  EXPECT_EQ(fibers.first_node.back(), 27);
  EXPECT_EQ(fibers.element_length.size(), 18u);
  const double* patch_1_1 = &fibers.position[3 * fibers.first_node[4]];
  EXPECT_EQ(Vec3(patch_1_1[0], patch_1_1[1], patch_1_1[2]), Vec3(0.5, 0, 0.25));
  EXPECT_EQ(Vec3(patch_1_1[6], patch_1_1[7], patch_1_1[8]), Vec3(0.5, 1, 0.25));
  EXPECT_DOUBLE_EQ(fibers.element_length[0], 0.5);
}

TEST(Scene, RefusesWhatDoesNotFit) {
  cases::CaseParameters p = unit_box();
  p.fibers.push_back(group("in", {0.5, 0, 0.5}, {0.5, 1, 0.5}));
  EXPECT_EQ(refusal(p), "none");
  p.fibers.push_back(group("half", {0.5, 0.5, 0.5}, {0.5, 1.5, 0.5}));
  p.fibers.push_back(group("out", {2, 0, 0.5}, {2, 0.5, 0.5}));
  p.fibers.push_back(group("point", {0.2, 0.2, 0.2}, {0.2, 0.2, 0.2}));
  EXPECT_EQ(
      refusal(p),
      "fiber \"point\" has zero length: its curve begins and ends at the same point; move \"to\" away from \"from\"\n"
      "fiber \"half\" reaches out of the channel: 0.5 beyond ymax, 50 % of its length; move it inside, or set "
      "\"coupling\": { "
      "\"outside\": \"allow\" }\n"
      "fiber \"out\" lies outside the channel: 1 beyond xmax; move it inside, or set \"coupling\": { \"outside\": "
      "\"allow\" }");
  p.fibers.pop_back();
  p.coupling.outside = coupling::Outside::allow;
  std::vector<std::string> warnings;
  EXPECT_EQ(meshgen::make_scene(p, warnings).fibers.fiber_count(), 3);
  ASSERT_EQ(warnings.size(), 4u);  // the count, each of both, and the crossing of "in" and "half"
  EXPECT_EQ(warnings[0], "2 of 3 fibers reach out of the channel");
  EXPECT_EQ(warnings[3],
            "1 pair of fibers touches or crosses (for example \"in\" and \"half\"); there is no contact: they pass "
            "through each other");
}

TEST(Scene, ListsOnlyTheFirstOfMany) {
  cases::CaseParameters p = unit_box();
  p.fibers.push_back(group("wood", {2, 0, 0.5}, {2, 0.5, 0.5}, {100, 1, 1}, {0.1, 0, 0}));
  const std::string text = refusal(p);
  EXPECT_NE(text.find("... and 90 more fibers outside the channel"), std::string::npos);
}

TEST(Scene, RefusesCellsWithoutThickness) {
  cases::CaseParameters p = unit_box();
  p.channel->box.elements = {200, 4, 4};
  p.channel->box.grading[0] = {mesh::Grading::geometric, 2.0};
  EXPECT_EQ(refusal(p), "the channel has cells of no thickness along x; use fewer elements or a ratio nearer to 1");
}

TEST(Scene, ChecksProbes) {
  cases::CaseParameters p;
  p.fibers.push_back(group("patch", {0, 0, 0}, {0, 1, 0}, {3, 1, 2}, {0.5, 0, 0.25}));
  p.output.probes.resize(3);
  p.output.probes[0].fiber = "patch/2/1";
  p.output.probes[1].fiber = "patsh/1/1";
  p.output.probes[2].fiber = "reed";
  EXPECT_EQ(refusal(p, ExitCode::usage),
            "output.probes[1].fiber: there is no fiber \"patsh/1/1\"; did you mean \"patch/1/1\"?\n"
            "output.probes[2].fiber: there is no fiber \"reed\"; the fibers are \"patch/0/0\" to \"patch/2/1\"");
}
