#include "fluid/single_tangent.hpp"

#include <algorithm>

#include "base/counters.hpp"
#include "base/timer.hpp"
#include "fem/hex8.hpp"

namespace fbi::fluid {

SingleTangent::SingleTangent(const mesh::HexMesh& mesh, const Operator& cells, const Boundaries& boundaries)
    : mesh_(mesh), operator_(cells), boundaries_(boundaries), halo_(mesh), linear_(cells.linear_cells()) {}

void SingleTangent::linearize(const double* u, const double* rest) {
  operator_.linearize(u, rest, linear_);
  linearize_faces(u);
}

void SingleTangent::linearize_with_residual(const double* u, const double* rest, double* r) {
  operator_.add_residual_and_linearize(u, rest, r, linear_);
  linearize_faces(u);
}

void SingleTangent::linearize_faces(const double* u) {
  faces_.clear();
  boundaries_.visit_tangents(u, [&](Index cell, const Boundaries::Corners& corners, const Boundaries::FaceMatrix& m) {
    FaceTangent face;
    bool any = false;
    for (int a = 0; a < 4; ++a) face.node[a] = mesh_.cells[8 * static_cast<std::size_t>(cell) + corners[a]];
    for (int i = 0; i < 12; ++i)
      for (int j = 0; j < 12; ++j) {
        face.matrix[i][j] = static_cast<float>(m[i][j]);
        any = any || face.matrix[i][j] != 0.0f;
      }
    if (any) faces_.push_back(face);
  });
}

void SingleTangent::remove_normal(float* values, Index nodes) const {
  for (const NormalConstraint& constraint : boundaries_.constraints()) {
    if (constraint.node >= nodes) break;
    float* v = values + 4 * static_cast<std::size_t>(constraint.node);
    const Vec3 without = constraint.without(Vec3(v[0], v[1], v[2]));
    for (int i = 0; i < 3; ++i) v[i] = static_cast<float>(without[i]);
  }
}

void SingleTangent::finish(float* y) const {
  halo_.add_ghosts(y);
  for (const std::size_t k : boundaries_.fixed()) y[k] = 0.0f;
  remove_normal(y, mesh_.owned_nodes);
}

void SingleTangent::apply_to_pressure(const float* x, float* y) const {
  const Timed timed("pressure gradient");
  std::fill_n(y, 4 * static_cast<std::size_t>(mesh_.local_nodes()), 0.0f);
  add_pressure_columns(linear_, x, y);
  finish(y);
}

void SingleTangent::add_velocity(const float* x, float* y, const std::function<void(float*)>& add) const {
  const Timed timed("fluid tangent");
  count("fluid tangent products");
  std::fill(y + 4 * static_cast<std::size_t>(mesh_.owned_nodes), y + 4 * static_cast<std::size_t>(mesh_.local_nodes()),
            0.0f);
  add_velocity_columns(linear_, x, y);
  for (const FaceTangent& face : faces_) {
    float in[12];
    for (int k = 0; k < 12; ++k) in[k] = x[4 * static_cast<std::size_t>(face.node[k / 3]) + k % 3];
    for (int i = 0; i < 12; ++i) {
      float sum = 0.0f;
      for (int j = 0; j < 12; ++j) sum += face.matrix[i][j] * in[j];
      y[4 * static_cast<std::size_t>(face.node[i / 3]) + i % 3] += sum;
    }
  }
  if (add) add(y);
  finish(y);
}

}  // namespace fbi::fluid
