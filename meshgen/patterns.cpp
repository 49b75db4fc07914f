#include "meshgen/patterns.hpp"

#include "base/error.hpp"
#include "meshgen/curves.hpp"

namespace fbi::meshgen {

void add_group(const cases::FiberGroup& group, Index group_number, mesh::FiberMeshData& fibers) {
  const std::string& name = group.physics.name;
  const double scale = std::max(group.curve.from.cwiseAbs().maxCoeff(), group.curve.to.cwiseAbs().maxCoeff());
  if (!((group.curve.to - group.curve.from).norm() > 1e-12 * scale)) {
    throw Error(ExitCode::geometry,
                "fiber \"" + name +
                    "\" has zero length: its curve begins and ends at the same point; move \"to\" away from \"from\"");
  }
  std::vector<CurvePoint> points;
  for (Index n = 0; n <= group.elements; ++n)
    points.push_back(point_on(group.curve, static_cast<double>(n) / group.elements));
  std::vector<double> lengths;
  for (Index e = 0; e < group.elements; ++e) {
    const CurvePoint &first = points[e], &second = points[e + 1];
    lengths.push_back(consistent_length(first.position, first.tangent, second.position, second.tangent));
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
