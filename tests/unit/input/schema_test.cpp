/// The case file as a whole: values that arrive, defaults, rules across its parts.
#include "case/schema.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <numbers>

#include "base/error.hpp"

using namespace fbi;

namespace {

std::string file_text(const std::string& path) {
  std::ifstream stream(std::string(FBI_SOURCE_DIR) + "/" + path);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

cases::CaseParameters parse(const std::string& text) { return cases::parse_case(text, "case.json"); }

std::string errors(const std::string& text) {
  try {
    parse(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "none";
}

const std::string faces = R"("xmin": {"type": "no_slip"}, "xmax": {"type": "no_slip"}, "ymin": {"type": "no_slip"},
  "ymax": {"type": "no_slip"}, "zmin": {"type": "no_slip"}, "zmax": {"type": "no_slip"})";
const std::string fluid_text =
    R"("fluid": {"density": 1, "viscosity": 1}, "channel": {"size": [1, 1, 1], "elements": [2, 2, 2],
  "boundaries": {)" +
    faces + "}}";
const std::string beam_text =
    R"({"name": "a", "curve": {"type": "line", "from": [0.5, 0, 0.5], "to": [0.5, 0.5, 0.5]}, "elements": 2,
  "section": {"radius": 0.01}, "material": {"young": 1, "density": 1}, "clamped": "start"})";
const std::string fixed_fiber =
    R"({"name": "a", "curve": {"type": "line", "from": [0.5, 0, 0.5], "to": [0.5, 0.5, 0.5]},
  "elements": 2, "formulation": "fixed"})";

}  // namespace

TEST(Schema, ReadsTheCanopy) {
  const cases::CaseParameters p = parse(file_text("tests/input/valid/canopy.json"));
  EXPECT_EQ(p.title, "Submerged vegetation canopy");
  ASSERT_TRUE(p.fluid && p.channel);
  EXPECT_EQ(p.fluid->viscosity, 0.004);
  EXPECT_EQ(p.channel->box.elements, (std::array<Index, 3>{480, 32, 32}));
  EXPECT_EQ(p.channel->box.size, Vec3(13, 1, 1));
  ASSERT_EQ(p.channel->boundaries.size(), 6u);
  const fluid::BoundaryCondition& inlet = p.channel->boundaries.at("xmin");
  EXPECT_EQ(inlet.type, fluid::BoundaryType::inflow);
  EXPECT_DOUBLE_EQ((*inlet.velocity[0])(0, 0.5, 0, 0), 75.0);
  EXPECT_TRUE(p.channel->boundaries.at("xmax").backflow);
  EXPECT_EQ(p.channel->boundaries.at("xmax").backflow_beta, 0.5);
  EXPECT_EQ(p.channel->boundaries.at("zmax").type, fluid::BoundaryType::slip);
  ASSERT_EQ(p.fibers.size(), 1u);
  const cases::FiberGroup& group = p.fibers[0];
  EXPECT_EQ(group.physics.name, "patch");
  EXPECT_DOUBLE_EQ(group.curve.from[0], 1 + 10.0 / 226);
  EXPECT_EQ(group.array.counts, (std::array<Index, 3>{225, 1, 15}));
  EXPECT_DOUBLE_EQ(group.array.spacing[2], 1.0 / 17);
  EXPECT_EQ(group.elements, 3);
  EXPECT_DOUBLE_EQ(group.physics.section.area, std::numbers::pi * 1e-4);
  EXPECT_DOUBLE_EQ(group.physics.section.inertia, std::numbers::pi / 4 * 1e-8);
  EXPECT_EQ(group.physics.start, beam::EndCondition::clamped);
  EXPECT_EQ(group.physics.end, beam::EndCondition::free);
  EXPECT_EQ(p.scheme.scheme, fsi::Scheme::monolithic);
  EXPECT_EQ(p.coupling.penalty, 100.0);
  EXPECT_EQ(p.time.step, 2e-4);
  EXPECT_EQ(p.time.end, 0.24);
  EXPECT_EQ(p.output.every, 50);
  ASSERT_EQ(p.output.probes.size(), 2u);
  EXPECT_EQ(p.output.probes[0].fiber, "patch/112/7");
  EXPECT_EQ(p.output.probes[1].point, Vec3(6.5, 0.5, 0.5));
}

TEST(Schema, FluidAlone) {
  const cases::CaseParameters p =
      parse("{" + fluid_text + R"(, "time": {"step": 0.1, "end": 1, "fluid": {"theta": 0.5}}})");
  EXPECT_TRUE(p.fibers.empty());
  EXPECT_EQ(p.fluid_time.theta, 0.5);
}

TEST(Schema, SteadyFlowNeedsNoTimes) {
  const std::string steady = R"(, "time": {"fluid": {"scheme": "steady"}})";
  EXPECT_EQ(parse("{" + fluid_text + steady + "}").fluid_time.scheme, fluid::TimeScheme::steady);
  EXPECT_EQ(parse("{" + fluid_text + steady + R"(, "fibers": [)" + fixed_fiber + "]}").fibers[0].physics.formulation,
            beam::Formulation::fixed);
  EXPECT_NE(errors("{" + fluid_text + steady + R"(, "fibers": [)" + beam_text + "]}")
                .find("steady flow does not go with fibers that move"),
            std::string::npos);
}

TEST(Schema, FibersAlone) {
  const cases::CaseParameters dynamic = parse(R"({"fibers": [)" + beam_text + R"(], "gravity": [0, -9.81, 0],
    "time": {"step": 0.001, "end": 1, "beam": {"rho_inf": 0.8}}})");
  EXPECT_FALSE(dynamic.fluid || dynamic.channel);
  EXPECT_EQ(dynamic.beam_time.rho_inf, 0.8);
  EXPECT_EQ(dynamic.gravity[1], -9.81);
  const std::string statics =
      R"({"fibers": [)" + beam_text + R"(], "time": {"beam": {"scheme": "static"}, "step": 0.25}})";
  EXPECT_EQ(parse(statics).time.end, 1.0);
  EXPECT_EQ(parse(statics).time.step, 0.25);
  EXPECT_EQ(parse(R"({"fibers": [)" + beam_text + R"(], "time": {"beam": {"scheme": "static"}}})").time.step, 1.0);
}

TEST(Schema, LoadsAndAitken) {
  std::string loaded = beam_text;
  loaded.insert(
      1,
      R"("loads": [{"type": "moment", "at": "end", "value": [0, 0, "2*pi*t"]}, {"type": "line", "value": [0, 1, 0]}],)");
  const cases::CaseParameters p =
      parse("{" + fluid_text + R"(, "fibers": [)" + loaded + R"(], "time": {"step": 0.1, "end": 1},
    "coupling": {"scheme": "aitken", "relaxation": 0.5, "coupling_weight": "1-alpha_f", "geometry_update": "iterated", "outside": "allow"},
    "expect": [{"quantity": "a:displacement_x", "value": 1, "tolerance": 0.1, "time": 0.5},
               {"quantity": "drag", "value": 0, "absolute_tolerance": 0.2, "reduce": "max_abs"}]})");
  ASSERT_EQ(p.fibers[0].physics.loads.size(), 2u);
  EXPECT_EQ(p.fibers[0].physics.loads[0].type, beam::LoadType::moment);
  EXPECT_DOUBLE_EQ(p.fibers[0].physics.loads[0].value[2](0, 0, 0, 1), 2 * std::numbers::pi);
  EXPECT_EQ(p.fibers[0].physics.loads[1].type, beam::LoadType::line);
  EXPECT_EQ(p.scheme.scheme, fsi::Scheme::aitken);
  EXPECT_EQ(p.scheme.relaxation, 0.5);
  EXPECT_EQ(p.scheme.coupling_weight, fsi::CouplingWeight::one_minus_alpha_f);
  EXPECT_EQ(p.coupling.outside, coupling::Outside::allow);
  ASSERT_EQ(p.expect.size(), 2u);
  EXPECT_TRUE(p.expect[0].relative && p.expect[0].time == 0.5);
  EXPECT_TRUE(!p.expect[1].relative && p.expect[1].tolerance == 0.2 && p.expect[1].reduce == "max_abs");
}

TEST(Schema, MixedBoundaries) {
  std::string mixed = fluid_text;
  const std::string old_face = R"("xmax": {"type": "no_slip"})";
  mixed.replace(mixed.find(old_face), old_face.size(),
                R"("xmax": {"type": "mixed", "velocity": [null, 0, "t"], "traction": ["-1-t", 0, 0]})");
  const cases::CaseParameters p = parse("{" + mixed + R"(, "time": {"step": 0.1, "end": 1}})");
  const fluid::BoundaryCondition& face = p.channel->boundaries.at("xmax");
  EXPECT_FALSE(face.velocity[0].has_value());
  EXPECT_TRUE(face.velocity[1]->is_zero());
  EXPECT_DOUBLE_EQ(face.traction[0](0, 0, 0, 2), -3.0);
}

TEST(Schema, NothingIsIgnoredInSilence) {
  EXPECT_EQ(errors("{}"), "case.json:1:1: nothing to compute: give \"fluid\" and \"channel\", \"fibers\", or all");
  EXPECT_EQ(errors(R"({"fibers": [)" + fixed_fiber + "]}"),
            "case.json:1:12: fibers: nothing to compute: there is no fluid and every fiber is fixed or prescribed");
  EXPECT_NE(errors(R"({"coupling": {}, "fibers": [)" + beam_text + R"(], "time": {"step": 1, "end": 1}})")
                .find("case.json:1:14: coupling: has no effect without fluid; remove it"),
            std::string::npos);
  EXPECT_NE(errors("{" + fluid_text + R"(, "gravity": [0, 0, 1], "time": {"step": 1, "end": 1}})")
                .find("gravity: has no effect"),
            std::string::npos);
}

TEST(Schema, IsAJsonSchema) {
  const nlohmann::json schema = nlohmann::json::parse(cases::case_json_schema());
  EXPECT_EQ(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
  EXPECT_EQ(schema["$defs"]["Boundaries"]["required"].size(), 6u);
  EXPECT_EQ(schema["$defs"]["Coupling"]["properties"]["coupling_weight"]["default"], "theta");
  // Every reference leads somewhere.
  const std::string text = schema.dump();
  for (std::size_t at = text.find("#/$defs/"); at != std::string::npos; at = text.find("#/$defs/", at + 1)) {
    const std::string name = text.substr(at + 8, text.find('"', at) - at - 8);
    EXPECT_TRUE(schema["$defs"].contains(name)) << name;
  }
}

TEST(Schema, ReferencePageIsUpToDate) {  // write it anew by: fbi-gen --reference > docs/input-reference.md
  EXPECT_EQ(file_text("docs/input-reference.md"), cases::case_reference());
}

TEST(Schema, EveryPrefixAndManyMutationsEndWell) {  // accepted or refused with a message, never anything else
  const std::string text = file_text("tests/input/valid/canopy.json");
  const std::size_t last_brace = text.rfind('}');
  for (std::size_t length = 0; length <= last_brace; ++length)
    EXPECT_NE(errors(text.substr(0, length)), "none") << length;
  EXPECT_EQ(errors(text.substr(0, last_brace + 1)), "none");
  unsigned state = 7;
  const auto random = [&](std::size_t n) {
    return static_cast<std::size_t>((state = state * 1664525u + 1013904223u) >> 8) % n;
  };
  const std::string letters = "{}[]\",:0123456789.-+eE*/()xyzt \n\\";
  std::size_t refused = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string mutant = text;
    for (int k = 0; k < 3; ++k) mutant[random(mutant.size())] = letters[random(letters.size())];
    refused += errors(mutant) != "none";
  }
  EXPECT_GT(refused, 1000u);
}
