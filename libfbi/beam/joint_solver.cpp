#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "beam/joint_group.hpp"

namespace fbi::beam {
namespace {

Mat3 skew(const Vec3& a) {
  Mat3 s;
  s << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return s;
}

}  // namespace

void Joints::Group::count() {
  Index size = first_rigid();
  for (const RigidJoint& joint : rigid) size += 2 * static_cast<Index>(joint.members.size()) + 3;
  multiplier = Eigen::VectorXd::Zero(size);
  found = multiplier;
}

// The turn that takes the reference tangents of two members to the present ones, or the smallest one for parallel
// members, whose turn about their axis does not matter.
void Joints::Group::fit(const NodalField& dofs, bool at_start) {
  const auto frame = [](const Vec3& a, const Vec3& b) {
    Mat3 m;
    m.col(0) = a.normalized();
    m.col(2) = a.cross(b).normalized();
    m.col(1) = m.col(2).cross(m.col(0));
    return m;
  };
  for (RigidJoint& joint : rigid) {
    const Member& first = joint.members[0];
    const Vec3 t = nodal_vector(dofs, first.place.node, 1);
    if (joint.second >= 0) {
      const Member& second = joint.members[joint.second];
      joint.turn = frame(t, nodal_vector(dofs, second.place.node, 1)) * frame(first.axis, second.axis).transpose();
    } else {
      joint.turn = Eigen::Quaterniond::FromTwoVectors(first.axis, t).toRotationMatrix();
    }
    if (at_start) joint.turn_n = joint.turn;
  }
}

// Forces of the joints on the group's fibers, to be added to the internal ones.
Eigen::VectorXd Joints::Group::joint_forces(const FiberEquations& equations) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(offset.back());
  const Level& level = equations.level;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    const Vec3 mu = multiplier.segment<3>(3 * static_cast<Index>(p));
    force.segment<3>(offset[pair.a.fiber] + pair.a.dof + 3 * pair.part) += mu;
    force.segment<3>(offset[pair.b.fiber] + pair.b.dof + 3 * pair.part) -= pair.sign * mu;
  }
  Index y = first_rigid();
  for (const RigidJoint& joint : rigid) {
    for (const Member& member : joint.members)
      for (const Vec3& normal : member.normal)
        force.segment<3>(offset[member.place.fiber] + member.place.dof + 3) +=
            multiplier[y++] * (level.internal * (joint.turn * normal) + level.previous * (joint.turn_n * normal));
    y += 3;
  }
  return force;
}

// L, F, Q and c at the iterate.
void Joints::Group::linearize(const FiberEquations& equations, bool with_springs) {
  const Index springs_at = size();
  Index total = springs_at;
  if (with_springs) total += 3 * static_cast<Index>(springs[0].size() + springs[1].size());
  q = Eigen::MatrixXd::Zero(total, total);
  gap = Eigen::VectorXd::Zero(total);
  terms.clear();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    const Index y = 3 * static_cast<Index>(p);
    gap.segment<3>(y) = nodal_vector(equations.dofs, pair.a.node, pair.part) -
                        pair.sign * nodal_vector(equations.dofs, pair.b.node, pair.part) - pair.rest;
    for (int k = 0; k < 3; ++k) {
      terms.push_back({pair.a.fiber, pair.a.dof + 3 * pair.part + k, y + k, 1.0, 1.0});
      terms.push_back({pair.b.fiber, pair.b.dof + 3 * pair.part + k, y + k, -pair.sign, -pair.sign});
    }
  }
  const double now = equations.level.internal, before = equations.level.previous;
  Index y = first_rigid();
  for (const RigidJoint& joint : rigid) {
    const Index turn = y + 2 * static_cast<Index>(joint.members.size());
    double size_of_couples = 0.0;
    for (const Member& member : joint.members) {
      const Vec3 t = nodal_vector(equations.dofs, member.place.node, 1);
      const Vec3 t_n = nodal_vector(equations.dofs_n, member.place.node, 1);
      for (const Vec3& normal : member.normal) {
        const Vec3 u = joint.turn * normal, u_n = joint.turn_n * normal;
        const Vec3 direction = now * u + before * u_n, arm = now * u.cross(t) + before * u_n.cross(t_n);
        const double mu = multiplier[y];
        gap[y] = u.dot(t);
        gap.segment<3>(turn) += mu * arm;
        q.block<1, 3>(y, turn) = u.cross(t).transpose();
        q.block<3, 1>(turn, y) = arm;
        q.block<3, 3>(turn, turn) += now * mu * (u * t.transpose() - t.dot(u) * Mat3::Identity());
        size_of_couples = std::max(size_of_couples, std::abs(mu));
        const Mat3 couple = now * mu * skew(u);
        for (int k = 0; k < 3; ++k) {
          const Index dof = member.place.dof + 3 + k;
          terms.push_back({member.place.fiber, dof, y, u[k], direction[k]});
          for (int j = 0; j < 3; ++j) terms.push_back({member.place.fiber, dof, turn + j, couple(j, k), -couple(k, j)});
        }
        ++y;
      }
    }
    if (joint.second < 0) {  // nothing turns about the common axis: its turn is held
      const Vec3 axis = joint.turn * joint.members[0].axis;
      q.block<3, 3>(turn, turn) += std::max(size_of_couples, 1.0) * axis * axis.transpose();
    }
    y += 3;
  }
  if (!with_springs) return;
  for (int part = 0; part < 2; ++part)
    for (const Place& place : springs[part]) {
      const double stiffness = equations.joint_spring(fibers[place.fiber], part);
      for (int k = 0; k < 3; ++k, ++y) {
        terms.push_back({place.fiber, place.dof + 3 * part + k, y, -stiffness, -stiffness});
        q(y, y) = stiffness;
      }
    }
}

Index Joints::groups() const { return static_cast<Index>(groups_.size()); }
Index Joints::unknowns(Index group) const { return groups_[group].size(); }
Index Joints::dofs(Index group) const { return groups_[group].offset.back(); }

std::vector<double> Joints::gather(Index g, const NodalField& field) const {
  const Group& group = groups_[g];
  std::vector<double> values(group.offset.back());
  for (std::size_t i = 0; i < group.fibers.size(); ++i)
    std::copy_n(&field[group.first_dof[i]], group.offset[i + 1] - group.offset[i], &values[group.offset[i]]);
  return values;
}

void Joints::scatter(Index g, const std::vector<double>& values, NodalField& field) const {
  const Group& group = groups_[g];
  for (std::size_t i = 0; i < group.fibers.size(); ++i)
    std::copy_n(&values[group.offset[i]], group.offset[i + 1] - group.offset[i], &field[group.first_dof[i]]);
}

void Joints::begin_step(const FiberEquations& equations) {
  for (Index g = 0; g < groups(); ++g) begin_step(equations, g);
}

void Joints::begin_step(const FiberEquations& equations, Index g) {
  Group& group = groups_[g];
  group.multiplier.setZero();
  group.found.setZero(group.size());
  group.fit(equations.dofs_n, true);
}

void Joints::fit(const FiberEquations& equations, Index group) { groups_[group].fit(equations.dofs, false); }

void Joints::add_forces(FiberEquations& equations, Index g) const {
  const Group& group = groups_[g];
  const Eigen::VectorXd force = group.joint_forces(equations);
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Fiber& fiber = equations.fibers[group.fibers[i]];
    if (fiber.formulation == nullptr) continue;
    for (Index k = 0; k < fiber.dofs(); ++k) {
      equations.full[group.first_dof[i] + k] += force[group.offset[i] + k];
      equations.residual[group.first_dof[i] + k] += force[group.offset[i] + k];
    }
    fiber.project(&equations.residual[group.first_dof[i]]);
  }
}

void Joints::add_springs(FiberEquations& equations, Index g) const {
  const Group& group = groups_[g];
  if (equations.parameters.scheme != TimeScheme::static_) return;
  for (int part = 0; part < 2; ++part)
    for (const Place& place : group.springs[part])
      for (int k = 0; k < 3; ++k)
        equations.add_to_diagonal(group.fibers[place.fiber], place.dof + 3 * part + k,
                                  equations.joint_spring(group.fibers[place.fiber], part));
}

bool Joints::factorize(const FiberEquations& equations, Index g) {
  Group& group = groups_[g];
  group.linearize(equations, equations.parameters.scheme == TimeScheme::static_);
  const std::size_t count = group.fibers.size();
  group.touched.assign(count, {});
  group.x.resize(count);
  for (const Term& term : group.terms) group.touched[term.fiber].push_back(term.y);
  std::vector<Index> column(group.q.rows());
  Eigen::MatrixXd schur = -group.q;
  std::stable_sort(group.terms.begin(), group.terms.end(),
                   [](const Term& a, const Term& b) { return a.fiber < b.fiber; });
  std::size_t begin = 0;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Index>& touched = group.touched[i];
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
    const Index f = group.fibers[i], columns = static_cast<Index>(touched.size());
    for (Index c = 0; c < columns; ++c) column[touched[c]] = c;
    std::size_t end = begin;
    while (end < group.terms.size() && group.terms[end].fiber == static_cast<Index>(i)) ++end;
    GroupMatrix& x = group.x[i];
    x = GroupMatrix::Zero(equations.fibers[f].dofs(), columns);
    if (equations.fibers[f].formulation != nullptr) {
      for (std::size_t t = begin; t < end; ++t) x(group.terms[t].dof, column[group.terms[t].y]) += group.terms[t].right;
      equations.solve(f, x.data(), columns);
      for (std::size_t t = begin; t < end; ++t)
        for (Index c = 0; c < columns; ++c)
          schur(group.terms[t].y, touched[c]) += group.terms[t].left * x(group.terms[t].dof, c);
    }
    begin = end;
  }
  for (Index k = 0; k < schur.size(); ++k)
    if (!std::isfinite(schur.data()[k])) return false;
  if (schur.size() == 0) return true;
  group.schur.compute(schur);
  return group.schur.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0;
}

void Joints::solve(const FiberEquations& equations, Index g, std::vector<double>& b) {
  Group& group = groups_[g];
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Index f = group.fibers[i];
    double* part = &b[group.offset[i]];
    if (equations.fibers[f].formulation == nullptr)
      std::fill_n(part, equations.fibers[f].dofs(), 0.0);
    else
      equations.solve(f, part, 1);
  }
  if (group.gap.size() == 0) return;
  Eigen::VectorXd y = group.gap;
  for (const Term& term : group.terms) y[term.y] += term.left * b[group.offset[term.fiber] + term.dof];
  for (Index k = 0; k < y.size(); ++k)
    if (!std::isfinite(y[k])) {
      std::fill(b.begin(), b.end(), std::numeric_limits<double>::quiet_NaN());
      return;
    }
  y = group.schur.solve(y).eval();
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const std::vector<Index>& touched = group.touched[i];
    for (Index d = 0; d < group.x[i].rows(); ++d)
      for (std::size_t c = 0; c < touched.size(); ++c)
        b[group.offset[i] + d] -= group.x[i](d, static_cast<Index>(c)) * y[touched[c]];
  }
  group.found = y.head(group.size());
}

void Joints::advance(Index g, double factor) {
  Group& group = groups_[g];
  Index y = group.first_rigid();
  group.multiplier.head(y) += factor * group.found.head(y);
  for (RigidJoint& joint : group.rigid) {
    for (std::size_t k = 0; k < 2 * joint.members.size(); ++k, ++y) group.multiplier[y] += factor * group.found[y];
    const Vec3 turn = factor * group.found.segment<3>(y);
    const double angle = turn.norm();
    if (angle > 0.0) joint.turn = Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix() * joint.turn;
    y += 3;
  }
  group.found.setZero();
}

void Joints::compliance(const FiberEquations& equations, Index g, const std::vector<const double*>& d,
                        const std::vector<Index>& rows, GroupMatrix& block) const {
  const Group& group = groups_[g];
  Index total = 0;
  std::vector<Index> first;
  for (const Index count : rows) {
    first.push_back(total);
    total += count;
  }
  block.setZero(3 * total, 3 * total);
  const Index unknowns = static_cast<Index>(group.gap.size());
  Eigen::MatrixXd left = Eigen::MatrixXd::Zero(unknowns, 3 * total);   // L K^-1 D^T
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(3 * total, unknowns);  // D K^-1 F
  std::size_t begin = 0;
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    std::size_t end = begin;
    while (end < group.terms.size() && group.terms[end].fiber == static_cast<Index>(i)) ++end;
    const Index f = group.fibers[i], columns = 3 * rows[i], functions = 2 * equations.fibers[f].nodes;
    if (equations.fibers[f].formulation != nullptr && columns > 0) {
      GroupMatrix x = GroupMatrix::Zero(equations.fibers[f].dofs(), columns);
      for (Index r = 0; r < rows[i]; ++r)
        for (Index j = 0; j < functions; ++j)
          for (Index k = 0; k < 3; ++k) x(3 * j + k, 3 * r + k) = d[i][static_cast<std::size_t>(r) * functions + j];
      equations.solve(f, x.data(), columns);
      for (Index r = 0; r < rows[i]; ++r)
        for (Index j = 0; j < functions; ++j) {
          const double weight = d[i][static_cast<std::size_t>(r) * functions + j];
          if (weight == 0.0) continue;
          block.block(3 * (first[i] + r), 3 * first[i], 3, columns) += weight * x.middleRows(3 * j, 3);
          for (std::size_t c = 0; c < group.touched[i].size(); ++c)
            right.block(3 * (first[i] + r), group.touched[i][c], 3, 1) +=
                weight * group.x[i].block(3 * j, static_cast<Index>(c), 3, 1);
        }
      for (std::size_t t = begin; t < end; ++t)
        left.block(group.terms[t].y, 3 * first[i], 1, columns) += group.terms[t].left * x.row(group.terms[t].dof);
    }
    begin = end;
  }
  if (unknowns > 0) block -= right * group.schur.solve(left);
}

double Joints::gap_force(const FiberEquations& equations, Index g) const {
  const Group& group = groups_[g];
  double stiffness = 0.0, length = std::numeric_limits<double>::infinity();
  for (const Index f : group.fibers) {
    const Fiber& fiber = equations.fibers[f];
    if (fiber.formulation == nullptr) continue;
    length = std::min(length, equations.shortest_element(fiber));
    stiffness = std::max(stiffness, fiber.section.bending_stiffness);
  }
  double largest = 0.0;
  for (const Pair& pair : group.pairs) {
    const Vec3 gap = nodal_vector(equations.dofs, pair.a.node, pair.part) -
                     pair.sign * nodal_vector(equations.dofs, pair.b.node, pair.part) - pair.rest;
    largest = std::max(largest, gap.norm() * (pair.part == 0 ? 1.0 / length : 1.0));
  }
  for (const RigidJoint& joint : group.rigid)
    for (const Member& member : joint.members)
      for (const Vec3& normal : member.normal)
        largest =
            std::max(largest, std::abs((joint.turn * normal).dot(nodal_vector(equations.dofs, member.place.node, 1))));
  return largest * stiffness / (length * length);
}

std::shared_ptr<const Joints::State> Joints::state(Index g) const {
  auto state = std::make_shared<State>();
  state->multiplier = groups_[g].multiplier;
  for (const RigidJoint& joint : groups_[g].rigid) state->turns.push_back(joint.turn);
  return state;
}

void Joints::restore(Index g, const State& state) {
  groups_[g].multiplier = state.multiplier;
  for (std::size_t k = 0; k < state.turns.size(); ++k) groups_[g].rigid[k].turn = state.turns[k];
}

std::string Joints::balance_acceleration(FiberEquations& equations) {
  begin_step(equations);
  std::string text;
  for (Index g = 0; g < groups(); ++g) {
    Group& group = groups_[g];
    if (!factorize(equations, g))
      return "the joints of fiber \"" + equations.mesh.name[group.fibers[0]] + "\" hold each other twice; remove one";
    const std::vector<double> velocity = gather(g, equations.velocity_n);
    std::vector<double> a = gather(g, equations.acceleration_n);
    Eigen::VectorXd rate = Eigen::VectorXd::Zero(group.gap.size()), y = rate;
    for (const Term& term : group.terms) {
      rate[term.y] += term.left * velocity[group.offset[term.fiber] + term.dof];
      y[term.y] += term.left * a[group.offset[term.fiber] + term.dof];
    }
    // L a + A alpha = -gamma, gamma = 2 (w x u).t' + (w x (w x u)).t, the spin w from L v + A w = 0.
    double fastest = 0.0;
    for (const double v : velocity) fastest = std::max(fastest, std::abs(v));
    Index first = group.first_rigid();
    for (const RigidJoint& joint : group.rigid) {
      const Index size = 2 * static_cast<Index>(joint.members.size());
      const Eigen::MatrixXd arm = group.q.block(first, first + size, size, 3);
      const Vec3 spin = -arm.completeOrthogonalDecomposition().solve(rate.segment(first, size));
      rate.segment(first, size) += arm * spin;
      Index k = first;
      for (const Member& member : joint.members)
        for (const Vec3& normal : member.normal) {
          const Vec3 u = joint.turn * normal, du = spin.cross(u);
          y[k++] += 2 * du.dot(nodal_vector(equations.velocity_n, member.place.node, 1)) +
                    spin.cross(du).dot(nodal_vector(equations.dofs_n, member.place.node, 1));
        }
      first += size + 3;
    }
    if (rate.size() > 0 && rate.cwiseAbs().maxCoeff() > 1e-6 * fastest && fastest > 0.0)
      text = "the initial velocity tears a joint of fiber \"" + equations.mesh.name[group.fibers[0]] +
             "\" apart; give joined fibers velocities that agree at their joints";
    if (y.size() == 0) continue;
    y = group.schur.solve(y).eval();
    for (std::size_t i = 0; i < group.fibers.size(); ++i)
      for (Index d = 0; d < group.x[i].rows(); ++d)
        for (std::size_t c = 0; c < group.touched[i].size(); ++c)
          a[group.offset[i] + d] -= group.x[i](d, static_cast<Index>(c)) * y[group.touched[i][c]];
    scatter(g, a, equations.acceleration_n);
  }
  return text;
}

}  // namespace fbi::beam
