#include "beam/joints.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "beam/joint_group.hpp"

namespace fbi::beam {
namespace {

constexpr double parallel = 1e-9;  // sine of the angle below which tangents lie on one line

// Stiffness and inertia of two sections are the same in space.
bool same_section(const FiberEquations& equations, Index f, const Mat3& triad_f, Index g, const Mat3& triad_g) {
  const ElementProperties &a = equations.fibers[f].section, &b = equations.fibers[g].section;
  if (equations.has_triads(f) != equations.has_triads(g) || a.mass_per_length != b.mass_per_length) return false;
  if (!equations.has_triads(f))
    return a.axial_stiffness == b.axial_stiffness && a.bending_stiffness == b.bending_stiffness;
  const TriadSection &s = equations.triads->section[f], &t = equations.triads->section[g];
  const auto agree = [&](const Vec3& of_f, const Vec3& of_g) {
    const Mat3 difference =
        triad_f * of_f.asDiagonal() * triad_f.transpose() - triad_g * of_g.asDiagonal() * triad_g.transpose();
    return difference.cwiseAbs().maxCoeff() <= 1e-9 * of_f.cwiseAbs().maxCoeff();
  };
  return agree(s.force, t.force) && agree(s.moment, t.moment) && agree(s.rotary, t.rotary);
}

}  // namespace

Joints::Joints(const FiberEquations& equations, std::string& error) {
  const mesh::FiberMesh& mesh = equations.mesh;
  const Index nodes = mesh.nodes();
  groups_.resize(mesh.joined.size());
  std::vector<Index> fiber_of_node(nodes), place_in_group(mesh.fibers(), -1);
  for (Index f = 0; f < mesh.fibers(); ++f)
    for (Index n = mesh.first_node[f]; n < mesh.first_node[f + 1]; ++n) fiber_of_node[n] = f;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Group& group = groups_[g];
    group.fibers = mesh.joined[g];
    group.offset = group.begin = {0};
    for (std::size_t i = 0; i < group.fibers.size(); ++i) {
      place_in_group[group.fibers[i]] = static_cast<Index>(i);
      const Formulation formulation = equations.groups[mesh.group[group.fibers[i]]].formulation;
      if (formulation != Formulation::torsion_free && formulation != Formulation::simo_reissner &&
          formulation != Formulation::fixed && error.empty())
        error = "fiber \"" + mesh.name[group.fibers[i]] +
                "\" has a joint, which goes with the formulations torsion_free, simo_reissner and fixed; choose one of "
                "them";
      const Index dofs = equations.fibers[group.fibers[i]].dofs();
      group.offset.push_back(group.offset.back() + dofs);
      group.begin.push_back(group.begin.back() + equations.unknowns(group.fibers[i]));
      group.first_dof.push_back(equations.fibers[group.fibers[i]].first_dof());
    }
  }
  const auto place_of = [&](Index node) {
    const Index f = fiber_of_node[node], dof = 6 * (node - mesh.first_node[f]);
    return Place{place_in_group[f], node, dof, equations.has_triads(f) ? equations.fibers[f].dofs() + dof : -1,
                 equations.fibers[f].formulation == nullptr};
  };
  // What supports leave of position (0) or direction (1) of a node.
  const auto is_held = [&](Index node, int part) {
    const Fiber& fiber = equations.fibers[fiber_of_node[node]];
    if (fiber.formulation == nullptr) return true;
    if (part == 1 && equations.has_triads(fiber_of_node[node])) return equations.triads->is_held(node);
    const Vec3 axis(&mesh.tangent[3 * static_cast<std::size_t>(node)]);
    for (int k = 0; k < 3; ++k) {
      std::vector<double> x(fiber.dofs(), 0.0);
      Vec3 direction = Vec3::Unit(k);
      if (part == 1) direction -= direction.dot(axis) * axis;
      const Index dof = 6 * (node - fiber.first_node) + 3 * part;
      for (int j = 0; j < 3; ++j) x[dof + j] = direction[j];
      fiber.project(x.data());
      for (int j = 0; j < 3; ++j)
        if (std::abs(x[dof + j]) > 1e-12) return false;
    }
    return true;
  };
  // Trees of nodes, so that no position is demanded twice; what supports hold hangs on the ground, number `nodes`.
  std::vector<Index> root(static_cast<std::size_t>(nodes) + 1), cluster_root(nodes);
  std::iota(root.begin(), root.end(), 0);
  std::iota(cluster_root.begin(), cluster_root.end(), 0);
  const auto find = [](std::vector<Index>& tree, Index n) {
    while (tree[n] != n) n = tree[n] = tree[tree[n]];
    return n;
  };
  for (const mesh::FiberMesh::LocalJoint& joint : mesh.joints) {
    Group& group = groups_[mesh.joined_group[fiber_of_node[joint.a]]];
    for (const Index node : {joint.a, joint.b})
      if (is_held(node, 0)) root[find(root, node)] = find(root, nodes);
    if (find(root, joint.a) != find(root, joint.b)) {
      root[find(root, joint.a)] = find(root, joint.b);
      Pair pair{place_of(joint.a), place_of(joint.b), 0, 1.0, Vec3::Zero()};
      pair.rest = nodal_vector(equations.dofs_n, joint.a, 0) - nodal_vector(equations.dofs_n, joint.b, 0);
      group.pairs.push_back(pair);
    }
    if (joint.type == mesh::JointType::rigid) {
      const Index a = find(cluster_root, joint.a), b = find(cluster_root, joint.b);
      cluster_root[std::max(a, b)] = std::min(a, b);
    }
  }
  std::map<Index, std::vector<Index>> clusters;  // nodes of each rigid joint
  for (const mesh::FiberMesh::LocalJoint& joint : mesh.joints)
    for (const Index node : {joint.a, joint.b})
      if (joint.type == mesh::JointType::rigid) clusters[find(cluster_root, node)].push_back(node);
  for (auto& [first, list] : clusters) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    Group& group = groups_[mesh.joined_group[fiber_of_node[first]]];
    const auto has_triad = [&](Index node) { return equations.has_triads(fiber_of_node[node]); };
    const bool with_triads = std::any_of(list.begin(), list.end(), has_triad);
    // what holds the section comes first: it says how the joint turns
    if (with_triads)
      std::stable_partition(list.begin(), list.end(), [&](Index node) {
        return is_held(node, 1) && (has_triad(node) || equations.fibers[fiber_of_node[node]].formulation == nullptr);
      });
    RigidJoint joint;
    bool one_is_held = false;
    for (const Index node : list) {
      const bool held = is_held(node, 1);
      if (held && one_is_held) continue;  // one held member says how the joint turns
      one_is_held = one_is_held || held;
      Member member{place_of(node), Vec3(&mesh.tangent[3 * static_cast<std::size_t>(node)]), {}};
      member.axis.normalize();
      member.normal[0] = member.axis.unitOrthogonal();
      member.normal[1] = member.axis.cross(member.normal[0]);
      member.whole = with_triads && (member.place.turn >= 0 || member.place.fixed);
      if (member.place.turn >= 0) member.section = equations.triads->triad[member.place.triad()].toRotationMatrix();
      joint.members.push_back(member);
      const Member& reference = joint.members[0];
      if (joint.second < 0 && reference.axis.cross(member.axis).norm() > parallel)
        joint.second = static_cast<int>(joint.members.size()) - 1;
      if (joint.whole < 0 && member.whole) joint.whole = static_cast<int>(joint.members.size()) - 1;
    }
    // where one fiber continues the other, tangents are the same
    bool equal_tangents = false;
    if (list.size() == 2) {
      const Place a = place_of(list[0]), b = place_of(list[1]);
      const Index f = fiber_of_node[list[0]], g = fiber_of_node[list[1]];
      const Vec3 s = Vec3(&mesh.tangent[3 * static_cast<std::size_t>(a.node)]).normalized(),
                 t = Vec3(&mesh.tangent[3 * static_cast<std::size_t>(b.node)]).normalized();
      Mat3 triad_f = Mat3::Identity(), triad_g = triad_f;
      if (has_triad(a.node)) triad_f = equations.triads->triad[a.triad()].toRotationMatrix();
      if (has_triad(b.node)) triad_g = equations.triads->triad[b.triad()].toRotationMatrix();
      equal_tangents = s.cross(t).norm() <= parallel && same_section(equations, f, triad_f, g, triad_g) &&
                       (with_triads || !one_is_held);
      if (equal_tangents) {
        Pair pair{a, b, 1, s.dot(t) > 0 ? 1.0 : -1.0, Vec3::Zero()};
        pair.rest = s - pair.sign * t;
        group.pairs.push_back(pair);
      }
    }
    if (joint.members.size() < 2 || (equal_tangents && !with_triads)) continue;
    group.rigid.push_back(joint);
  }
  for (Group& group : groups_) {
    const auto add = [](std::vector<Place>& list, const Place& place) {
      if (std::none_of(list.begin(), list.end(), [&](const Place& other) { return other.node == place.node; }))
        list.push_back(place);
    };
    for (const Pair& pair : group.pairs)
      for (const Place& place : {pair.a, pair.b}) add(group.springs[pair.part], place);
    for (const RigidJoint& joint : group.rigid)
      for (const Member& member : joint.members) add(group.springs[member.whole ? 2 : 1], member.place);
    for (std::vector<Place>& list : group.springs)
      list.erase(std::remove_if(list.begin(), list.end(),
                                [&](const Place& place) {
                                  return equations.fibers[group.fibers[place.fiber]].formulation == nullptr;
                                }),
                 list.end());
    group.count();
  }
}

Joints::~Joints() = default;

}  // namespace fbi::beam
