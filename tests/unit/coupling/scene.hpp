/// Small distributed scenes for the tests of the coupling operators.
#pragma once

#include <cmath>
#include <functional>
#include <random>

#include "coupling/coupling.hpp"

namespace fbi::test {

inline std::vector<double> uniform(double begin, double end, int cells) {
  std::vector<double> x;
  for (int i = 0; i <= cells; ++i) x.push_back(begin + (end - begin) * i / cells);
  return x;
}

/// Unit cube of n^3 cells.
inline mesh::HexMeshData cube(int n, bool general = false) {
  return mesh::make_box({uniform(0, 1, n), uniform(0, 1, n), uniform(0, 1, n)}, general);
}

/// Moves the inner nodes of a mesh of the unit cube at random by up to `amount` [length] in each direction.
inline mesh::HexMeshData perturbed(mesh::HexMeshData mesh, double amount, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> shift(-amount, amount);
  mesh.box.reset();
  for (std::size_t n = 0; n < mesh.nodes.size() / 3; ++n) {
    double* x = &mesh.nodes[3 * n];
    const bool inner = x[0] > 0 && x[0] < 1 && x[1] > 0 && x[1] < 1 && x[2] > 0 && x[2] < 1;
    for (int i = 0; i < 3; ++i) {
      const double move = shift(random);
      if (inner) x[i] += move;
    }
  }
  return mesh;
}

/// Adds a straight fiber.
inline void add_line(mesh::FiberMeshData& fibers, const Vec3& from, const Vec3& to, int elements,
                     const std::string& name = "", Index group = 0) {
  if (fibers.first_node.empty()) fibers.first_node.push_back(0);
  const Vec3 tangent = (to - from).normalized();
  for (int n = 0; n <= elements; ++n) {
    const Vec3 x = from + (to - from) * n / elements;
    for (int i = 0; i < 3; ++i) fibers.position.push_back(x[i]);
    for (int i = 0; i < 3; ++i) fibers.tangent.push_back(tangent[i]);
  }
  for (int e = 0; e < elements; ++e) fibers.element_length.push_back((to - from).norm() / elements);
  fibers.first_node.push_back(fibers.first_node.back() + elements + 1);
  fibers.name.push_back(name.empty() ? "fiber/" + std::to_string(fibers.name.size()) : name);
  fibers.group.push_back(group);
}

/// `count` straight fibers with random ends in [low, high]^3.
inline mesh::FiberMeshData random_lines(int count, double low, double high, int elements, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(low, high);
  mesh::FiberMeshData fibers;
  for (int f = 0; f < count; ++f) {
    double x[6];
    for (double& value : x) value = place(random);
    add_line(fibers, Vec3(x[0], x[1], x[2]), Vec3(x[3], x[4], x[5]), elements);
  }
  return fibers;
}

/// Mesh and fibers spread over the ranks of a communicator.
struct Scene {
  Scene(const mesh::HexMeshData& mesh, const mesh::FiberMeshData& fiber_data, MPI_Comm mpi = MPI_COMM_WORLD)
      : comm(mpi), fluid(mesh::distribute(comm, mesh::chunk_of(comm, mesh))) {
    GlobalIndex first_fiber = 0, first_node = 0;
    const mesh::FiberMeshData chunk = mesh::chunk_of(comm, fiber_data, first_fiber, first_node);
    fibers = mesh::distribute(comm, chunk, first_fiber, first_node, &fluid);
  }
  Comm comm;
  mesh::HexMesh fluid;
  mesh::FiberMesh fibers;
};

/// DoFs of every fiber node moved by `displacement` of its reference position; tangents follow by `gradient`,
/// shape=(3,3), of the displacement.
inline std::vector<double> deformed(const mesh::FiberMesh& fibers, const std::function<Vec3(const Vec3&)>& displacement,
                                    const std::function<Mat3(const Vec3&)>& gradient) {
  std::vector<double> dofs;
  for (Index n = 0; n < fibers.nodes(); ++n) {
    const Vec3 x(fibers.position[3 * n], fibers.position[3 * n + 1], fibers.position[3 * n + 2]);
    const Vec3 t(fibers.tangent[3 * n], fibers.tangent[3 * n + 1], fibers.tangent[3 * n + 2]);
    const Vec3 moved = x + displacement(x), turned = t + gradient(x) * t;
    for (int i = 0; i < 3; ++i) dofs.push_back(moved[i]);
    for (int i = 0; i < 3; ++i) dofs.push_back(turned[i]);
  }
  return dofs;
}

inline std::vector<double> moved(const mesh::FiberMesh& fibers, const Vec3& by) {
  return deformed(
      fibers, [by](const Vec3&) { return by; }, [](const Vec3&) { return Mat3::Zero(); });
}

/// An S-shaped deformation of size `amount`.
inline std::vector<double> waved(const mesh::FiberMesh& fibers, double amount) {
  const double k = 5.0;
  return deformed(
      fibers,
      [=](const Vec3& x) {
        return Vec3(amount * std::sin(k * x[1]), amount * std::sin(k * x[2]), amount * std::sin(k * x[0]));
      },
      [=](const Vec3& x) {
        Mat3 g = Mat3::Zero();
        g(0, 1) = amount * k * std::cos(k * x[1]);
        g(1, 2) = amount * k * std::cos(k * x[2]);
        g(2, 0) = amount * k * std::cos(k * x[0]);
        return g;
      });
}

/// Largest |interpolate(field) - D.(field at the fiber)| for the linear field v = a + B x, whose values along the
/// center line are Hermite with nodal (a + B d, B t): both are int Phi v ds. Collective.
inline double linear_field_error(const Scene& scene, const coupling::Coupling& coupling,
                                 const std::vector<double>& dofs) {
  const Vec3 a(0.3, -0.7, 1.1);
  Mat3 b;
  b << 0.5, -0.2, 0.9, 1.3, 0.4, -0.6, -0.8, 0.1, 0.7;
  std::vector<double> nodal(4 * static_cast<std::size_t>(scene.fluid.local_nodes()));
  for (Index n = 0; n < scene.fluid.local_nodes(); ++n) {
    const Vec3 v = a + b * Eigen::Map<const Vec3>(scene.fluid.node(n));
    for (int i = 0; i < 3; ++i) nodal[4 * n + i] = v[i];
  }
  std::vector<double> q(dofs.size());
  for (std::size_t n = 0; n < dofs.size() / 6; ++n) {
    const Vec3 v = a + b * Eigen::Map<const Vec3>(&dofs[6 * n]), w = b * Eigen::Map<const Vec3>(&dofs[6 * n + 3]);
    for (int i = 0; i < 3; ++i) q[6 * n + i] = v[i];
    for (int i = 0; i < 3; ++i) q[6 * n + 3 + i] = w[i];
  }
  std::vector<double> from_fluid(3 * coupling.rows()), from_fiber(3 * coupling.rows());
  coupling.interpolate(nodal.data(), from_fluid.data());
  coupling.apply_d(q, from_fiber.data());
  double largest = 0.0;
  for (std::size_t i = 0; i < from_fluid.size(); ++i)
    largest = std::max(largest, std::abs(from_fluid[i] - from_fiber[i]));
  return scene.comm.max(largest);
}

/// Reference length of all fibers. Collective.
inline double reference_length(const Scene& scene) {
  double sum = 0.0;
  for (const double length : scene.fibers.element_length) sum += length;
  return scene.comm.sum(sum);
}

}  // namespace fbi::test
