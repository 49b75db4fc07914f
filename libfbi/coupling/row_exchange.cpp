#include "coupling/row_exchange.hpp"

#include <algorithm>

namespace fbi::coupling {

namespace {
constexpr int to_owners_tag = 10;
constexpr int from_owners_tag = 11;
}  // namespace

RowExchange::RowExchange(search::SparseExchange& exchange, const std::vector<GlobalIndex>& offsets,
                         const std::vector<GlobalIndex>& touched)
    : comm_(exchange.comm()) {
  std::map<int, std::vector<GlobalIndex>> out;
  for (std::size_t begin = 0; begin < touched.size();) {
    const int rank =
        static_cast<int>(std::upper_bound(offsets.begin(), offsets.end(), touched[begin]) - offsets.begin()) - 1;
    std::size_t end = begin;
    while (end < touched.size() && touched[end] < offsets[rank + 1]) ++end;
    owners_.push_back({rank, static_cast<Index>(begin), static_cast<Index>(end)});
    out[rank].assign(touched.begin() + begin, touched.begin() + end);
    begin = end;
  }
  for (const auto& [rank, rows] : exchange.exchange(std::move(out))) {
    Toucher toucher{rank, {}};
    toucher.rows.reserve(rows.size());
    for (const GlobalIndex row : rows) toucher.rows.push_back(static_cast<Index>(row - offsets[comm_.rank()]));
    touchers_.push_back(std::move(toucher));
  }
}

void RowExchange::add_to_owners(const double* touched, int components, double* owned) const {
  std::vector<MPI_Request> requests;
  std::vector<std::vector<double>> arrived(touchers_.size());
  for (std::size_t i = 0; i < touchers_.size(); ++i) {
    if (touchers_[i].rank == comm_.rank()) continue;
    arrived[i].resize(touchers_[i].rows.size() * components);
    MPI_Irecv(arrived[i].data(), static_cast<int>(arrived[i].size()), MPI_DOUBLE, touchers_[i].rank, to_owners_tag,
              comm_.get(), &requests.emplace_back());
  }
  const double* own = nullptr;
  for (const Owner& owner : owners_) {
    const double* part = touched + static_cast<std::size_t>(owner.begin) * components;
    if (owner.rank == comm_.rank())
      own = part;
    else
      MPI_Isend(part, (owner.end - owner.begin) * components, MPI_DOUBLE, owner.rank, to_owners_tag, comm_.get(),
                &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  for (std::size_t i = 0; i < touchers_.size(); ++i) {
    const double* values = touchers_[i].rank == comm_.rank() ? own : arrived[i].data();
    for (const Index row : touchers_[i].rows)
      for (int c = 0; c < components; ++c) owned[static_cast<std::size_t>(row) * components + c] += *values++;
  }
}

void RowExchange::copy_from_owners(const double* owned, int components, double* touched) const {
  std::vector<MPI_Request> requests;
  double* own = nullptr;
  for (const Owner& owner : owners_) {
    double* part = touched + static_cast<std::size_t>(owner.begin) * components;
    if (owner.rank == comm_.rank())
      own = part;
    else
      MPI_Irecv(part, (owner.end - owner.begin) * components, MPI_DOUBLE, owner.rank, from_owners_tag, comm_.get(),
                &requests.emplace_back());
  }
  std::vector<std::vector<double>> leaving(touchers_.size());
  for (std::size_t i = 0; i < touchers_.size(); ++i) {
    const bool here = touchers_[i].rank == comm_.rank();
    if (!here) leaving[i].resize(touchers_[i].rows.size() * components);
    double* values = here ? own : leaving[i].data();
    for (const Index row : touchers_[i].rows)
      for (int c = 0; c < components; ++c) *values++ = owned[static_cast<std::size_t>(row) * components + c];
    if (!here)
      MPI_Isend(leaving[i].data(), static_cast<int>(leaving[i].size()), MPI_DOUBLE, touchers_[i].rank, from_owners_tag,
                comm_.get(), &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
}

}  // namespace fbi::coupling
