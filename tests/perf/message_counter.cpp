/// Counts what a rank sends, in any MPI program: a library to preload.
///
///   mpirun -n 4 -x LD_PRELOAD=build/release/lib/libmessage_counter.so -x FBI_MESSAGES=FILE bin/fbi-run CASE.h5
///
/// At the end every rank appends one line to FILE (stderr without it):
///   rank R messages N bytes B largest L collectives N bytes B largest L reductions N words W
/// Messages are those from one rank to another (persistent ones at each start). Of a collective the bytes count that
/// this rank hands to others or, in all-to-one-to-all operations, its own contribution; `largest` is the largest buffer
/// of one call, whether sent or received, which shows what grows with the number of ranks. What MPI does inside a
/// collective is not seen.
#include <mpi.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>

namespace {

struct Count {
  long long calls = 0, bytes = 0, largest = 0;
  void add(long long sent, long long buffer) {
    ++calls;
    bytes += sent;
    largest = std::max(largest, buffer);
  }
};
Count messages, collectives;
long long reductions = 0, words = 0;
bool asked = false;                           // by the program: it prints what it wants
std::map<MPI_Request, long long> persistent;  // bytes of each persistent send

long long size_of(long long entries, MPI_Datatype type) {
  int size = 0;
  if (type != MPI_DATATYPE_NULL) PMPI_Type_size(type, &size);
  return entries * size;
}
int ranks(MPI_Comm comm) {
  int n = 1;
  PMPI_Comm_size(comm, &n);
  return n;
}
long long total(const int* counts, MPI_Comm comm) {
  long long sum = 0;
  for (int r = 0; r < ranks(comm); ++r) sum += counts[r];
  return sum;
}
void send(int entries, MPI_Datatype type, int to) {
  if (to != MPI_PROC_NULL) messages.add(size_of(entries, type), size_of(entries, type));
}
void collective(long long sent, long long buffer) { collectives.add(sent, std::max(sent, buffer)); }
void reduction(int entries, MPI_Datatype type, MPI_Comm comm) {
  if (ranks(comm) == 1) return;
  ++reductions;
  words += entries;
  collective(size_of(entries, type), 0);
}

}  // namespace

extern "C" {

#define FBI_SEND(name)                                                                               \
  int MPI_##name(const void* data, int entries, MPI_Datatype type, int to, int tag, MPI_Comm comm) { \
    send(entries, type, to);                                                                         \
    return PMPI_##name(data, entries, type, to, tag, comm);                                          \
  }
FBI_SEND(Send)
FBI_SEND(Ssend)
FBI_SEND(Rsend)

#define FBI_ISEND(name)                                                                            \
  int MPI_##name(const void* data, int entries, MPI_Datatype type, int to, int tag, MPI_Comm comm, \
                 MPI_Request* request) {                                                           \
    send(entries, type, to);                                                                       \
    return PMPI_##name(data, entries, type, to, tag, comm, request);                               \
  }
FBI_ISEND(Isend)
FBI_ISEND(Issend)
FBI_ISEND(Irsend)

#define FBI_SEND_INIT(name)                                                                        \
  int MPI_##name(const void* data, int entries, MPI_Datatype type, int to, int tag, MPI_Comm comm, \
                 MPI_Request* request) {                                                           \
    const int code = PMPI_##name(data, entries, type, to, tag, comm, request);                     \
    if (to != MPI_PROC_NULL) persistent[*request] = size_of(entries, type);                        \
    return code;                                                                                   \
  }
FBI_SEND_INIT(Send_init)
FBI_SEND_INIT(Ssend_init)
FBI_SEND_INIT(Rsend_init)

int MPI_Start(MPI_Request* request) {
  const auto found = persistent.find(*request);
  if (found != persistent.end()) messages.add(found->second, found->second);
  return PMPI_Start(request);
}
int MPI_Startall(int count, MPI_Request* requests) {
  for (int i = 0; i < count; ++i) {
    const auto found = persistent.find(requests[i]);
    if (found != persistent.end()) messages.add(found->second, found->second);
  }
  return PMPI_Startall(count, requests);
}
int MPI_Request_free(MPI_Request* request) {
  persistent.erase(*request);
  return PMPI_Request_free(request);
}
int MPI_Sendrecv(const void* data, int entries, MPI_Datatype type, int to, int tag, void* in, int in_entries,
                 MPI_Datatype in_type, int from, int in_tag, MPI_Comm comm, MPI_Status* status) {
  send(entries, type, to);
  return PMPI_Sendrecv(data, entries, type, to, tag, in, in_entries, in_type, from, in_tag, comm, status);
}

int MPI_Allreduce(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  reduction(entries, type, comm);
  return PMPI_Allreduce(in, out, entries, type, op, comm);
}
int MPI_Iallreduce(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, MPI_Comm comm,
                   MPI_Request* request) {
  reduction(entries, type, comm);
  return PMPI_Iallreduce(in, out, entries, type, op, comm, request);
}
int MPI_Reduce(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, int root, MPI_Comm comm) {
  reduction(entries, type, comm);
  return PMPI_Reduce(in, out, entries, type, op, root, comm);
}
int MPI_Scan(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  reduction(entries, type, comm);
  return PMPI_Scan(in, out, entries, type, op, comm);
}
int MPI_Exscan(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  reduction(entries, type, comm);
  return PMPI_Exscan(in, out, entries, type, op, comm);
}
int MPI_Reduce_scatter_block(const void* in, void* out, int entries, MPI_Datatype type, MPI_Op op, MPI_Comm comm) {
  const long long bytes = size_of(entries, type) * ranks(comm);
  collective(bytes, bytes);
  return PMPI_Reduce_scatter_block(in, out, entries, type, op, comm);
}
int MPI_Barrier(MPI_Comm comm) {
  collective(0, 0);
  return PMPI_Barrier(comm);
}
int MPI_Bcast(void* data, int entries, MPI_Datatype type, int root, MPI_Comm comm) {
  int rank = 0;
  PMPI_Comm_rank(comm, &rank);
  collective(rank == root ? size_of(entries, type) : 0, size_of(entries, type));
  return PMPI_Bcast(data, entries, type, root, comm);
}
int MPI_Gather(const void* in, int in_entries, MPI_Datatype in_type, void* out, int entries, MPI_Datatype type,
               int root, MPI_Comm comm) {
  int rank = 0;
  PMPI_Comm_rank(comm, &rank);
  collective(rank == root ? 0 : size_of(in_entries, in_type), rank == root ? size_of(entries, type) * ranks(comm) : 0);
  return PMPI_Gather(in, in_entries, in_type, out, entries, type, root, comm);
}
int MPI_Gatherv(const void* in, int in_entries, MPI_Datatype in_type, void* out, const int* entries, const int* first,
                MPI_Datatype type, int root, MPI_Comm comm) {
  int rank = 0;
  PMPI_Comm_rank(comm, &rank);
  collective(rank == root ? 0 : size_of(in_entries, in_type), rank == root ? size_of(total(entries, comm), type) : 0);
  return PMPI_Gatherv(in, in_entries, in_type, out, entries, first, type, root, comm);
}
int MPI_Allgather(const void* in, int in_entries, MPI_Datatype in_type, void* out, int entries, MPI_Datatype type,
                  MPI_Comm comm) {
  collective(size_of(in_entries, in_type), size_of(entries, type) * ranks(comm));
  return PMPI_Allgather(in, in_entries, in_type, out, entries, type, comm);
}
int MPI_Allgatherv(const void* in, int in_entries, MPI_Datatype in_type, void* out, const int* entries,
                   const int* first, MPI_Datatype type, MPI_Comm comm) {
  collective(size_of(in_entries, in_type), size_of(total(entries, comm), type));
  return PMPI_Allgatherv(in, in_entries, in_type, out, entries, first, type, comm);
}
int MPI_Alltoall(const void* in, int in_entries, MPI_Datatype in_type, void* out, int entries, MPI_Datatype type,
                 MPI_Comm comm) {
  collective(size_of(in_entries, in_type) * ranks(comm), size_of(entries, type) * ranks(comm));
  return PMPI_Alltoall(in, in_entries, in_type, out, entries, type, comm);
}
int MPI_Alltoallv(const void* in, const int* in_entries, const int* in_first, MPI_Datatype in_type, void* out,
                  const int* entries, const int* first, MPI_Datatype type, MPI_Comm comm) {
  collective(size_of(total(in_entries, comm), in_type), size_of(total(entries, comm), type));
  return PMPI_Alltoallv(in, in_entries, in_first, in_type, out, entries, first, type, comm);
}

/// For programs that are linked to this library: messages, bytes, reductions and other collectives of this rank so far.
void fbi_messages(long long* counts) {
  asked = true;
  counts[0] = messages.calls;
  counts[1] = messages.bytes;
  counts[2] = reductions;
  counts[3] = collectives.calls - reductions;
}

int MPI_Finalize() {
  int rank = 0;
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const char* path = std::getenv("FBI_MESSAGES");
  if (path == nullptr && asked) return PMPI_Finalize();
  std::FILE* file = path != nullptr ? std::fopen(path, "a") : stderr;
  if (file == nullptr) file = stderr;
  std::fprintf(file,
               "rank %d messages %lld bytes %lld largest %lld collectives %lld bytes %lld largest %lld reductions %lld "
               "words %lld\n",
               rank, messages.calls, messages.bytes, messages.largest, collectives.calls, collectives.bytes,
               collectives.largest, reductions, words);
  if (file != stderr) std::fclose(file);
  return PMPI_Finalize();
}

}  // extern "C"
