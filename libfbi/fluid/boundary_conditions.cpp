#include "fluid/boundary_conditions.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "fluid/ghosted.hpp"
#include "fluid/physics.hpp"

namespace fbi::fluid {

namespace {

// A node's component is given by the condition with the largest key.
constexpr double key_step = 100000;
double key_of(BoundaryType type, std::size_t index) {
  const int priority = type == BoundaryType::no_slip  ? 4
                       : type == BoundaryType::inflow ? 3
                       : type == BoundaryType::mixed  ? 2
                                                      : 1;
  return priority * key_step + (key_step - 1 - static_cast<double>(index));
}
std::size_t condition_of(double key) { return static_cast<std::size_t>(key_step - 1 - std::fmod(key, key_step)); }

// Axis of a unit normal, or -1 when it is not along one.
int axis_of(const Vec3& normal) {
  for (int i = 0; i < 3; ++i)
    if (std::abs(normal[i]) > 1 - 1e-9) return i;
  return -1;
}

}  // namespace

Index Boundaries::face_node(const mesh::HexMesh::LocalFace& face, int a) const {
  return mesh_.cells[8 * static_cast<std::size_t>(face.cell) + fem::hex8_faces[face.face][a]];
}

Boundaries::FacePoints Boundaries::points(const mesh::HexMesh::LocalFace& face) const {
  FacePoints result;
  std::array<Vec3, 4> x;
  for (int a = 0; a < 4; ++a) x[a] = Eigen::Map<const Vec3>(mesh_.node(face_node(face, a)));
  const double g = 1 / std::sqrt(3.0);
  for (int q = 0; q < 4; ++q) {
    const double s = q == 0 || q == 3 ? -g : g, t = q < 2 ? -g : g;
    const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    Vec3 along_s = Vec3::Zero(), along_t = Vec3::Zero();
    result.position[q].setZero();
    for (int a = 0; a < 4; ++a) {
      result.shape[q][a] = 0.25 * (1 + corner[a][0] * s) * (1 + corner[a][1] * t);
      result.position[q] += result.shape[q][a] * x[a];
      along_s += 0.25 * corner[a][0] * (1 + corner[a][1] * t) * x[a];
      along_t += 0.25 * corner[a][1] * (1 + corner[a][0] * s) * x[a];
    }
    const Vec3 normal = along_s.cross(along_t);
    result.weight[q] = normal.norm();
    result.normal[q] = normal / result.weight[q];
  }
  return result;
}

bool Boundaries::leaves_normal_open(const BoundaryCondition& data, const mesh::HexMesh::LocalFace& face) const {
  if (data.type == BoundaryType::outflow || data.type == BoundaryType::traction) return true;
  if (data.type != BoundaryType::mixed) return false;
  const Vec3 normal = points(face).normal[0];
  for (int i = 0; i < 3; ++i)
    if (!data.velocity[i].has_value() && std::abs(normal[i]) > 1e-9) return true;
  return false;
}

Boundaries::Boundaries(const mesh::HexMesh& mesh, const BoundaryConditions& conditions, double density)
    : mesh_(mesh), density_(density) {
  for (const auto& [name, data] : conditions) conditions_.push_back({name, data});
  const std::size_t unknowns = 4 * static_cast<std::size_t>(mesh.local_nodes());
  linalg::VecHandle keys = create_ghosted(mesh);
  std::string error;
  ExitCode code = ExitCode::usage;
  {
    LocalArray key(keys);
    for (std::size_t c = 0; c < conditions_.size() && error.empty(); ++c) {
      const auto& [name, data] = conditions_[c];
      const auto found = mesh.faces.find(name);
      if (found == mesh.faces.end()) {
        std::string known;
        for (const auto& [other, faces] : mesh.faces) known += (known.empty() ? "" : ", ") + other;
        error = "boundary condition for '" + name + "': the mesh has no face set of this name; it has: " + known;
        break;
      }
      if (data.type == BoundaryType::inflow)
        for (int i = 0; i < 3; ++i)
          if (!data.velocity[i].has_value())
            error = "inflow '" + name + "': all three velocity components must be given";
      for (const mesh::HexMesh::LocalFace& face : found->second) {
        std::array<bool, 3> given{};
        if (data.type == BoundaryType::no_slip || data.type == BoundaryType::inflow) given = {true, true, true};
        if (data.type == BoundaryType::mixed)
          for (int i = 0; i < 3; ++i) given[i] = data.velocity[i].has_value();
        if (data.type == BoundaryType::slip) {
          const FacePoints at = points(face);
          const int axis = axis_of(at.normal[0]);
          for (const Vec3& normal : at.normal)
            if (axis < 0 || axis_of(normal) != axis) {
              code = ExitCode::geometry;
              error = log::format(
                  "slip wall '%s' has a face near (%g, %g, %g) that is not normal to x, y or z: slip is available on "
                  "axis-aligned walls only; use no_slip or traction there",
                  name.c_str(), at.position[0][0], at.position[0][1], at.position[0][2]);
            }
          if (!error.empty()) break;
          given[axis] = true;
        }
        for (int a = 0; a < 4; ++a)
          for (int i = 0; i < 3; ++i)
            if (given[i]) {
              double& k = key[4 * static_cast<std::size_t>(face_node(face, a)) + i];
              k = std::max(k, key_of(data.type, c));
            }
        if (leaves_normal_open(data, face)) open_.push_back(face);
        if (data.type == BoundaryType::traction || data.type == BoundaryType::mixed)
          if (std::any_of(data.traction.begin(), data.traction.end(), [](const auto& h) { return !h.is_zero(); }))
            loaded_.push_back({face, static_cast<Index>(c)});
        if (data.type == BoundaryType::outflow && data.backflow) backflow_.push_back({face, static_cast<Index>(c)});
      }
    }
  }
  agree_on_error(mesh.comm,
                 static_cast<ExitCode>(mesh.comm.max(static_cast<GlobalIndex>(error.empty() ? ExitCode::ok : code))),
                 error);
  FBI_PETSC(VecGhostUpdateBegin(keys, MAX_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(keys, MAX_VALUES, SCATTER_REVERSE));
  update_ghosts(keys);
  LocalArray key(keys);
  is_dirichlet_.assign(unknowns, 0);
  bool timed = false;
  for (std::size_t k = 0; k < unknowns; ++k) {
    if (key[k] == 0) continue;
    is_dirichlet_[k] = 1;
    const Condition& condition = conditions_[condition_of(key[k])];
    const BoundaryType type = condition.data.type;
    const bool formula = type == BoundaryType::inflow || type == BoundaryType::mixed;
    given_.push_back({k, formula ? &*condition.data.velocity[k % 4] : nullptr, &condition.name});
    timed = timed || (formula && given_.back().formula->depends_on_time());
  }
  given_value_.assign(given_.size(), 0.0);
  has_timed_velocity_ = mesh.comm.any(timed);
}

void Boundaries::evaluate_traction(LoadedFace& loaded, double t, std::string& error) const {
  const Condition& condition = conditions_[loaded.condition];
  const FacePoints at = points(loaded.face);
  loaded.load = {};
  for (int i = 0; i < 3; ++i) {
    if (condition.data.type == BoundaryType::mixed && condition.data.velocity[i].has_value()) continue;
    for (int q = 0; q < 4; ++q) {
      const double h = condition.data.traction[i](at.position[q], t);
      if (!std::isfinite(h))
        error = log::format("traction on '%s' is not finite at (%g, %g, %g), t = %g", condition.name.c_str(),
                            at.position[q][0], at.position[q][1], at.position[q][2], t);
      for (int a = 0; a < 4; ++a) loaded.load[a][i] += at.weight[q] * at.shape[q][a] * h;
    }
  }
}

void Boundaries::set_time(double t) {
  std::string error;
  for (std::size_t k = 0; k < given_.size(); ++k) {
    const auto& [unknown, formula, name] = given_[k];
    if (formula == nullptr || (evaluated_ && !formula->depends_on_time())) continue;
    const double* x = mesh_.node(static_cast<Index>(unknown / 4));
    given_value_[k] = (*formula)(x[0], x[1], x[2], t);
    if (!std::isfinite(given_value_[k]))
      error = log::format("velocity on '%s' is not finite at (%g, %g, %g), t = %g", name->c_str(), x[0], x[1], x[2], t);
  }
  for (LoadedFace& loaded : loaded_) {
    const auto& traction = conditions_[loaded.condition].data.traction;
    if (evaluated_ && std::none_of(traction.begin(), traction.end(), [](const auto& h) { return h.depends_on_time(); }))
      continue;
    evaluate_traction(loaded, t, error);
  }
  evaluated_ = true;
  agree_on_error(mesh_.comm, ExitCode::diverged, error);
}

void Boundaries::apply(double* u) const {
  for (std::size_t k = 0; k < given_.size(); ++k) u[given_[k].unknown] = given_value_[k];
}

double Boundaries::largest_mismatch(const double* u) const {
  double largest = 0;
  for (std::size_t k = 0; k < given_.size(); ++k)
    largest = std::max(largest, std::abs(u[given_[k].unknown] - given_value_[k]));
  return largest;
}

bool Boundaries::has_load() const {
  for (const LoadedFace& loaded : loaded_)
    for (const auto& node : loaded.load)
      for (double value : node)
        if (value != 0) return true;
  return false;
}

template <class T>
void Boundaries::backflow_face(const FacePoints& at, double beta_density, const T* u, T* r) const {
  for (int k = 0; k < 12; ++k) r[k] = T(0.0);
  for (int q = 0; q < 4; ++q) {
    T velocity[3] = {T(0.0), T(0.0), T(0.0)}, flux[3];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) velocity[i] = velocity[i] + at.shape[q][a] * u[3 * a + i];
    backflow(velocity, at.normal[q].data(), beta_density, flux);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) r[3 * a + i] = r[3 * a + i] + (at.weight[q] * at.shape[q][a]) * flux[i];
  }
}

void Boundaries::add_residual(const double* u, double* r) const {
  for (const LoadedFace& loaded : loaded_)
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) r[4 * static_cast<std::size_t>(face_node(loaded.face, a)) + i] -= loaded.load[a][i];
  for (const LoadedFace& open : backflow_) {
    double values[12], out[12];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) values[3 * a + i] = u[4 * static_cast<std::size_t>(face_node(open.face, a)) + i];
    backflow_face(points(open.face), conditions_[open.condition].data.backflow_beta * density_, values, out);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) r[4 * static_cast<std::size_t>(face_node(open.face, a)) + i] += out[3 * a + i];
  }
}

void Boundaries::add_tangent(const double* u, const double* x, double* y) const {
  for (const LoadedFace& open : backflow_) {
    Dual<double> values[12], out[12];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) {
        const std::size_t k = 4 * static_cast<std::size_t>(face_node(open.face, a)) + i;
        values[3 * a + i] = {u[k], x[k]};
      }
    backflow_face(points(open.face), conditions_[open.condition].data.backflow_beta * density_, values, out);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i)
        y[4 * static_cast<std::size_t>(face_node(open.face, a)) + i] += out[3 * a + i].derivative;
  }
}

void Boundaries::visit_tangents(const double* u,
                                const std::function<void(Index, const Corners&, const FaceMatrix&)>& visit) const {
  for (const LoadedFace& open : backflow_) {
    const FacePoints at = points(open.face);
    Dual<double> values[12], out[12];
    FaceMatrix matrix;
    for (int column = 0; column < 12; ++column) {
      for (int k = 0; k < 12; ++k)
        values[k] = {u[4 * static_cast<std::size_t>(face_node(open.face, k / 3)) + k % 3], k == column ? 1.0 : 0.0};
      backflow_face(at, conditions_[open.condition].data.backflow_beta * density_, values, out);
      for (int k = 0; k < 12; ++k) matrix[k][column] = out[k].derivative;
    }
    visit(open.face.cell, fem::hex8_faces[open.face.face], matrix);
  }
}

void Boundaries::visit_open_faces(
    const std::function<void(Index, const Corners&, const FaceMass&, double)>& visit) const {
  for (const mesh::HexMesh::LocalFace& face : open_) {
    const FacePoints at = points(face);
    FaceMass mass{};
    double area = 0;
    for (int q = 0; q < 4; ++q) {
      area += at.weight[q];
      for (int a = 0; a < 4; ++a)
        for (int b = 0; b < 4; ++b) mass[a][b] += at.weight[q] * at.shape[q][a] * at.shape[q][b];
    }
    visit(face.cell, fem::hex8_faces[face.face], mass, area);
  }
}

}  // namespace fbi::fluid
