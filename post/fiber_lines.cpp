#include "post/fiber_lines.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.hpp"
#include "case/schema.hpp"
#include "io/format.hpp"
#include "post/center_line.hpp"

namespace fbi::post {
namespace {

// Radius of each entry of "fibers"; empty when the index is not there yet or holds another text.
std::vector<double> group_radii(const Run& run) {
  std::vector<double> radii;
  if (!std::filesystem::exists(run.paths.index)) return radii;
  const io::File index = io::open_kind(run.paths.index, io::FileKind::result);
  if (!index.has("/input")) return radii;
  try {
    for (const cases::FiberGroup& group : cases::parse_case(index.read_text("/input"), run.name).fibers)
      radii.push_back(std::sqrt(group.physics.section.area / M_PI));
  } catch (const Error&) {  // written by another version of the program
    radii.clear();
  }
  return radii;
}

}  // namespace

FiberLines read_fiber_lines(const Run& run, const io::StepTime& output) {
  FiberLines lines;
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  const io::File fields = io::open_kind(run.paths.step(output.step), io::FileKind::step);
  if (!mesh.has("/fibers") || !fields.has("/fibers/position")) return lines;
  lines.position = fields.read<double>("/fibers/position");
  lines.group = mesh.read<GlobalIndex>("/fibers/group");
  lines.first = mesh.read<GlobalIndex>("/fibers/first_point");
  lines.first.push_back(static_cast<GlobalIndex>(lines.points()));
  const std::vector<double> dofs = mesh.read<double>("/fibers/reference_dofs"), radii = group_radii(run);
  std::vector<GlobalIndex> first_node = mesh.read<GlobalIndex>("/fibers/first_node");
  first_node.push_back(static_cast<GlobalIndex>(dofs.size() / 6));
  for (std::size_t f = 0; f < lines.fibers(); ++f) {
    const std::size_t group = static_cast<std::size_t>(lines.group[f]);
    lines.radius.push_back(group < radii.size() ? radii[group] : 0.0);
    const std::vector<double> nodes(dofs.begin() + 6 * first_node[f], dofs.begin() + 6 * first_node[f + 1]);
    const CenterLine rest(nodes, nodes);
    const std::vector<double> shares = rest.shares();
    const GlobalIndex points = lines.first[f + 1] - lines.first[f];
    const GlobalIndex per_element = (points - 1) / static_cast<GlobalIndex>(rest.elements());
    for (GlobalIndex p = 0; p < points; ++p) {
      const std::size_t e = std::min(static_cast<std::size_t>(p / per_element), rest.elements() - 1);
      const double part =
          static_cast<double>(p - per_element * static_cast<GlobalIndex>(e)) / static_cast<double>(per_element);
      const Vec3 x = rest.reference((1.0 - part) * shares[e] + part * shares[e + 1]);
      lines.reference.insert(lines.reference.end(), x.data(), x.data() + 3);
    }
  }
  return lines;
}

std::optional<CanopyHeight> canopy_height(const FiberLines& lines, int axis, const Vec3& from, const Vec3& to) {
  std::optional<CanopyHeight> height;
  for (std::size_t f = 0; f < lines.fibers(); ++f) {
    const double* foot = &lines.reference[3 * static_cast<std::size_t>(lines.first[f])];
    bool within = true;
    for (int d = 0; d < 3; ++d) within = within && (d == axis || (foot[d] >= from[d] && foot[d] <= to[d]));
    if (!within) continue;
    if (!height) height = CanopyHeight{foot[axis], foot[axis]};
    for (GlobalIndex p = lines.first[f]; p < lines.first[f + 1]; ++p) {
      const std::size_t at = 3 * static_cast<std::size_t>(p) + static_cast<std::size_t>(axis);
      height->rest = std::max(height->rest, lines.reference[at]);
      height->current = std::max(height->current, lines.position[at]);
    }
  }
  return height;
}

}  // namespace fbi::post
