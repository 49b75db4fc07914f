#include "base/memory.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>

namespace fbi {
namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();
constexpr double largest_limit = 4e18;  // bytes; version 1 writes nearly 2^63 for "none"

/// The number after `key` in a file of lines "key number ..."; with an empty key the first number. Infinite without.
double number_in(const std::string& path, const std::string& key = "") {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string word;
    if (!key.empty() && (!(words >> word) || word != key)) continue;
    double number = 0.0;
    return words >> number ? number : unlimited;
  }
  return unlimited;
}

/// What one control group leaves: limit - use + file cache.
double left_in_group(const std::string& folder, const char* limit_name, const char* use_name, const char* cache_name) {
  const double limit = number_in(folder + "/" + limit_name), use = number_in(folder + "/" + use_name);
  if (!(limit < largest_limit) || !(use < largest_limit)) return unlimited;
  const double cache = number_in(folder + "/memory.stat", cache_name);
  return std::max(0.0, limit - use + (cache < largest_limit ? cache : 0.0));
}

/// The least that the group `path` and those around it leave, below `mount`.
double left_in_groups(const std::string& mount, std::string path, const char* limit, const char* use,
                      const char* cache) {
  double least = unlimited;
  while (true) {
    least = std::min(least, left_in_group(mount + path, limit, use, cache));
    const std::size_t slash = path.rfind('/');
    if (path.empty() || slash == std::string::npos) return least;
    path.erase(slash);
  }
}

}  // namespace

double available_memory(const std::string& root) {
  double available = 1024.0 * number_in(root + "/proc/meminfo", "MemAvailable:");
  std::ifstream groups(root + "/proc/self/cgroup");
  for (std::string line; std::getline(groups, line);) {  // "0::/path" or "4:cpu,memory:/path"
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",",
                      path = line.substr(second + 1) == "/" ? "" : line.substr(second + 1);
    if (controllers == ",,")
      available = std::min(
          available, left_in_groups(root + "/sys/fs/cgroup", path, "memory.max", "memory.current", "inactive_file"));
    else if (controllers.find(",memory,") != std::string::npos)
      available = std::min(available, left_in_groups(root + "/sys/fs/cgroup/memory", path, "memory.limit_in_bytes",
                                                     "memory.usage_in_bytes", "total_inactive_file"));
  }
  return available;
}

double resident_memory() {
  std::ifstream file("/proc/self/statm");
  double whole = 0.0, resident = 0.0;
  file >> whole >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE));
}

MemoryShare memory_share(const Comm& comm, double need, double available) {
  MPI_Comm machine = MPI_COMM_NULL;
  MPI_Comm_split_type(comm.get(), MPI_COMM_TYPE_SHARED, comm.rank(), MPI_INFO_NULL, &machine);
  MemoryShare mine;
  {
    const Comm local(machine);
    mine.need = local.sum(need);
    const double left = available >= 0.0 ? available : available_memory();
    mine.available = local.min(left) + local.sum(resident_memory());
  }
  MPI_Comm_free(&machine);
  const double worst = comm.max(mine.need / std::max(mine.available, 1.0));
  const bool here = mine.need / std::max(mine.available, 1.0) == worst;
  const int first = static_cast<int>(-comm.max(static_cast<GlobalIndex>(here ? -comm.rank() : -comm.size())));
  double numbers[2] = {mine.need, mine.available};
  MPI_Bcast(numbers, 2, MPI_DOUBLE, first, comm.get());
  return {numbers[0], numbers[1]};
}

}  // namespace fbi
