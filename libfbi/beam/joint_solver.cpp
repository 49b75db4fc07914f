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

// Triad of a member; that of a fiber without triads, which does not move, at rest.
Quaternion triad_of(const FiberEquations& equations, const Member& member, bool at_start) {
  if (member.place.turn < 0) return Quaternion(member.section);
  return (at_start ? equations.triads->triad_n : equations.triads->triad)[member.place.triad()];
}

}  // namespace

Vec3 section_gap(const RigidJoint& joint, const Member& member, const Quaternion& triad) {
  return logarithm(Quaternion(joint.turn * member.section).conjugate() * triad);
}

Index RigidJoint::rows() const {
  Index sum = 0;
  for (const Member& member : members) sum += member.rows();
  return sum;
}

void Joints::Group::count() {
  Index size = first_rigid();
  for (const RigidJoint& joint : rigid) size += joint.rows() + 3;
  multiplier = Eigen::VectorXd::Zero(size);
  found = multiplier;
}

// The turn that takes the reference section of a member to the present one, or the reference tangents of two members,
// or the smallest one for parallel members, whose turn about their axis does not matter.
void Joints::Group::fit(const FiberEquations& equations, bool at_start) {
  const NodalField& dofs = at_start ? equations.dofs_n : equations.dofs;
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
    if (joint.whole >= 0) {
      const Member& member = joint.members[joint.whole];
      joint.turn = triad_of(equations, member, at_start).toRotationMatrix() * member.section.transpose();
    } else if (joint.second >= 0) {
      const Member& second = joint.members[joint.second];
      joint.turn = frame(t, nodal_vector(dofs, second.place.node, 1)) * frame(first.axis, second.axis).transpose();
    } else {
      joint.turn = Eigen::Quaterniond::FromTwoVectors(first.axis, t).toRotationMatrix();
    }
    if (at_start) joint.turn_n = joint.turn;
  }
}

// Forces of the joints on all unknowns of the group's fibers, to be added to the internal ones.
Eigen::VectorXd Joints::Group::joint_forces(const FiberEquations& equations) const {
  Eigen::VectorXd force = Eigen::VectorXd::Zero(begin.back());
  const Level& level = equations.level;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    const Vec3 mu = multiplier.segment<3>(3 * static_cast<Index>(p));
    force.segment<3>(begin[pair.a.fiber] + unknown(pair.a, pair.part)) += mu;
    force.segment<3>(begin[pair.b.fiber] + unknown(pair.b, pair.part)) -= pair.sign * mu;
  }
  Index y = first_rigid();
  for (const RigidJoint& joint : rigid) {
    for (const Member& member : joint.members) {
      if (member.whole) {
        if (member.place.turn >= 0)
          force.segment<3>(begin[member.place.fiber] + member.place.turn) += multiplier.segment<3>(y);
        y += 3;
        continue;
      }
      for (const Vec3& normal : member.normal)
        force.segment<3>(begin[member.place.fiber] + member.place.dof + 3) +=
            multiplier[y++] * (level.internal * (joint.turn * normal) + level.previous * (joint.turn_n * normal));
    }
    y += 3;
  }
  return force;
}

// L, F, Q and c at the iterate.
void Joints::Group::linearize(const FiberEquations& equations, bool with_springs) {
  const Index springs_at = size();
  Index total = springs_at;
  if (with_springs) total += 3 * static_cast<Index>(springs[0].size() + springs[1].size() + springs[2].size());
  q = Eigen::MatrixXd::Zero(total, total);
  gap = Eigen::VectorXd::Zero(total);
  terms.clear();
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const Pair& pair = pairs[p];
    const Index y = 3 * static_cast<Index>(p);
    gap.segment<3>(y) = nodal_vector(equations.dofs, pair.a.node, pair.part) -
                        pair.sign * nodal_vector(equations.dofs, pair.b.node, pair.part) - pair.rest;
    for (int k = 0; k < 3; ++k) {
      terms.push_back({pair.a.fiber, unknown(pair.a, pair.part) + k, y + k, 1.0, 1.0});
      terms.push_back({pair.b.fiber, unknown(pair.b, pair.part) + k, y + k, -pair.sign, -pair.sign});
    }
  }
  const double now = equations.level.internal, before = equations.level.previous;
  Index y = first_rigid();
  for (const RigidJoint& joint : rigid) {
    const Index turn = y + joint.rows();
    double size_of_couples = 0.0;
    for (const Member& member : joint.members) {
      if (member.whole) {
        // c = log((R G)^T Lambda), moments mu in the axes of Lambda; on R their sum, seen from R G at the level
        const Quaternion triad = triad_of(equations, member, false);
        const Vec3 psi = section_gap(joint, member, triad), mu = multiplier.segment<3>(y);
        const Mat3 map = inverse_tangent_map(psi), present = joint.turn * member.section;
        const Mat3 mean = now * present + before * (joint.turn_n * member.section);
        gap.segment<3>(y) = psi;
        gap.segment<3>(turn) -= mean * mu;
        q.block<3, 3>(y, turn) = -map * triad.toRotationMatrix().transpose();
        q.block<3, 3>(turn, y) = -mean;
        q.block<3, 3>(turn, turn) += now * skew(present * mu);
        if (member.place.turn >= 0)
          for (int k = 0; k < 3; ++k)
            for (int j = 0; j < 3; ++j)
              terms.push_back({member.place.fiber, member.place.turn + k, y + j, map(j, k), k == j ? 1.0 : 0.0});
        y += 3;
        continue;
      }
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
    if (joint.second < 0 && joint.whole < 0) {  // nothing turns about the common axis: its turn is held
      const Vec3 axis = joint.turn * joint.members[0].axis;
      q.block<3, 3>(turn, turn) += std::max(size_of_couples, 1.0) * axis * axis.transpose();
    }
    y += 3;
  }
  if (!with_springs) return;
  for (int part = 0; part < 3; ++part)
    for (const Place& place : springs[part]) {
      const double stiffness = equations.joint_spring(fibers[place.fiber], part);
      for (int k = 0; k < 3; ++k, ++y) {
        terms.push_back({place.fiber, unknown(place, part) + k, y, -stiffness, -stiffness});
        q(y, y) = stiffness;
      }
    }
}

Index Joints::groups() const { return static_cast<Index>(groups_.size()); }
Index Joints::unknowns(Index group) const { return groups_[group].size(); }
Index Joints::dofs(Index group) const { return groups_[group].offset.back(); }
const std::vector<Index>& Joints::first_unknowns(Index group) const { return groups_[group].begin; }

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
  group.fit(equations, true);
}

void Joints::fit(const FiberEquations& equations, Index group) { groups_[group].fit(equations, false); }

void Joints::add_forces(FiberEquations& equations, Index g) const {
  const Group& group = groups_[g];
  const Eigen::VectorXd force = group.joint_forces(equations);
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Fiber& fiber = equations.fibers[group.fibers[i]];
    if (fiber.formulation == nullptr) continue;
    for (Index k = 0; k < fiber.dofs(); ++k) {
      equations.full[group.first_dof[i] + k] += force[group.begin[i] + k];
      equations.residual[group.first_dof[i] + k] += force[group.begin[i] + k];
    }
    fiber.project(&equations.residual[group.first_dof[i]]);
    if (!equations.has_triads(group.fibers[i])) continue;
    for (Index node = 0; node < fiber.nodes; ++node) {
      TriadField& triads = *equations.triads;
      std::vector<double>& moments = triads.is_held(fiber.first_node + node) ? triads.held_moment : triads.residual;
      for (Index k = 6 * node; k < 6 * node + 3; ++k)
        moments[group.first_dof[i] + k] += force[group.begin[i] + fiber.dofs() + k];
    }
  }
}

void Joints::add_springs(FiberEquations& equations, Index g) const {
  const Group& group = groups_[g];
  if (equations.parameters.scheme != TimeScheme::static_) return;
  for (int part = 0; part < 3; ++part)
    for (const Place& place : group.springs[part])
      for (int k = 0; k < 3; ++k)
        equations.add_to_diagonal(group.fibers[place.fiber], Group::unknown(place, part) + k,
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
    x = GroupMatrix::Zero(equations.unknowns(f), columns);
    if (equations.fibers[f].formulation != nullptr) {
      for (std::size_t t = begin; t < end; ++t) x(group.terms[t].dof, column[group.terms[t].y]) += group.terms[t].right;
      equations.solve_all(f, x.data(), columns);
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

// x becomes x - X dy with (L X - Q) dy = L x + gaps; dy waits for advance().
void Joints::Group::close_gaps(std::vector<double>& x_all, const Eigen::VectorXd& gaps) {
  if (gap.size() == 0) return;
  Eigen::VectorXd y = gaps;
  for (const Term& term : terms) y[term.y] += term.left * x_all[begin[term.fiber] + term.dof];
  for (Index k = 0; k < y.size(); ++k)
    if (!std::isfinite(y[k])) {
      std::fill(x_all.begin(), x_all.end(), std::numeric_limits<double>::quiet_NaN());
      return;
    }
  y = schur.solve(y).eval();
  for (std::size_t i = 0; i < fibers.size(); ++i)
    for (Index d = 0; d < x[i].rows(); ++d)
      for (std::size_t c = 0; c < touched[i].size(); ++c)
        x_all[begin[i] + d] -= x[i](d, static_cast<Index>(c)) * y[touched[i][c]];
  found = y.head(size());
}

void Joints::solve_all(const FiberEquations& equations, Index g, std::vector<double>& b) {
  Group& group = groups_[g];
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Index f = group.fibers[i];
    double* part = &b[group.begin[i]];
    if (equations.fibers[f].formulation == nullptr)
      std::fill_n(part, equations.fibers[f].dofs(), 0.0);
    else
      equations.solve_all(f, part, 1);
  }
  group.close_gaps(b, group.gap);
}

void Joints::solve(const FiberEquations& equations, Index g, std::vector<double>& b) {
  Group& group = groups_[g];
  std::vector<double>& all = group.found_turns;
  all.assign(group.begin.back(), 0.0);
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Index f = group.fibers[i], dofs = equations.fibers[f].dofs();
    if (equations.fibers[f].formulation == nullptr) continue;
    std::copy_n(&b[group.offset[i]], dofs, &all[group.begin[i]]);
    equations.solve_all(f, &all[group.begin[i]], 1);
    if (!equations.has_triads(f)) continue;
    // what the elimination took out of the residual: -K_rr^-1 G_r
    const std::vector<double> alone = equations.triads->turns(equations, f, std::vector<double>(dofs, 0.0).data());
    for (Index k = 0; k < dofs; ++k) all[group.begin[i] + dofs + k] += alone[k];
  }
  group.close_gaps(all, group.gap);
  for (std::size_t i = 0; i < group.fibers.size(); ++i)
    std::copy_n(&all[group.begin[i]], group.offset[i + 1] - group.offset[i], &b[group.offset[i]]);
}

const double* Joints::turns(const FiberEquations& equations, Index f) const {
  const Group& group = groups_[equations.mesh.joined_group[f]];
  const auto place = std::find(group.fibers.begin(), group.fibers.end(), f) - group.fibers.begin();
  return &group.found_turns[group.begin[place] + equations.fibers[f].dofs()];
}

void Joints::advance(Index g, double factor) {
  Group& group = groups_[g];
  Index y = group.first_rigid();
  group.multiplier.head(y) += factor * group.found.head(y);
  for (RigidJoint& joint : group.rigid) {
    const Index rows = joint.rows();
    group.multiplier.segment(y, rows) += factor * group.found.segment(y, rows);
    y += rows;
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
      GroupMatrix x = GroupMatrix::Zero(equations.unknowns(f), columns);
      for (Index r = 0; r < rows[i]; ++r)
        for (Index j = 0; j < functions; ++j)
          for (Index k = 0; k < 3; ++k) x(3 * j + k, 3 * r + k) = d[i][static_cast<std::size_t>(r) * functions + j];
      equations.solve_all(f, x.data(), columns);
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
    stiffness = std::max(stiffness, equations.bending_stiffness(f));
  }
  double largest = 0.0;
  for (const Pair& pair : group.pairs) {
    const Vec3 gap = nodal_vector(equations.dofs, pair.a.node, pair.part) -
                     pair.sign * nodal_vector(equations.dofs, pair.b.node, pair.part) - pair.rest;
    largest = std::max(largest, gap.norm() * (pair.part == 0 ? 1.0 / length : 1.0));
  }
  for (const RigidJoint& joint : group.rigid)
    for (const Member& member : joint.members) {
      if (member.whole) {
        largest = std::max(largest, section_gap(joint, member, triad_of(equations, member, false)).norm());
        continue;
      }
      for (const Vec3& normal : member.normal)
        largest =
            std::max(largest, std::abs((joint.turn * normal).dot(nodal_vector(equations.dofs, member.place.node, 1))));
    }
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
  std::string text;
  for (Index g = 0; g < groups() && text.empty(); ++g) text = balance_acceleration(equations, g);
  return text;
}

// Where a support turns a tangent, one that continues it turns from the beginning.
void Joints::Group::share_initial_rates(FiberEquations& equations) const {
  const auto is_turned = [&](const Place& place) {
    const Fiber& fiber = equations.fibers[fibers[place.fiber]];
    const NodeSupport* support = fiber.support_at(place.node - fiber.first_node);
    return support != nullptr && support->direction.has_value();
  };
  for (const Pair& pair : pairs) {
    if (pair.part != 1 || is_turned(pair.a) == is_turned(pair.b)) continue;
    const Index from = is_turned(pair.a) ? pair.a.node : pair.b.node,
                to = is_turned(pair.a) ? pair.b.node : pair.a.node;
    for (std::size_t k = 3; k < 6; ++k)
      equations.velocity_n[6 * static_cast<std::size_t>(to) + k] =
          pair.sign * equations.velocity_n[6 * static_cast<std::size_t>(from) + k];
  }
}

std::string Joints::start_moving_supports(FiberEquations& equations) {
  std::string text;
  for (Index g = 0; g < groups() && text.empty(); ++g) {
    const std::vector<Index>& fibers = groups_[g].fibers;
    if (std::none_of(fibers.begin(), fibers.end(), [&](Index f) { return equations.fibers[f].moving_supports; }))
      continue;
    for (const Index f : fibers)
      if (equations.fibers[f].formulation != nullptr) equations.balance_at_start(f, nullptr);
    groups_[g].share_initial_rates(equations);
    text = balance_acceleration(equations, g);
  }
  return text;
}

std::string Joints::balance_acceleration(FiberEquations& equations, Index g) {
  begin_step(equations, g);
  Group& group = groups_[g];
  if (!factorize(equations, g))
    return "the joints of fiber \"" + equations.mesh.name[group.fibers[0]] + "\" hold each other twice; remove one";
  std::vector<double> velocity(group.begin.back(), 0.0), a = velocity;
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Index f = group.fibers[i], dofs = equations.fibers[f].dofs();
    std::copy_n(&equations.velocity_n[group.first_dof[i]], dofs, &velocity[group.begin[i]]);
    std::copy_n(&equations.acceleration_n[group.first_dof[i]], dofs, &a[group.begin[i]]);
    if (!equations.has_triads(f)) continue;
    std::copy_n(&equations.triads->spin_n[group.first_dof[i]], dofs, &velocity[group.begin[i] + dofs]);
    std::copy_n(&equations.triads->spin_rate_n[group.first_dof[i]], dofs, &a[group.begin[i] + dofs]);
  }
  Eigen::VectorXd rate = Eigen::VectorXd::Zero(group.gap.size()), y = rate;
  for (const Term& term : group.terms) {
    rate[term.y] += term.left * velocity[group.begin[term.fiber] + term.dof];
    y[term.y] += term.left * a[group.begin[term.fiber] + term.dof];
  }
  // L a + A alpha = -gamma, gamma = 2 (w x u).t' + (w x (w x u)).t, the spin w from L v + A w = 0.
  std::string text;
  double fastest = 0.0;
  for (const double v : velocity) fastest = std::max(fastest, std::abs(v));
  Index first = group.first_rigid();
  for (const RigidJoint& joint : group.rigid) {
    const Index size = joint.rows();
    const Eigen::MatrixXd arm = group.q.block(first, first + size, size, 3);
    const Vec3 spin = -arm.completeOrthogonalDecomposition().solve(rate.segment(first, size));
    rate.segment(first, size) += arm * spin;
    Index k = first;
    for (const Member& member : joint.members) {
      if (member.whole) {  // rates of sections agree in their own axes: nothing more
        k += 3;
        continue;
      }
      for (const Vec3& normal : member.normal) {
        const Vec3 u = joint.turn * normal, du = spin.cross(u);
        y[k++] += 2 * du.dot(nodal_vector(equations.velocity_n, member.place.node, 1)) +
                  spin.cross(du).dot(nodal_vector(equations.dofs_n, member.place.node, 1));
      }
    }
    first += size + 3;
  }
  if (rate.size() > 0 && rate.cwiseAbs().maxCoeff() > 1e-6 * fastest && fastest > 0.0)
    text = "the initial velocity tears a joint of fiber \"" + equations.mesh.name[group.fibers[0]] +
           "\" apart; give joined fibers velocities that agree at their joints";
  if (y.size() == 0) return text;
  y = group.schur.solve(y).eval();
  for (std::size_t i = 0; i < group.fibers.size(); ++i)
    for (Index d = 0; d < group.x[i].rows(); ++d)
      for (std::size_t c = 0; c < group.touched[i].size(); ++c)
        a[group.begin[i] + d] -= group.x[i](d, static_cast<Index>(c)) * y[group.touched[i][c]];
  for (std::size_t i = 0; i < group.fibers.size(); ++i) {
    const Index f = group.fibers[i], dofs = equations.fibers[f].dofs();
    std::copy_n(&a[group.begin[i]], dofs, &equations.acceleration_n[group.first_dof[i]]);
    if (!equations.has_triads(f)) continue;
    std::copy_n(&a[group.begin[i] + dofs], dofs, &equations.triads->spin_rate_n[group.first_dof[i]]);
    std::copy_n(&a[group.begin[i] + dofs], dofs, &equations.triads->spin_rate[group.first_dof[i]]);
  }
  return text;
}

}  // namespace fbi::beam
