#include "coupling/fiber_side.hpp"

#include <algorithm>

#include "fem/line_shapes.hpp"

namespace fbi::coupling {

FiberSide::FiberSide(const mesh::FiberMesh& fibers, Multiplier multiplier, Index gauss_points)
    : fibers_(fibers),
      basis_(multiplier),
      rule_(fem::gauss_legendre(gauss_points)),
      first_row_(1, 0),
      element_row_(fibers.elements(), 0),
      d_blocks_(fibers.fibers()),
      lengths_(2 * static_cast<std::size_t>(fibers.fibers()), 0.0) {
  if (!basis_.is_lagrange()) {
    first_row_.resize(static_cast<std::size_t>(fibers.fibers()) + 1, 0);
    return;
  }
  for (Index f = 0; f < fibers.fibers(); ++f) {
    for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e)
      element_row_[e] = first_row_.back() + basis_.order() * (e - fibers.first_element(f));
    const Index count = fibers.first_element(f + 1) - fibers.first_element(f);
    first_row_.push_back(first_row_.back() + basis_.order() * count + 1);
  }
}

Index FiberSide::number_rows(ElementSegments& cuts) {
  Index row = 0;
  for (Index f = 0; f < fibers_.fibers(); ++f) {
    for (Index e = fibers_.first_element(f); e < fibers_.first_element(f + 1); ++e) {
      Index point = 0;
      for (Index s = cuts.first[e]; s < cuts.first[e + 1]; ++s) {
        Segment& segment = cuts.segments[s];
        segment.first_point = point;
        if (segment.cell >= 0) point += segment.rule_point >= 0 ? 1 : static_cast<Index>(rule_.points.size());
      }
      if (basis_.is_lagrange()) continue;
      element_row_[e] = row;
      row += point;
    }
    if (!basis_.is_lagrange()) first_row_[f + 1] = row;
  }
  return first_row_.back();
}

void FiberSide::integrate(const std::vector<ElementGeometry>& elements, const ElementSegments& cuts) {
  kappa_.assign(first_row_.back(), 0.0);
  row_points_.clear();
  segments_ = 0;
  ElementIntegrals in, out;
  std::vector<IntegrationPoint> inside, outside;
  for (Index f = 0; f < fibers_.fibers(); ++f) {
    const Index nodes = fibers_.first_node[f + 1] - fibers_.first_node[f];
    const std::size_t columns = 2 * static_cast<std::size_t>(nodes);
    std::vector<double>& d = d_blocks_[f];
    d.assign((first_row_[f + 1] - first_row_[f]) * columns, 0.0);
    lengths_[2 * f] = lengths_[2 * f + 1] = 0.0;
    for (Index e = fibers_.first_element(f); e < fibers_.first_element(f + 1); ++e) {
      inside.clear();
      outside.clear();
      for (Index s = cuts.first[e]; s < cuts.first[e + 1]; ++s) {
        const Segment& segment = cuts.segments[s];
        segments_ += segment.cell >= 0;
        integration_points(elements[e].measure, rule_, segment, segment.cell >= 0 ? inside : outside);
      }
      const Index rows = basis_.is_lagrange() ? basis_.order() + 1 : static_cast<Index>(inside.size());
      in.reset(rows);
      integrate_fiber(basis_, 0.5 * fibers_.element_length[e], inside, in);
      const Index first = element_row_[e], node = e - fibers_.first_element(f);
      for (Index p = 0; p < rows; ++p) {
        kappa_[first + p] += in.kappa[p];
        for (int j = 0; j < 4; ++j)
          d[static_cast<std::size_t>(first - first_row_[f] + p) * columns + 2 * node + j] += in.d[p][j];
      }
      lengths_[2 * f] += in.length;
      for (const IntegrationPoint& point : outside) lengths_[2 * f + 1] += point.ds;
      if (!basis_.is_lagrange()) row_points_.insert(row_points_.end(), inside.begin(), inside.end());
    }
  }
}

std::vector<double> FiberSide::at_nodes(const std::vector<double>& lambda) const {
  std::vector<double> result(3 * static_cast<std::size_t>(fibers_.nodes()), 0.0);
  std::vector<double> weight(fibers_.nodes(), 0.0);
  for (Index f = 0; f < fibers_.fibers(); ++f)
    for (Index e = fibers_.first_element(f); e < fibers_.first_element(f + 1); ++e) {
      const Index node = e + f;
      if (basis_.is_lagrange()) {
        for (int end = 0; end < 2; ++end)
          for (int i = 0; i < 3; ++i)
            result[3 * static_cast<std::size_t>(node + end) + i] =
                lambda[3 * static_cast<std::size_t>(element_row_[e] + basis_.order() * end) + i];
        continue;
      }
      const Index end_row = e + 1 < fibers_.elements() ? element_row_[e + 1] : first_row_.back();
      for (Index row = element_row_[e]; row < end_row; ++row) {
        const std::array<double, 2> shape = fem::linear(row_points_[row].x);
        for (int end = 0; end < 2; ++end) {
          const double part = shape[end] * row_points_[row].ds;
          weight[node + end] += part;
          for (int i = 0; i < 3; ++i)
            result[3 * static_cast<std::size_t>(node + end) + i] +=
                part * lambda[3 * static_cast<std::size_t>(row) + i];
        }
      }
    }
  if (basis_.is_lagrange()) return result;
  for (Index n = 0; n < fibers_.nodes(); ++n)
    for (int i = 0; i < 3; ++i)
      result[3 * static_cast<std::size_t>(n) + i] =
          weight[n] > 0.0 ? result[3 * static_cast<std::size_t>(n) + i] / weight[n] : 0.0;
  return result;
}

}  // namespace fbi::coupling
