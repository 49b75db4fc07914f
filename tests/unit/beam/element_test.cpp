/// Element physics: residual against the energy, tangent against the residual, rigid motion, quadrature, mass.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "beam/formulation.hpp"
#include "beam/loads.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"
#include "record.hpp"

namespace fbi::beam {
namespace {

using Vector = Eigen::Matrix<double, 12, 1>;
using Matrix = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;

const ElementFormulation& torsion_free() { return *element_formulation(Formulation::torsion_free); }

ElementProperties element_properties() {
  ElementProperties element;
  element.length = 0.4;
  element.axial_stiffness = 37.0;
  element.bending_stiffness = 0.9;
  element.mass_per_length = 1.7;
  return element;
}

// A bent, stretched and skew element: far from the reference, no symmetry.
Vector deformed(double amplitude, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  Vector q;
  q << 0, 0, 0, 1, 0, 0, 0.4, 0, 0, 1, 0, 0;
  for (int i = 0; i < 12; ++i) q[i] += amplitude * random(generator) * (i % 6 < 3 ? 0.4 : 1.0);
  return q;
}

// Six-point central difference of f along direction i, error h^6.
template <class Function>
auto difference(const Function& f, const Vector& q, int i, double h) {
  const auto at = [&](double step) {
    Vector moved = q;
    moved[i] += step;
    return f(moved);
  };
  using Result = decltype(at(0.0));
  const Result result =
      (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60.0 * h);
  return result;
}

TEST(TorsionFreeElement, ResidualIsTheFirstVariationOfTheEnergy) {
  const ElementProperties element = element_properties();
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Vector q = deformed(0.5, seed);
    Vector residual, expected;
    torsion_free().internal_force(element, q.data(), residual.data(), nullptr);
    for (int i = 0; i < 12; ++i)
      expected[i] = difference([&](const Vector& x) { return torsion_free().energy(element, x.data()); }, q, i, 2e-3);
    worst = std::max(worst, (residual - expected).norm() / residual.norm());
  }
  std::printf("residual against differences of the energy: %.1e\n", worst);
  fbi::test::record({.section = "Fibers: statics",
                     .check = "residual against differences of the energy",
                     .source = "definition",
                     .reference = 0.0,
                     .ours = worst,
                     .bar = "1e-7"});
  EXPECT_LE(worst, 1e-7);
}

TEST(TorsionFreeElement, TangentIsTheDerivativeOfTheResidual) {
  const ElementProperties element = element_properties();
  double worst = 0.0;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Vector q = deformed(0.5, seed);
    Vector residual;
    Matrix tangent, expected;
    torsion_free().internal_force(element, q.data(), residual.data(), tangent.data());
    const auto force = [&](const Vector& x) {
      Vector r;
      torsion_free().internal_force(element, x.data(), r.data(), nullptr);
      return r;
    };
    for (int i = 0; i < 12; ++i) expected.col(i) = difference(force, q, i, 2e-3);
    worst = std::max(worst, (tangent - expected).norm() / tangent.norm());
    EXPECT_LE((tangent - tangent.transpose()).norm(), 1e-13 * tangent.norm());
  }
  std::printf("tangent against differences of the residual: %.1e\n", worst);
  fbi::test::record({.section = "Fibers: statics",
                     .check = "tangent against differences of the residual",
                     .source = "definition",
                     .reference = 0.0,
                     .ours = worst,
                     .bar = "1e-6"});
  EXPECT_LE(worst, 1e-6);
}

TEST(TorsionFreeElement, EnergyIsTheStatedIntegral) {
  // independent evaluation with |r' x r''| and many Gauss points; axial strain interpolated by hand
  const ElementProperties element = element_properties();
  const Vector q = deformed(0.2, 7);
  const auto derivative = [&](double x, int order) {
    const std::array<double, 4> h = order == 1 ? fem::hermite_first(x) : fem::hermite_second(x);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 4; ++i) sum += h[i] * (i % 2 == 0 ? 1.0 : 0.5 * element.length) * q.segment<3>(3 * i);
    return Vec3(sum * std::pow(2.0 / element.length, order));
  };
  const double left = derivative(-1, 1).norm() - 1, middle = derivative(0, 1).norm() - 1,
               right = derivative(1, 1).norm() - 1;
  const fem::QuadratureRule rule = fem::gauss_legendre(30);
  double axial = 0.0, bending = 0.0;
  for (std::size_t p = 0; p < rule.points.size(); ++p) {
    const double x = rule.points[p], weight = rule.weights[p] * 0.5 * element.length;
    const double strain = 0.5 * x * (x - 1) * left + (1 - x * x) * middle + 0.5 * x * (x + 1) * right;
    const Vec3 t = derivative(x, 1), c = derivative(x, 2);
    axial += weight * 0.5 * element.axial_stiffness * strain * strain;
    bending += weight * 0.5 * element.bending_stiffness * t.cross(c).squaredNorm() / std::pow(t.squaredNorm(), 2);
  }
  ElementProperties one = element;
  one.bending_stiffness = 0.0;
  EXPECT_NEAR(torsion_free().energy(one, q.data()), axial, 1e-13 * axial);
  one.bending_stiffness = element.bending_stiffness;
  one.axial_stiffness = 0.0;
  const double error = std::abs(torsion_free().energy(one, q.data()) / bending - 1);
  std::printf("bending quadrature, strongly bent element: relative error %.1e\n", error);
  EXPECT_LE(error, 5e-3);
}

TEST(TorsionFreeElement, RigidMotionStoresNoEnergy) {
  const ElementProperties element = element_properties();
  const Mat3 rotation = (Eigen::AngleAxisd(2.1, Vec3(1, -2, 0.5).normalized())).toRotationMatrix();
  const Vec3 from(0.3, -1.2, 0.7), along = rotation * Vec3(1, 0, 0);
  Vector q, residual;
  q << from, along, from + element.length * along, along;
  torsion_free().internal_force(element, q.data(), residual.data(), nullptr);
  EXPECT_LE(torsion_free().energy(element, q.data()), 1e-28 * element.axial_stiffness);
  EXPECT_LE(residual.norm(), 1e-13 * element.axial_stiffness);
}

TEST(TorsionFreeElement, EnergyDoesNotSeeRotations) {
  const ElementProperties element = element_properties();
  const Mat3 rotation = (Eigen::AngleAxisd(-1.3, Vec3(0.2, 1, 0.5).normalized())).toRotationMatrix();
  const Vector q = deformed(0.3, 11);
  Vector rotated;
  for (int i = 0; i < 4; ++i) rotated.segment<3>(3 * i) = rotation * q.segment<3>(3 * i);
  const double energy = torsion_free().energy(element, q.data());
  EXPECT_NEAR(torsion_free().energy(element, rotated.data()), energy, 1e-13 * energy);
}

TEST(TorsionFreeElement, MassIsTheIntegralOfTheShapes) {
  const ElementProperties element = element_properties();
  Matrix mass;
  torsion_free().mass(element, mass.data());
  const fem::QuadratureRule rule = fem::gauss_legendre(4);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) {
      double expected = 0.0;
      for (std::size_t p = 0; p < rule.points.size(); ++p) {
        const std::array<double, 4> h = fem::hermite(rule.points[p]);
        const auto scale = [&](int k) { return k % 2 == 0 ? 1.0 : 0.5 * element.length; };
        expected +=
            rule.weights[p] * 0.5 * element.length * element.mass_per_length * h[i] * scale(i) * h[j] * scale(j);
      }
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) EXPECT_NEAR(mass(3 * i + k, 3 * j + l), k == l ? expected : 0.0, 1e-15);
    }
}

TEST(EndMoment, DoesTheWorkOfAMomentOnTheRotationOfTheTangent) {
  const Vec3 moment(0.3, -0.8, 1.1), tangent(0.9, 0.4, -0.5), spin(0.7, 0.2, -0.6);
  // a rigid rotation and a stretch: the work is that of the moment's part normal to the tangent
  const Vec3 change = spin.cross(tangent) + 0.3 * tangent;
  const Vec3 axis = tangent.normalized();
  const Vec3 rotation = spin - spin.dot(axis) * axis;
  EXPECT_NEAR(moment_force(moment, tangent).dot(change), moment.dot(rotation), 1e-14);
}

TEST(EndMoment, TangentIsTheDerivative) {
  const Vec3 moment(0.3, -0.8, 1.1), tangent(0.9, 0.4, -0.5);
  const Mat3 derivative = moment_force_tangent(moment, tangent);
  const double h = 1e-5;
  for (int k = 0; k < 3; ++k) {
    const Vec3 step = h * Vec3::Unit(k);
    const Vec3 expected = (moment_force(moment, tangent + step) - moment_force(moment, tangent - step)) / (2 * h);
    EXPECT_LE((derivative.col(k) - expected).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace fbi::beam
