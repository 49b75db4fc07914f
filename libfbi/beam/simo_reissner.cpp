#include "beam/simo_reissner.hpp"

#include "beam/dual.hpp"
#include "fem/line_shapes.hpp"

namespace fbi::beam {
namespace {

using Matrix = Eigen::Matrix<double, triad_element_dofs, triad_element_dofs, Eigen::RowMajor>;
using Vector = Eigen::Matrix<double, triad_element_dofs, 1>;

constexpr std::array<double, 3> triad_point = {-1.0, 0.0, 1.0};
// int_{-1}^{1} L_c L_d dx of the quadratic Lagrange functions on the triads
constexpr double strain_gram[3][3] = {
    {4.0 / 15, 2.0 / 15, -1.0 / 15}, {2.0 / 15, 16.0 / 15, 2.0 / 15}, {-1.0 / 15, 2.0 / 15, 4.0 / 15}};
// Gauss points for the curvature; their weights are 1
constexpr std::array<double, curvature_points> curvature_point = {-0.5773502691896257, 0.5773502691896257};

// Weights of r' = dr/ds at x for d_1, t_1, d_2, t_2.
std::array<double, 4> first_weights(double x, double length) {
  const std::array<double, 4> h = fem::hermite_first(x);
  const double scale = 2.0 / length;
  return {scale * h[0], h[1], scale * h[2], h[3]};
}

Vec3 combine(const std::array<double, 4>& weights, const double* q) {
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < 4; ++i) sum += weights[i] * Vec3(q + 3 * i);
  return sum;
}

// Lambda^T r' at triad c.
Vec3 stretch(double length, const double* q, const std::array<Quaternion, 3>& triads, int c) {
  return triads[c].conjugate() * combine(first_weights(triad_point[c], length), q);
}

// Rotation vectors from the middle triad to those at the ends.
std::array<Vec3, 2> relative_rotations(const std::array<Quaternion, 3>& triads) {
  return {logarithm(triads[1].conjugate() * triads[0]), logarithm(triads[1].conjugate() * triads[2])};
}

template <class T>
using Vector3 = std::array<T, 3>;

template <class T>
Vector3<T> cross(const Vector3<T>& a, const Vector3<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
T dot(const Vector3<T>& a, const Vector3<T>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T, class S>
void add(Vector3<T>& a, const S& factor, const Vector3<T>& b) {
  for (int k = 0; k < 3; ++k) a[k] = a[k] + factor * b[k];
}
template <class T>
T coefficient(RotationCoefficient (*function)(double), const T& s) {
  const RotationCoefficient c = function(value_of(s));
  return apply(c.value, c.slope, s);
}

// psi, psi' = d psi/ds and K = psi' - b psi x psi' + c psi x (psi x psi') at one point.
template <class T>
struct Curvature {
  Vector3<T> psi, slope, first, second;  // first = psi x psi', second = psi x first
  T s, b, c;
  Vector3<T> value;

  Curvature(double x, double length, const std::array<Vector3<T>, 2>& ends) {
    const double n[2] = {0.5 * x * (x - 1), 0.5 * x * (x + 1)};
    const double dn[2] = {(2 * x - 1) / length, (2 * x + 1) / length};
    psi = slope = {T(0.0), T(0.0), T(0.0)};
    for (int i = 0; i < 2; ++i) {
      add(psi, n[i], ends[i]);
      add(slope, dn[i], ends[i]);
    }
    first = cross(psi, slope);
    second = cross(psi, first);
    s = dot(psi, psi);
    b = coefficient(coefficient_b, s);
    c = coefficient(coefficient_c, s);
    value = slope;
    add(value, T(-1.0) * b, first);
    add(value, c, second);
  }
};

// Forces on psi_1 and psi_2: the derivatives of the bending and torsion energy by them.
template <class T>
std::array<Vector3<T>, 2> bending_forces(const TriadSection& section, const TriadElement& element,
                                         const std::array<Vector3<T>, 2>& ends) {
  std::array<Vector3<T>, 2> force;
  for (Vector3<T>& f : force) f = {T(0.0), T(0.0), T(0.0)};
  for (int p = 0; p < curvature_points; ++p) {
    const double x = curvature_point[p], weight = 0.5 * element.length;
    const Curvature<T> k(x, element.length, ends);
    Vector3<T> m;
    for (int i = 0; i < 3; ++i) m[i] = (weight * section.moment[i]) * (k.value[i] - T(element.curvature[p][i]));
    const Vector3<T> turned = cross(k.psi, m);
    // m . dK/dpsi' and m . dK/dpsi
    Vector3<T> by_slope = m, by_psi = {T(0.0), T(0.0), T(0.0)};
    add(by_slope, k.b, turned);
    add(by_slope, k.c, cross(k.psi, turned));
    add(by_psi,
        2.0 *
            (coefficient(coefficient_dc, k.s) * dot(m, k.second) - coefficient(coefficient_db, k.s) * dot(m, k.first)),
        k.psi);
    add(by_psi, T(-1.0) * k.b, cross(k.slope, m));
    add(by_psi, k.c, cross(k.first, m));
    add(by_psi, T(-1.0) * k.c, cross(k.slope, turned));
    const double n[2] = {0.5 * x * (x - 1), 0.5 * x * (x + 1)};
    const double dn[2] = {(2 * x - 1) / element.length, (2 * x + 1) / element.length};
    for (int i = 0; i < 2; ++i) {
      add(force[i], n[i], by_psi);
      add(force[i], dn[i], by_slope);
    }
  }
  return force;
}

// Moments on the triads 1, m, 2: the forces above through d psi_i = T^-1(psi_i) a_i - T^-1(-psi_i) a_m.
template <class T>
std::array<Vector3<T>, 3> bending_moments(const TriadSection& section, const TriadElement& element,
                                          const std::array<Vector3<T>, 2>& ends) {
  const std::array<Vector3<T>, 2> force = bending_forces(section, element, ends);
  std::array<Vector3<T>, 3> moment;
  moment[1] = {T(0.0), T(0.0), T(0.0)};
  for (int i = 0; i < 2; ++i) {
    const Vector3<T> once = cross(ends[i], force[i]);
    Vector3<T> even = force[i];
    add(even, coefficient(coefficient_e, dot(ends[i], ends[i])), cross(ends[i], once));
    Vector3<T>& end = moment[2 * i];
    end = even;
    add(end, -0.5, once);
    add(moment[1], -1.0, even);
    add(moment[1], -0.5, once);
  }
  return moment;
}

void add_bending(const TriadSection& section, const TriadElement& element, const std::array<Quaternion, 3>& triads,
                 Eigen::Ref<Vector> residual, double* tangent) {
  const std::array<Vec3, 2> psi = relative_rotations(triads);
  if (tangent == nullptr) {
    std::array<Vector3<double>, 2> ends;
    for (int i = 0; i < 2; ++i) ends[i] = {psi[i][0], psi[i][1], psi[i][2]};
    const std::array<Vector3<double>, 3> moment = bending_moments(section, element, ends);
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) residual[triad_place[c] + k] += moment[c][k];
    return;
  }
  using Number = Dual<6>;
  std::array<Vector3<Number>, 2> ends;
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 3; ++k) ends[i][k] = Number::variable(psi[i][k], 3 * i + k);
  const std::array<Vector3<Number>, 3> moment = bending_moments(section, element, ends);
  const Mat3 end[2] = {inverse_tangent_map(psi[0]), inverse_tangent_map(psi[1])};
  const Mat3 middle[2] = {-inverse_tangent_map(-psi[0]), -inverse_tangent_map(-psi[1])};
  Eigen::Map<Matrix> matrix(tangent);
  for (int c = 0; c < 3; ++c) {
    Mat3 by_psi[2];
    for (int k = 0; k < 3; ++k) {
      residual[triad_place[c] + k] += moment[c][k].value;
      for (int i = 0; i < 2; ++i) by_psi[i].row(k) = moment[c][k].slope.segment<3>(3 * i).matrix().transpose();
    }
    for (int i = 0; i < 2; ++i) {
      matrix.block<3, 3>(triad_place[c], triad_place[2 * i]) += by_psi[i] * end[i];
      matrix.block<3, 3>(triad_place[c], triad_place[1]) += by_psi[i] * middle[i];
    }
  }
}

// n_c = C_F int L_c Gamma ds at the triads.
std::array<Vec3, 3> section_forces(const TriadSection& section, const TriadElement& element,
                                   const std::array<Vec3, 3>& stretches) {
  std::array<Vec3, 3> n;
  for (int c = 0; c < 3; ++c) {
    n[c].setZero();
    for (int d = 0; d < 3; ++d)
      n[c] += (0.5 * element.length * strain_gram[c][d]) * section.force.cwiseProduct(stretches[d] - element.strain[d]);
  }
  return n;
}

}  // namespace

TriadSection::TriadSection(const Section& section, const Material& material) {
  const double shear = section.shear_correction * material.shear_modulus * section.area;
  force = {material.young * section.area, shear, shear};
  moment = {material.shear_modulus * section.torsion, material.young * section.inertia_2,
            material.young * section.inertia_3};
  rotary = material.density * Vec3(section.inertia_2 + section.inertia_3, section.inertia_2, section.inertia_3);
}

TriadElement::TriadElement(double element_length, const double* q, const std::array<Quaternion, 3>& triads)
    : length(element_length) {
  for (int c = 0; c < 3; ++c) strain[c] = stretch(length, q, triads, c);
  const std::array<Vec3, 2> psi = relative_rotations(triads);
  std::array<Vector3<double>, 2> ends;
  for (int i = 0; i < 2; ++i) ends[i] = {psi[i][0], psi[i][1], psi[i][2]};
  for (int p = 0; p < curvature_points; ++p) {
    const Curvature<double> k(curvature_point[p], length, ends);
    curvature[p] = {k.value[0], k.value[1], k.value[2]};
  }
}

double triad_energy(const TriadSection& section, const TriadElement& element, const double* q,
                    const std::array<Quaternion, 3>& triads) {
  std::array<Vec3, 3> stretches;
  for (int c = 0; c < 3; ++c) stretches[c] = stretch(element.length, q, triads, c);
  const std::array<Vec3, 3> n = section_forces(section, element, stretches);
  const TriadElement now(element.length, q, triads);
  double energy = 0.0;
  for (int c = 0; c < 3; ++c) energy += 0.5 * n[c].dot(stretches[c] - element.strain[c]);
  for (int p = 0; p < curvature_points; ++p) {
    const Vec3 change = now.curvature[p] - element.curvature[p];
    energy += 0.25 * element.length * change.dot(section.moment.cwiseProduct(change));
  }
  return energy;
}

void triad_internal_force(const TriadSection& section, const TriadElement& element, const double* q,
                          const std::array<Quaternion, 3>& triads, double* residual, double* tangent) {
  Eigen::Map<Vector> r(residual);
  r.setZero();
  std::array<Vec3, 3> stretches;
  std::array<Mat3, 3> rotation;
  std::array<std::array<double, 4>, 3> weights;
  for (int c = 0; c < 3; ++c) {
    stretches[c] = stretch(element.length, q, triads, c);
    rotation[c] = triads[c].toRotationMatrix();
    weights[c] = first_weights(triad_point[c], element.length);
  }
  const std::array<Vec3, 3> n = section_forces(section, element, stretches);
  for (int c = 0; c < 3; ++c) {
    const Vec3 force = rotation[c] * n[c];
    for (int i = 0; i < 4; ++i) r.segment<3>(center_line_place[i]) += weights[c][i] * force;
    r.segment<3>(triad_place[c]) += n[c].cross(stretches[c]);
  }
  if (tangent != nullptr) {
    Eigen::Map<Matrix> k(tangent);
    k.setZero();
    // change of the strain: Lambda^T delta r' + stretch x a
    std::array<Eigen::Matrix<double, 3, triad_element_dofs>, 3> change;
    for (int c = 0; c < 3; ++c) {
      change[c].setZero();
      for (int i = 0; i < 4; ++i)
        change[c].block<3, 3>(0, center_line_place[i]) = weights[c][i] * rotation[c].transpose();
      change[c].block<3, 3>(0, triad_place[c]) = hat(stretches[c]);
    }
    for (int c = 0; c < 3; ++c) {
      Eigen::Matrix<double, 3, triad_element_dofs> force_change;  // of n_c
      force_change.setZero();
      for (int d = 0; d < 3; ++d)
        force_change += (0.5 * element.length * strain_gram[c][d]) * (section.force.asDiagonal() * change[d]);
      k.noalias() += change[c].transpose() * force_change;
      const Mat3 skew = hat(n[c]);
      for (int i = 0; i < 4; ++i) {
        const Mat3 block = -weights[c][i] * rotation[c] * skew;
        k.block<3, 3>(center_line_place[i], triad_place[c]) += block;
        k.block<3, 3>(triad_place[c], center_line_place[i]) += block.transpose();
      }
      k.block<3, 3>(triad_place[c], triad_place[c]) += skew * hat(stretches[c]);
    }
  }
  add_bending(section, element, triads, r, tangent);
}

}  // namespace fbi::beam
