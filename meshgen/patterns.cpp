#include "meshgen/patterns.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "meshgen/curves.hpp"

namespace fbi::meshgen {

// Relative errors of a fiber's length: worth a warning, and not the curve that was asked for.
constexpr double coarse = 0.01, too_coarse = 0.1;

void add_group(const cases::FiberGroup& group, Index group_number, mesh::FiberMeshData& fibers,
               std::vector<std::string>& warnings) {
  const std::string& name = group.physics.name;
  std::vector<CurvePoint> points;
  std::vector<double> lengths;
  try {
    const std::unique_ptr<CenterLine> line = make_center_line(group.curve);
    for (Index n = 0; n <= group.elements; ++n) points.push_back(line->at(static_cast<double>(n) / group.elements));
    double sum = 0.0;
    for (Index e = 0; e < group.elements; ++e) {
      const CurvePoint &first = points[e], &second = points[e + 1];
      lengths.push_back(consistent_length(first.position, first.tangent, second.position, second.tangent));
      sum += lengths.back();
    }
    const double error = sum / line->length() - 1;
    if (std::abs(error) > coarse) {
      const std::string line_text =
          log::format("is %.2g %% %s than its curve: %d element%s too few for it", 100 * std::abs(error),
                      error < 0 ? "shorter" : "longer", group.elements, group.elements > 1 ? "s are" : " is");
      if (std::abs(error) > too_coarse) throw Error(ExitCode::geometry, line_text + "; use more \"elements\"");
      warnings.push_back("fiber \"" + name + "\" " + line_text);
    }
    if ((points.back().position - points.front().position).norm() < 1e-9 * line->length())
      warnings.push_back("fiber \"" + name +
                         "\" ends where it begins; its two ends do not hold each other, unless "
                         "\"joints\" join them");
  } catch (const Error& error) {
    throw Error(error.code(), "fiber \"" + name + "\" " + error.what());
  }

  if (fibers.first_node.empty()) fibers.first_node.push_back(0);
  const std::array<Index, 3>& counts = group.array.counts;
  for (Index i = 0; i < counts[0]; ++i) {
    for (Index j = 0; j < counts[1]; ++j) {
      for (Index k = 0; k < counts[2]; ++k) {
        std::string fiber_name = name;
        const Index indices[] = {i, j, k};
        for (int a = 0; a < 3; ++a) {
          if (counts[a] > 1) fiber_name.append("/").append(std::to_string(indices[a]));
        }
        const Vec3 shift = Vec3(i, j, k).cwiseProduct(group.array.spacing);
        for (const CurvePoint& point : points) {
          const Vec3 position = point.position + shift;
          fibers.position.insert(fibers.position.end(), position.begin(), position.end());
          fibers.tangent.insert(fibers.tangent.end(), point.tangent.begin(), point.tangent.end());
        }
        fibers.element_length.insert(fibers.element_length.end(), lengths.begin(), lengths.end());
        fibers.name.push_back(std::move(fiber_name));
        fibers.group.push_back(group_number);
        fibers.first_node.push_back(fibers.first_node.back() + static_cast<GlobalIndex>(points.size()));
      }
    }
  }
}

}  // namespace fbi::meshgen
