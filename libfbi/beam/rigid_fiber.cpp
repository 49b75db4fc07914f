#include "beam/rigid_fiber.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::beam {
namespace {

bool is_held(EndCondition support) { return support == EndCondition::pinned || support == EndCondition::clamped; }

Vec3 load3(const double* x) { return {x[0], x[1], x[2]}; }
void store3(const Vec3& value, double* x) {
  for (int k = 0; k < 3; ++k) x[k] = value[k];
}

// T^T T of the twist of a pose with rotation R, its (pseudo-)inverse applied to x: spin about a straight fiber moves
// nothing.
Vector6 least_squares(const std::vector<Vec3>& offset, const Mat3& rotation, const Vector6& x) {
  Matrix6 normal = Matrix6::Zero();
  for (std::size_t i = 0; i < offset.size(); ++i) {
    Eigen::Matrix<double, 3, 6> t;
    t.leftCols<3>() = i % 2 == 0 ? Mat3(Mat3::Identity()) : Mat3(Mat3::Zero());
    t.rightCols<3>() = -rotation * skew_matrix(offset[i]);
    normal += t.transpose() * t;
  }
  const Eigen::SelfAdjointEigenSolver<Matrix6> modes(normal);
  Vector6 y = modes.eigenvectors().transpose() * x;
  const double smallest = 1e-10 * modes.eigenvalues()[5];
  for (int k = 0; k < 6; ++k) y[k] = modes.eigenvalues()[k] > smallest ? y[k] / modes.eigenvalues()[k] : 0.0;
  return modes.eigenvectors() * y;
}

}  // namespace

RigidFiber::RigidFiber(const std::vector<double>& dofs, const std::vector<double>& element_length,
                       double mass_per_length, double section_inertia, const std::vector<NodeSupport>& supports)
    : active(true), offset(dofs.size() / 3) {
  for (std::size_t i = 0; i < offset.size(); ++i) offset[i] = load3(&dofs[3 * i]);
  const NodeSupport* held = supports.empty() ? nullptr : &supports.front();
  if (held != nullptr) {
    support = held->constraint.position ? (held->constraint.direction ? EndCondition::clamped : EndCondition::pinned)
                                        : EndCondition::guided;
    guide = held->constraint.axis;
    reference = offset[2 * static_cast<std::size_t>(held->node)];
  }
  // Integrals of the Hermite line: consistent mass of an element, as scalars for d_1, t_1, d_2, t_2.
  for (int pass = 0; pass < 2; ++pass) {
    mass = 0.0;
    first_moment.setZero();
    inertia.setZero();
    for (std::size_t e = 0; e < element_length.size(); ++e) {
      const double l = element_length[e], scale = mass_per_length * l / 420.0;
      const double scalar[4][4] = {{156, 22 * l, 54, -13 * l},
                                   {22 * l, 4 * l * l, 13 * l, -3 * l * l},
                                   {54, 13 * l, 156, -22 * l},
                                   {-13 * l, -3 * l * l, -22 * l, 4 * l * l}};
      Vec3 r[4];
      for (int i = 0; i < 4; ++i) r[i] = offset[2 * e + i] - (i % 2 == 0 ? reference : Vec3(Vec3::Zero()));
      for (int i = 0; i < 4; ++i) {
        // mass of the function against 1: positions of a unit translation are 1, tangents 0
        first_moment += scale * (scalar[i][0] + scalar[i][2]) * r[i];
        for (int j = 0; j < 4; ++j)
          inertia += scale * scalar[i][j] * (r[i].dot(r[j]) * Mat3::Identity() - r[j] * r[i].transpose());
      }
      mass += mass_per_length * l;
      const Vec3 tangent = (0.5 * (offset[2 * e + 1] + offset[2 * e + 3])).normalized();
      inertia += section_inertia * l * (Mat3::Identity() + tangent * tangent.transpose());
    }
    if (held != nullptr || pass == 1) break;
    reference = first_moment / mass;
  }
  if (held == nullptr) first_moment.setZero();  // round-off
  for (std::size_t i = 0; i < offset.size(); i += 2) offset[i] -= reference;
  last.point = reference;
  now = last;
  update_basis();
}

void RigidFiber::update_basis() {
  const Matrix6 all = Matrix6::Identity();
  if (support == EndCondition::free) basis = all;
  if (support == EndCondition::pinned) basis = all.rightCols<3>();
  if (support == EndCondition::clamped) basis.resize(6, 0);
  if (support == EndCondition::guided) {
    int least = 0;
    guide.cwiseAbs().minCoeff(&least);
    const Vec3 across = guide.cross(Vec3::Unit(least)).normalized();
    basis.setZero(6, 2);
    basis.col(0).head<3>() = across;
    basis.col(1).head<3>() = guide.cross(across);
  }
}

Vector6 RigidFiber::wrench(const double* force, const Mat3& rotation) const {
  Vector6 sum = Vector6::Zero();
  for (std::size_t i = 0; i < offset.size(); ++i) {
    const Vec3 f = load3(force + 3 * i);
    if (i % 2 == 0) sum.head<3>() += f;
    sum.tail<3>() += offset[i].cross(rotation.transpose() * f);
  }
  return sum;
}

void RigidFiber::spread(const Vector6& wrench, double* force) const {
  const Vector6 y = least_squares(offset, middle, wrench);
  for (std::size_t i = 0; i < offset.size(); ++i) {
    Vec3 f = middle * Vec3(y.tail<3>()).cross(offset[i]);
    if (i % 2 == 0) f += y.head<3>();
    store3(f, force + 3 * i);
  }
}

void RigidFiber::project(double* force) const {
  const Vector6 w = wrench(force, middle);
  spread(basis * (basis.transpose() * w), force);
}

void RigidFiber::move(const Vector6& twist, double* increment) const {
  for (std::size_t i = 0; i < offset.size(); ++i) {
    Vec3 d = now.rotation * Vec3(twist.tail<3>()).cross(offset[i]);
    if (i % 2 == 0) d += twist.head<3>();
    store3(d, increment + 3 * i);
  }
}

Vector6 RigidFiber::twist_of(const double* increment) const {
  return basis * (basis.transpose() * least_squares(offset, now.rotation, wrench(increment, now.rotation)));
}

void RigidFiber::set_velocity(double* velocity) {
  now = last;
  const Vector6 twist = twist_of(velocity);
  last.velocity = twist.head<3>();
  last.spin = twist.tail<3>();
  now = last;
  move(twist, velocity);
}

Vector6 RigidFiber::balance(const State& state, const double* external, const Vec3& couple) const {
  Vector6 b = wrench(external, state.rotation);
  b.head<3>() -= state.rotation * state.spin.cross(state.spin.cross(first_moment));
  b.tail<3>() += couple - state.spin.cross(inertia * state.spin);
  if (is_held(support)) {
    b.head<3>() -= mass * state.acceleration;
    b.tail<3>() -= first_moment.cross(state.rotation.transpose() * state.acceleration);
  }
  return b;
}

void RigidFiber::begin_step(const GeneralizedAlpha& scheme, double dt, const NodeSupport* held) {
  now = last;
  psi.setZero();
  const double half = 0.5 - scheme.beta;  // of the acceleration kept: that of the end is taken as zero
  if (!is_held(support)) now.point += dt * last.velocity + dt * dt * half * last.acceleration;
  if (support == EndCondition::free || support == EndCondition::pinned) {
    psi = dt * last.spin + dt * dt * half * last.spin_rate;
    now.rotation = last.rotation * rotation_matrix(psi);
  }
  update_rates(scheme, dt, held);
}

void RigidFiber::update_rates(const GeneralizedAlpha& scheme, double dt, const NodeSupport* held) {
  for (int k = 0; k < 3; ++k) {
    now.spin[k] = scheme.velocity(psi[k], last.spin[k], last.spin_rate[k], dt);
    now.spin_rate[k] = scheme.acceleration(psi[k], last.spin[k], last.spin_rate[k], dt);
    if (is_held(support)) continue;
    const double change = now.point[k] - last.point[k];
    now.velocity[k] = scheme.velocity(change, last.velocity[k], last.acceleration[k], dt);
    now.acceleration[k] = scheme.acceleration(change, last.velocity[k], last.acceleration[k], dt);
  }
  if (is_held(support) && held != nullptr && held->motion) {
    now.point = held->reference + held->position.value;
    now.velocity = held->position.rate;
    now.acceleration = held->position.acceleration;
  }
  if (basis.cols() == 0 || support == EndCondition::guided) now.spin.setZero(), now.spin_rate.setZero();
  middle = last.rotation * rotation_matrix((1 - scheme.alpha_f) * psi);
}

void RigidFiber::turn_by(const Vector6& twist, double factor) {
  if (!is_held(support)) now.point += factor * twist.head<3>();
  if (support == EndCondition::guided || support == EndCondition::clamped) return;
  now.rotation = now.rotation * rotation_matrix(factor * twist.tail<3>());
  psi = rotation_vector(last.rotation.transpose() * now.rotation);
}

void RigidFiber::evaluate(const GeneralizedAlpha& scheme, double dt, const double* external, const Vec3& couple,
                          bool with_tangent) {
  const auto inertial = [&](const State& state) {
    Vector6 f;
    f.head<3>() = state.rotation * state.spin_rate.cross(first_moment);
    f.tail<3>() = inertia * state.spin_rate;
    if (!is_held(support)) {
      f.head<3>() += mass * state.acceleration;
      f.tail<3>() += first_moment.cross(state.rotation.transpose() * state.acceleration);
    }
    return f;
  };
  residual = (1 - scheme.alpha_m) * inertial(now) + scheme.alpha_m * inertial(last) -
             (1 - scheme.alpha_f) * balance(now, external, couple) - scheme.alpha_f * wrench_n;
  if (!with_tangent) return;
  const double acceleration = scheme.inertia_per_displacement(dt), velocity = scheme.velocity_per_displacement(dt);
  tangent.setZero();
  tangent.topLeftCorner<3, 3>() = acceleration * mass * Mat3::Identity();
  const Vec3 momentum = inertia * now.spin;
  Mat3 turning = (acceleration * inertia +
                  (1 - scheme.alpha_f) * velocity * (skew_matrix(now.spin) * inertia - skew_matrix(momentum))) *
                 right_tangent_inverse(psi);
  Mat3 stiffness = Mat3::Zero();  // d(external torque)/d(turn)
  for (std::size_t i = 0; i < offset.size(); ++i)
    stiffness += skew_matrix(offset[i]) * skew_matrix(now.rotation.transpose() * load3(external + 3 * i));
  if (is_held(support))
    stiffness -= skew_matrix(first_moment) * skew_matrix(now.rotation.transpose() * now.acceleration);
  tangent.bottomRightCorner<3, 3>() = turning - (1 - scheme.alpha_f) * stiffness;
}

bool RigidFiber::factorize() {
  if (basis.cols() == 0) return true;
  const Eigen::MatrixXd reduced = basis.transpose() * tangent * basis;
  if (!reduced.allFinite()) return false;
  factors.compute(reduced);
  return factors.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0;
}

void RigidFiber::solve(double* b, Index columns) const {
  const std::size_t rows = 3 * offset.size();
  std::vector<double> column(rows);
  for (Index c = 0; c < columns; ++c) {
    for (std::size_t i = 0; i < rows; ++i) column[i] = b[i * columns + c];
    Vector6 twist = Vector6::Zero();
    if (basis.cols() > 0) twist = basis * factors.solve(basis.transpose() * wrench(column.data(), middle));
    move(twist, column.data());
    for (std::size_t i = 0; i < rows; ++i) b[i * columns + c] = column[i];
  }
}

void RigidFiber::fill(const State& state, double* dofs, double* velocity, double* acceleration) const {
  for (std::size_t i = 0; i < offset.size(); ++i) {
    Vec3 d = state.rotation * offset[i], v = state.rotation * state.spin.cross(offset[i]),
         a = state.rotation * (state.spin_rate.cross(offset[i]) + state.spin.cross(state.spin.cross(offset[i])));
    if (i % 2 == 0) {
      d += state.point;
      v += state.velocity;
      a += state.acceleration;
    }
    store3(d, dofs + 3 * i);
    store3(v, velocity + 3 * i);
    store3(a, acceleration + 3 * i);
  }
}

double RigidFiber::kinetic_energy(const State& state) const {
  return 0.5 * mass * state.velocity.squaredNorm() +
         state.velocity.dot(state.rotation * state.spin.cross(first_moment)) +
         0.5 * state.spin.dot(inertia * state.spin);
}

void RigidFiber::balance_at_start(const double* external, const Vec3& couple, const NodeSupport* held) {
  if (is_held(support) && held != nullptr && held->motion) {
    last.velocity = held->position_n.rate;
    last.acceleration = held->position_n.acceleration;
  }
  const Vector6 b = balance(last, external, couple);
  if (support == EndCondition::free || support == EndCondition::pinned)
    last.spin_rate = inertia.ldlt().solve(b.tail<3>());
  if (support == EndCondition::free) last.acceleration = b.head<3>() / mass;
  if (support == EndCondition::guided) {
    const Vec3 f = b.head<3>();
    last.acceleration = (f - f.dot(guide) * guide) / mass;
  }
  now = last;
}

void RigidFiber::store(const State& state, double* pose, double* motion) const {
  std::copy_n(state.rotation.data(), 9, pose);
  store3(state.point, pose + 9);
  store3(state.spin, motion);
  store3(state.spin_rate, motion + 3);
  store3(state.velocity, motion + 6);
  store3(state.acceleration, motion + 9);
}

RigidFiber::State RigidFiber::restore(const double* pose, const double* motion) const {
  State state;
  std::copy_n(pose, 9, state.rotation.data());
  state.point = load3(pose + 9);
  state.spin = load3(motion);
  state.spin_rate = load3(motion + 3);
  state.velocity = load3(motion + 6);
  state.acceleration = load3(motion + 9);
  return state;
}

}  // namespace fbi::beam
