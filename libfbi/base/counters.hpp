/// Counts of work by name: what a run did, how often, and so what it did not do.
#pragma once

#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"

namespace fbi {

/// Counts work that all ranks do together, once for all of them: `count("linear solves")`.
void count(const char* what, GlobalIndex times = 1);
/// Counts work on things that ranks share out, whose numbers add up: `count_parts("elements cut", elements)`.
void count_parts(const char* what, GlobalIndex parts);

/// What a name has counted on this rank; 0 when it never came up.
GlobalIndex counted(const std::string& what);
/// Sets all counts of this rank to zero, for tests.
void reset_counters();

/// One line of the table of all ranks.
struct Counted {
  std::string what;
  GlobalIndex number = 0;
};

/// All names that came up on some rank: the largest count of a rank for work done together, sums for parts. In the
/// order of the names, the same on every rank. Collective.
std::vector<Counted> counted_work(const Comm& comm);

/// The counts as a table of two columns of names and numbers, each line indented.
std::string counter_report(const std::vector<Counted>& work);

}  // namespace fbi
