/// Table of one entry of "joints".
#include "case/schema_tables.hpp"

namespace fbi::cases {

using namespace input;

void describe_joint(Visitor& v, mesh::JointParameters& p) {
  const std::vector<Option<bool>> ends = {{false, "start", ""}, {true, "end", ""}};
  v.optional_number(field("touching",
                          "join all nodes, of different fibers or of one, that are nearer to each other than this; `a` "
                          "and `b` then name the fibers or arrays to look at, all if missing",
                          "length"),
                    p.touching, positive());
  v.text(field("a", "name of a fiber, such as net/3/4; required without touching").optional(), p.fiber[0]);
  v.text(field("b", "name of a fiber, perhaps the same; required without touching").optional(), p.fiber[1]);
  v.choice<bool>(field("at_a", "the end of `a`").only("touching", "missing", !v.given("touching")), p.at_end[0], ends);
  v.choice<bool>(field("at_b", "the end of `b`").only("touching", "missing", !v.given("touching")), p.at_end[1], ends);
  v.optional_number(field("arc_length_a", "a place along `a` instead of an end; a node must lie there", "length")
                        .only("touching", "missing", !v.given("touching")),
                    p.arc_length[0], at_least(0));
  v.optional_number(
      field("arc_length_b", "the same on `b`", "length").only("touching", "missing", !v.given("touching")),
      p.arc_length[1], at_least(0));
  v.choice<mesh::JointType>(
      field("type", "what the nodes share"), p.type,
      {{mesh::JointType::position, "position", "the place: a hinge"},
       {mesh::JointType::rigid, "rigid",
        "the place, and all turn as one: tangents keep their angles, sections of simo_reissner do not twist"}});
  if (!v.reading()) return;
  for (const char* side : {"a", "b"})
    if (!v.given(side) && !v.given("touching"))
      v.missing(side, std::string("missing key \"") + side +
                          "\"; name two fibers by \"a\" and \"b\", or join all nodes that meet by \"touching\": 1e-6");
  for (const char* side : {"a", "b"})
    if (v.given(std::string("at_") + side) && v.given(std::string("arc_length_") + side))
      v.error(std::string("arc_length_") + side, std::string("contradicts \"at_") + side + "\"; remove one");
}

}  // namespace fbi::cases
