#include "meshgen/channel.hpp"

#include <cmath>

#include "mesh/hex_mesh.hpp"

namespace fbi::meshgen {
namespace {

/// Largest / smallest cell of the tanh line with n cells: the middle cell over the first one.
double tanh_ratio(double d, Index n) {
  const auto x = [&](Index i) { return std::tanh(d * (2.0 * i / n - 1.0)); };
  const Index middle = n / 2;
  const double largest = x(middle + 1) - x(middle);
  return largest / (x(1) - x(0));
}

/// The strength d with the wanted ratio; the ratio grows with d.
double tanh_strength(double ratio, Index n) {
  double low = 0.0, high = 1.0;
  while (tanh_ratio(high, n) < ratio && high < 16.0) high *= 2.0;
  for (int i = 0; i < 200 && high - low > 1e-15 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (tanh_ratio(middle, n) < ratio ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Position of node i of n cells in [0, 1].
double unit_position(Index i, Index n, const mesh::GradingParameters& grading, double strength) {
  const double s = static_cast<double>(i) / n;
  switch (grading.type) {
    case mesh::Grading::uniform:
      return s;
    case mesh::Grading::geometric: {
      const double logarithm = std::log(grading.ratio);
      return logarithm == 0.0 ? s : std::expm1(i * logarithm) / std::expm1(n * logarithm);
    }
    case mesh::Grading::tanh:
      return strength == 0.0 ? s : 0.5 * (1.0 + std::tanh(strength * (2.0 * s - 1.0)) / std::tanh(strength));
  }
  return s;
}

}  // namespace

std::vector<double> graded_line(double origin, double size, Index cells, const mesh::GradingParameters& grading) {
  const bool tanh = grading.type == mesh::Grading::tanh && grading.ratio > 1.0 && cells > 2;
  const double strength = tanh ? tanh_strength(grading.ratio, cells) : 0.0;
  std::vector<double> x(static_cast<std::size_t>(cells) + 1);
  for (Index i = 0; i <= cells; ++i) x[i] = origin + size * unit_position(i, cells, grading, strength);
  x.back() = origin + size;
  return x;
}

mesh::HexMeshData make_channel(const mesh::BoxParameters& box) {
  std::array<std::vector<double>, 3> coordinates;
  for (int a = 0; a < 3; ++a) coordinates[a] = graded_line(box.origin[a], box.size[a], box.elements[a], box.grading[a]);
  return mesh::make_box(coordinates, box.general);
}

}  // namespace fbi::meshgen
