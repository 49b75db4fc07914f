#include "fluid/boundary_forces.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "base/error.hpp"
#include "fluid/boundary_conditions.hpp"
#include "fluid/ghosted.hpp"

namespace fbi::fluid {

namespace {

constexpr double held = 1e-6;  // eigenvalue relative to the largest: directions below are not held by any face

double area_of(const FacePoints& at, int a) {
  double sum = 0;
  for (int q = 0; q < 4; ++q) sum += at.weight[q] * at.shape[q][a];
  return sum;
}

/// Inverse on the range of a symmetric matrix.
Mat3 range_inverse(const Mat3& matrix) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(matrix);
  Mat3 inverse = Mat3::Zero();
  for (int k = 0; k < 3; ++k)
    if (solver.eigenvalues()[k] > held * solver.eigenvalues()[2])
      inverse += solver.eigenvectors().col(k) * solver.eigenvectors().col(k).transpose() / solver.eigenvalues()[k];
  return inverse;
}

/// int N_a p n of the pressures at the four corners.
std::array<Vec3, 4> pressure_force(const FacePoints& at, const std::array<double, 4>& pressure) {
  std::array<Vec3, 4> force = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int q = 0; q < 4; ++q) {
    double p = 0;
    for (int a = 0; a < 4; ++a) p += at.shape[q][a] * pressure[a];
    for (int a = 0; a < 4; ++a) force[a] += at.weight[q] * at.shape[q][a] * p * at.normal[q];
  }
  return force;
}

}  // namespace

BoundaryForces::BoundaryForces(const FluidField& field, std::vector<ForceSet> sets)
    : field_(field), sets_(std::move(sets)), members_(sets_.size()) {
  const mesh::HexMesh& mesh = field_.mesh();
  std::string error;
  for (std::size_t k = 0; k < sets_.size(); ++k) {
    for (const std::string& name : sets_[k].faces) {
      const auto found = mesh.faces.find(name);
      if (found == mesh.faces.end()) {
        std::string known;
        for (const auto& [other, faces] : mesh.faces) known += (known.empty() ? "" : ", ") + other;
        error = "forces on '" + name + "': the mesh has no face set of this name; it has: " + known;
        break;
      }
      for (const mesh::HexMesh::LocalFace& face : found->second) members_[k].emplace_back(face.cell, face.face);
    }
    std::sort(members_[k].begin(), members_[k].end());
  }
  agree_on_error(mesh.comm, ExitCode::usage, error);
  // Sums over all faces at a node, six entries of a symmetric matrix in two vectors.
  constexpr std::array<std::array<int, 2>, 6> entry = {{{0, 0}, {1, 1}, {2, 2}, {0, 1}, {0, 2}, {1, 2}}};
  const linalg::VecHandle vectors[2] = {create_ghosted(mesh), create_ghosted(mesh)};
  for (int v = 0; v < 2; ++v) {
    {
      LocalArray sum(vectors[v]);
      for (const Boundaries::ConditionedFace& conditioned : field_.boundaries().faces()) {
        const FacePoints at = face_points(mesh, conditioned.face);
        for (int a = 0; a < 4; ++a) {
          const Mat3 share = area_of(at, a) * field_.boundaries().held_directions(conditioned, at, a);
          const std::size_t node = face_node(mesh, conditioned.face, a);
          for (int e = 0; e < 3; ++e) sum[4 * node + e] += share(entry[3 * v + e][0], entry[3 * v + e][1]);
        }
      }
    }
    add_ghosts(vectors[v]);
    update_ghosts(vectors[v]);
  }
  share_.assign(mesh.local_nodes(), Mat3::Zero());
  LocalArray first(vectors[0]), second(vectors[1]);
  for (std::size_t node = 0; node < share_.size(); ++node) {
    Mat3 sum;
    for (int e = 0; e < 6; ++e)
      sum(entry[e][0], entry[e][1]) = sum(entry[e][1], entry[e][0]) = (e < 3 ? first : second)[4 * node + e % 3];
    if (sum.trace() > 0) share_[node] = range_inverse(sum);
  }
}

std::vector<std::size_t> BoundaryForces::sets_of(const mesh::HexMesh::LocalFace& face) const {
  std::vector<std::size_t> sets;
  for (std::size_t k = 0; k < sets_.size(); ++k)
    if (std::binary_search(members_[k].begin(), members_[k].end(), std::make_pair(face.cell, face.face)))
      sets.push_back(k);
  return sets;
}

std::vector<BoundaryForce> BoundaryForces::evaluate(Vec vector, Vec balance) const {
  const mesh::HexMesh& mesh = field_.mesh();
  const Boundaries& boundaries = field_.boundaries();
  std::vector<BoundaryForce> result(sets_.size());
  const auto add = [&](const mesh::HexMesh::LocalFace& face, const std::array<Vec3, 4>& force) {
    for (const std::size_t k : sets_of(face))
      for (int a = 0; a < 4; ++a) {
        const Vec3 arm = Eigen::Map<const Vec3>(mesh.node(face_node(mesh, face, a))) - sets_[k].about;
        result[k].force += force[a];
        result[k].moment += arm.cross(force[a]);
      }
  };
  const linalg::VecHandle known_vector = create_ghosted(mesh);
  update_ghosts(balance);
  LocalArray u(vector), total(balance);
  const auto pressures = [&](const mesh::HexMesh::LocalFace& face) {
    std::array<double, 4> p;
    for (int a = 0; a < 4; ++a) p[a] = u[4 * static_cast<std::size_t>(face_node(mesh, face, a)) + 3];
    return p;
  };
  {
    LocalArray known(known_vector);
    const auto collect = [&](const mesh::HexMesh::LocalFace& face, const std::array<Vec3, 4>& force) {
      for (int a = 0; a < 4; ++a)
        Eigen::Map<Vec3>(known.data() + 4 * static_cast<std::size_t>(face_node(mesh, face, a))) += force[a];
      add(face, force);
    };
    boundaries.visit_open_forces(u.data(), collect);
    for (const Boundaries::ConditionedFace& conditioned : boundaries.faces()) {
      const FacePoints at = face_points(mesh, conditioned.face);
      std::array<Vec3, 4> force = pressure_force(at, pressures(conditioned.face));
      for (int a = 0; a < 4; ++a) force[a] = boundaries.held_directions(conditioned, at, a) * force[a];
      collect(conditioned.face, force);
    }
  }
  add_ghosts(known_vector);
  update_ghosts(known_vector);
  LocalArray known(known_vector);
  for (const Boundaries::ConditionedFace& conditioned : boundaries.faces()) {
    if (sets_of(conditioned.face).empty()) continue;
    const FacePoints at = face_points(mesh, conditioned.face);
    std::array<Vec3, 4> force;
    for (int a = 0; a < 4; ++a) {
      const std::size_t node = face_node(mesh, conditioned.face, a);
      const Vec3 rest =
          -Eigen::Map<const Vec3>(total.data() + 4 * node) - Eigen::Map<const Vec3>(known.data() + 4 * node);
      force[a] = area_of(at, a) * (boundaries.held_directions(conditioned, at, a) * (share_[node] * rest));
    }
    add(conditioned.face, force);
  }
  for (BoundaryForce& sum : result) {
    mesh.comm.sum(sum.force.data(), 3);
    mesh.comm.sum(sum.moment.data(), 3);
  }
  return result;
}

}  // namespace fbi::fluid
