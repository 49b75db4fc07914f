#include "fluid/boundary_conditions.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "fluid/face_points.hpp"
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
bool is_open(BoundaryType type) {
  return type == BoundaryType::outflow || type == BoundaryType::traction || type == BoundaryType::pressure;
}
std::size_t condition_of(double key) { return static_cast<std::size_t>(key_step - 1 - std::fmod(key, key_step)); }

}  // namespace

bool Boundaries::leaves_normal_open(const BoundaryCondition& data, const mesh::HexMesh::LocalFace& face) const {
  if (is_open(data.type)) return true;
  if (data.type != BoundaryType::mixed) return false;
  const FacePoints at = face_points(mesh_, face);
  for (const Vec3& normal : at.normal)
    for (int i = 0; i < 3; ++i)
      if (!data.velocity[i].has_value() && std::abs(normal[i]) > 1e-9) return true;
  return false;
}

Boundaries::Boundaries(const mesh::HexMesh& mesh, const BoundaryConditions& conditions, double density)
    : mesh_(mesh), density_(density) {
  for (const auto& [name, data] : conditions) conditions_.push_back({name, data});
  const std::size_t unknowns = 4 * static_cast<std::size_t>(mesh.local_nodes());
  linalg::VecHandle keys = create_ghosted(mesh), aligned_keys = create_ghosted(mesh);
  std::string error;
  std::vector<mesh::HexMesh::LocalFace> slip;
  bool oblique = false;  // some slip face is not normal to an axis
  {
    LocalArray key(keys), aligned(aligned_keys);
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
        faces_.push_back({face, static_cast<Index>(c)});
        if (data.type == BoundaryType::slip) {
          const FacePoints at = face_points(mesh_, face);
          const int axis = axis_of(at.normal[0]);
          slip.push_back(face);
          oblique = oblique || std::any_of(at.normal.begin(), at.normal.end(),
                                           [axis](const Vec3& n) { return axis < 0 || axis_of(n) != axis; });
          if (axis >= 0) given[axis] = true;
        }
        for (int a = 0; a < 4; ++a)
          for (int i = 0; i < 3; ++i)
            if (given[i]) {
              LocalArray& to = data.type == BoundaryType::slip ? aligned : key;
              double& k = to[4 * static_cast<std::size_t>(face_node(mesh_, face, a)) + i];
              k = std::max(k, key_of(data.type, c));
            }
        if (leaves_normal_open(data, face)) open_.push_back(face);
        if (data.type == BoundaryType::traction || data.type == BoundaryType::mixed)
          if (std::any_of(data.traction.begin(), data.traction.end(), [](const auto& h) { return !h.is_zero(); }))
            loaded_.push_back({face, static_cast<Index>(c)});
        if (data.type == BoundaryType::pressure && !data.pressure.is_zero())
          loaded_.push_back({face, static_cast<Index>(c)});
        if (is_open(data.type) && data.backflow) backflow_.push_back({face, static_cast<Index>(c)});
      }
    }
  }
  agree_on_error(mesh.comm, ExitCode::usage, error);
  oblique = mesh.comm.any(oblique);
  if (oblique) slip_normals_ = wall_normals(mesh, slip);
  {
    // Slip walls along the axes give components of the velocity; where some wall is oblique, its nodes tell which.
    LocalArray key(keys), aligned(aligned_keys);
    if (oblique) {
      std::fill_n(aligned.data(), unknowns, 0.0);
      for (const NodeNormals& at : slip_normals_)
        for (const Vec3& normal : at.normals)
          if (const int axis = axis_of(normal); axis >= 0)
            aligned[4 * static_cast<std::size_t>(at.node) + axis] = key_of(BoundaryType::slip, 0);
    }
    for (std::size_t k = 0; k < unknowns; ++k) key[k] = std::max(key[k], aligned[k]);
  }
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
    const bool formula = key[k] >= 2 * key_step && key[k] < 4 * key_step;  // inflow or mixed
    given_.push_back({k, formula ? &*condition.data.velocity[k % 4] : nullptr, &condition.name});
    timed = timed || (formula && given_.back().formula->depends_on_time());
  }
  given_value_.assign(given_.size(), 0.0);
  for (const NodeNormals& at : slip_normals_) {
    NodeNormals leaning{at.node};
    for (const Vec3& normal : at.normals)
      if (axis_of(normal) < 0) leaning.normals.push_back(normal);
    NormalConstraint constraint = make_constraint(leaning, &is_dirichlet_[4 * static_cast<std::size_t>(at.node)]);
    if (!constraint.direction.empty()) constraints_.push_back(std::move(constraint));
  }
  for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(mesh.owned_nodes); ++k)
    if (is_dirichlet_[k] != 0) fixed_.push_back(k);
  has_timed_velocity_ = mesh.comm.any(timed);
}

bool Boundaries::has_backflow() const {
  return std::any_of(conditions_.begin(), conditions_.end(),
                     [](const Condition& c) { return is_open(c.data.type) && c.data.backflow; });
}

void Boundaries::evaluate_traction(LoadedFace& loaded, double t, std::string& error) const {
  const Condition& condition = conditions_[loaded.condition];
  const FacePoints at = face_points(mesh_, loaded.face);
  loaded.load = {};
  for (int i = 0; i < 3; ++i) {
    if (condition.data.type == BoundaryType::mixed && condition.data.velocity[i].has_value()) continue;
    for (int q = 0; q < 4; ++q) {
      const bool pressure = condition.data.type == BoundaryType::pressure;
      const double h = pressure ? -condition.data.pressure(at.position[q], t) * at.normal[q][i]
                                : condition.data.traction[i](at.position[q], t);
      if (!std::isfinite(h))
        error = log::format("%s on '%s' is not finite at (%g, %g, %g), t = %g", pressure ? "pressure" : "traction",
                            condition.name.c_str(), at.position[q][0], at.position[q][1], at.position[q][2], t);
      for (int a = 0; a < 4; ++a) loaded.load[a][i] += at.weight[q] * at.shape[q][a] * h;
    }
  }
}

void Boundaries::set_time(double t) {
  std::string error;
  GlobalIndex evaluated = 0;
  for (std::size_t k = 0; k < given_.size(); ++k) {
    const auto& [unknown, formula, name] = given_[k];
    if (formula == nullptr || (evaluated_ && !formula->depends_on_time())) continue;
    ++evaluated;
    const double* x = mesh_.node(static_cast<Index>(unknown / 4));
    given_value_[k] = (*formula)(x[0], x[1], x[2], t);
    if (!std::isfinite(given_value_[k]))
      error = log::format("velocity on '%s' is not finite at (%g, %g, %g), t = %g", name->c_str(), x[0], x[1], x[2], t);
  }
  for (LoadedFace& loaded : loaded_) {
    const BoundaryCondition& data = conditions_[loaded.condition].data;
    if (evaluated_ && !data.pressure.depends_on_time() &&
        std::none_of(data.traction.begin(), data.traction.end(), [](const auto& h) { return h.depends_on_time(); }))
      continue;
    ++evaluated;
    evaluate_traction(loaded, t, error);
  }
  count_parts("boundary values evaluated", evaluated);
  evaluated_ = true;
  agree_on_error(mesh_.comm, ExitCode::diverged, error);
  if (mesh_.has_images()) take_values_of_masters();
}

// Images of periodic faces take the values of their masters, so that a formula that is not periodic means one velocity.
void Boundaries::take_values_of_masters() {
  linalg::VecHandle values = create_ghosted(mesh_);
  {
    LocalArray v(values);
    apply(v.data());
  }
  update_ghosts(values);
  LocalArray v(values);
  for (std::size_t k = 0; k < given_.size(); ++k) given_value_[k] = v[given_[k].unknown];
}

void Boundaries::apply(double* u) const {
  for (std::size_t k = 0; k < given_.size(); ++k) u[given_[k].unknown] = given_value_[k];
  for (const NormalConstraint& c : constraints_) {
    Eigen::Map<Vec3> v(u + 4 * static_cast<std::size_t>(c.node));
    for (std::size_t k = 0; k < c.direction.size(); ++k) v -= c.full[k].dot(v) * c.direction[k];
  }
}

double Boundaries::largest_mismatch(const double* u) const {
  double largest = 0;
  for (std::size_t k = 0; k < given_.size(); ++k)
    largest = std::max(largest, std::abs(u[given_[k].unknown] - given_value_[k]));
  for (const NormalConstraint& c : constraints_)
    for (const Vec3& full : c.full)
      largest = std::max(largest, std::abs(full.dot(Eigen::Map<const Vec3>(u + 4 * static_cast<std::size_t>(c.node)))));
  return largest;
}

void Boundaries::remove_normal(double* values, Index nodes) const {
  for (const NormalConstraint& c : constraints_) {
    if (c.node >= nodes) return;
    Eigen::Map<Vec3> v(values + 4 * static_cast<std::size_t>(c.node));
    v = c.without(v);
  }
}

void Boundaries::set_normal(const double* from, double* to, Index nodes) const {
  for (const NormalConstraint& c : constraints_) {
    if (c.node >= nodes) return;
    const Eigen::Map<const Vec3> source(from + 4 * static_cast<std::size_t>(c.node));
    Eigen::Map<Vec3> target(to + 4 * static_cast<std::size_t>(c.node));
    target = c.without(target) + source - c.without(source);
  }
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
    backflow(velocity, at.normal[q].data(), beta_density, frozen_, flux);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) r[3 * a + i] = r[3 * a + i] + (at.weight[q] * at.shape[q][a]) * flux[i];
  }
}

void Boundaries::add_residual(const double* u, double* r) const {
  for (const LoadedFace& loaded : loaded_)
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i)
        r[4 * static_cast<std::size_t>(face_node(mesh_, loaded.face, a)) + i] -= loaded.load[a][i];
  for (const LoadedFace& open : backflow_) {
    double values[12], out[12];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i)
        values[3 * a + i] = u[4 * static_cast<std::size_t>(face_node(mesh_, open.face, a)) + i];
    backflow_face(face_points(mesh_, open.face), conditions_[open.condition].data.backflow_beta * density_, values,
                  out);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) r[4 * static_cast<std::size_t>(face_node(mesh_, open.face, a)) + i] += out[3 * a + i];
  }
}

void Boundaries::add_tangent(const double* u, const double* x, double* y) const {
  for (const LoadedFace& open : backflow_) {
    Dual<double> values[12], out[12];
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i) {
        const std::size_t k = 4 * static_cast<std::size_t>(face_node(mesh_, open.face, a)) + i;
        values[3 * a + i] = {u[k], x[k]};
      }
    backflow_face(face_points(mesh_, open.face), conditions_[open.condition].data.backflow_beta * density_, values,
                  out);
    for (int a = 0; a < 4; ++a)
      for (int i = 0; i < 3; ++i)
        y[4 * static_cast<std::size_t>(face_node(mesh_, open.face, a)) + i] += out[3 * a + i].derivative;
  }
}

void Boundaries::visit_tangents(const double* u,
                                const std::function<void(Index, const Corners&, const FaceMatrix&)>& visit) const {
  for (const LoadedFace& open : backflow_) {
    const FacePoints at = face_points(mesh_, open.face);
    Dual<double> values[12], out[12];
    FaceMatrix matrix;
    for (int column = 0; column < 12; ++column) {
      for (int k = 0; k < 12; ++k)
        values[k] = {u[4 * static_cast<std::size_t>(face_node(mesh_, open.face, k / 3)) + k % 3],
                     k == column ? 1.0 : 0.0};
      backflow_face(at, conditions_[open.condition].data.backflow_beta * density_, values, out);
      for (int k = 0; k < 12; ++k) matrix[k][column] = out[k].derivative;
    }
    visit(open.face.cell, fem::hex8_faces[open.face.face], matrix);
  }
}

Mat3 Boundaries::held_directions(const ConditionedFace& face, const FacePoints& at, int a) const {
  const BoundaryCondition& data = conditions_[face.condition].data;
  Mat3 held = Mat3::Zero();
  if (data.type == BoundaryType::no_slip || data.type == BoundaryType::inflow) held.setIdentity();
  if (data.type == BoundaryType::mixed)
    for (int i = 0; i < 3; ++i) held(i, i) = data.velocity[i].has_value() ? 1 : 0;
  if (data.type != BoundaryType::slip) return held;
  // The wall's normal at the node: of the pieces that meet there, the one that the face belongs to.
  const Vec3 own = at.area_vector(a).normalized();
  Vec3 normal = own;
  const Index node = face_node(mesh_, face.face, a);
  const auto found = std::lower_bound(slip_normals_.begin(), slip_normals_.end(), node,
                                      [](const NodeNormals& n, Index number) { return n.node < number; });
  if (found != slip_normals_.end() && found->node == node)
    normal = *std::max_element(found->normals.begin(), found->normals.end(),
                               [&](const Vec3& m, const Vec3& n) { return m.dot(own) < n.dot(own); });
  if (const int axis = axis_of(normal); axis >= 0) normal = Vec3::Unit(axis);
  return normal * normal.transpose();
}

void Boundaries::visit_open_forces(
    const double* u, const std::function<void(const mesh::HexMesh::LocalFace&, const FaceForce&)>& visit) const {
  FaceForce force;
  for (const LoadedFace& loaded : loaded_) {
    for (int a = 0; a < 4; ++a) force[a] = -Eigen::Map<const Vec3>(loaded.load[a].data());
    visit(loaded.face, force);
  }
  for (const LoadedFace& open : backflow_) {
    double values[12], out[12];
    for (int k = 0; k < 12; ++k)
      values[k] = u[4 * static_cast<std::size_t>(face_node(mesh_, open.face, k / 3)) + k % 3];
    backflow_face(face_points(mesh_, open.face), conditions_[open.condition].data.backflow_beta * density_, values,
                  out);
    for (int a = 0; a < 4; ++a) force[a] = Eigen::Map<const Vec3>(out + 3 * a);
    visit(open.face, force);
  }
}

void Boundaries::visit_open_faces(
    const std::function<void(Index, const Corners&, const FaceMass&, double)>& visit) const {
  for (const mesh::HexMesh::LocalFace& face : open_) {
    const FacePoints at = face_points(mesh_, face);
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

std::array<double, 3> Boundaries::flow(const double* u) const {
  std::array<double, 3> flow = {0.0, 0.0, 0.0};
  std::set<std::pair<Index, Index>> done;
  for (const ConditionedFace& conditioned : faces()) {
    if (!done.emplace(conditioned.face.cell, conditioned.face.face).second) continue;
    const FacePoints at = face_points(mesh_, conditioned.face);
    for (int a = 0; a < 4; ++a) {
      const std::size_t node = face_node(mesh_, conditioned.face, a);
      const Eigen::Map<const Vec3> velocity(u + 4 * node);
      const Vec3 area = at.area_vector(a);
      flow[0] += velocity.dot(area);
      flow[2] += velocity.norm() * area.norm();
      if (is_dirichlet_[4 * node] && is_dirichlet_[4 * node + 1] && is_dirichlet_[4 * node + 2])
        flow[1] += velocity.norm() * area.norm();
    }
  }
  return flow;
}

}  // namespace fbi::fluid
