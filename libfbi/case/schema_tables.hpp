/// Field tables of a case file, one for each parameter struct.
#pragma once

#include "case/schema.hpp"
#include "input/visitor.hpp"

namespace fbi::cases {

using input::Visitor;

void describe_fluid(Visitor& v, fluid::FluidParameters& p);
void describe_channel(Visitor& v, Channel& p);
void describe_mesh(Visitor& v, MeshFile& p);
void describe_boundary(Visitor& v, fluid::BoundaryCondition& p);

void describe_fiber_group(Visitor& v, FiberGroup& p);

void describe_joint(Visitor& v, mesh::JointParameters& p);

void describe_coupling(Visitor& v, coupling::CouplingParameters& p, fsi::SchemeParameters& scheme);
void describe_solver(Visitor& v, fsi::SolverParameters& p);
/// The keys of "time": step size, end and the schemes of both fields.
void describe_time(Visitor& v, CaseParameters& p);
void describe_output(Visitor& v, Output& p);
void describe_expectation(Visitor& v, Expectation& p);

/// Reports a "name" that is empty or holds a character that tables of results split columns at.
/// @param why  end of the message: what names of this kind are used for
void check_name(Visitor& v, const std::string& name, const std::string& why);

/// The whole case, with the checks that go across its parts.
void describe_case(Visitor& v, CaseParameters& p);

}  // namespace fbi::cases
