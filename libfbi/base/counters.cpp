#include "base/counters.hpp"

#include <map>

#include "base/log.hpp"

namespace fbi {
namespace {

struct Counter {
  GlobalIndex number = 0;
  bool parts = false;
};

std::map<std::string, Counter, std::less<>>& counters() {
  static std::map<std::string, Counter, std::less<>> all;
  return all;
}

void add(const char* what, GlobalIndex number, bool parts) {
  const auto found = counters().find(what);
  Counter& counter = found != counters().end() ? found->second : counters()[what];
  counter.number += number;
  counter.parts = parts;
}

/// Texts of all ranks one after the other, on every rank. Collective.
std::string gather(const Comm& comm, const std::string& mine) {
  const int length = static_cast<int>(mine.size());
  std::vector<int> lengths(comm.size()), begin(comm.size() + 1, 0);
  MPI_Allgather(&length, 1, MPI_INT, lengths.data(), 1, MPI_INT, comm.get());
  for (int r = 0; r < comm.size(); ++r) begin[r + 1] = begin[r] + lengths[r];
  std::string all(begin.back(), '\0');
  MPI_Allgatherv(mine.data(), length, MPI_CHAR, all.data(), lengths.data(), begin.data(), MPI_CHAR, comm.get());
  return all;
}

}  // namespace

void count(const char* what, GlobalIndex times) { add(what, times, false); }
void count_parts(const char* what, GlobalIndex parts) { add(what, parts, true); }

GlobalIndex counted(const std::string& what) {
  const auto found = counters().find(what);
  return found == counters().end() ? 0 : found->second.number;
}

void reset_counters() { counters().clear(); }

std::vector<Counted> counted_work(const Comm& comm) {
  // A rank without fibers has fewer names than others: lines "S name" or "P name" of all ranks make one list.
  std::string mine;
  for (const auto& [what, counter] : counters()) mine += (counter.parts ? "P" : "S") + what + "\n";
  const std::string all = gather(comm, mine);
  std::map<std::string, bool> parts;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = all.find('\n', begin);
    parts[all.substr(begin + 1, end - begin - 1)] = all[begin] == 'P';
    begin = end + 1;
  }
  std::vector<Counted> work;
  for (const auto& [what, adds_up] : parts)
    work.push_back({what, adds_up ? comm.sum(counted(what)) : comm.max(counted(what))});
  return work;
}

std::string counter_report(const std::vector<Counted>& work) {
  std::string text;
  const std::size_t rows = (work.size() + 1) / 2;
  for (std::size_t row = 0; row < rows; ++row) {
    for (std::size_t k = row; k < work.size(); k += rows)
      text += log::format("  %-30s %12lld", work[k].what.c_str(), static_cast<long long>(work[k].number));
    text += "\n";
  }
  return text;
}

}  // namespace fbi
