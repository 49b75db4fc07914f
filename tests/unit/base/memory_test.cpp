#include "base/memory.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace fbi {
namespace {

namespace fs = std::filesystem;

/// A folder that looks like the root of a system.
class System {
 public:
  System() : root_(fs::temp_directory_path() / ("fbi_memory_" + std::to_string(getpid()))) {
    fs::create_directories(root_);
  }
  ~System() { fs::remove_all(root_); }
  void write(const std::string& path, const std::string& text) const {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  double available() const { return available_memory(root_.string()); }

 private:
  fs::path root_;
};

TEST(Memory, IsWhatTheSystemHasLeft) {
  const System system;
  EXPECT_TRUE(std::isinf(system.available()));
  system.write("proc/meminfo", "MemTotal:  9000000 kB\nMemFree:  100 kB\nMemAvailable:   8000000 kB\n");
  EXPECT_EQ(system.available(), 8000000 * 1024.0);
}

TEST(Memory, IsWhatControlGroupsLeave) {
  const System system;
  system.write("proc/meminfo", "MemAvailable:   8000000 kB\n");
  system.write("proc/self/cgroup", "0::/jobs/seven\n");
  system.write("sys/fs/cgroup/jobs/seven/memory.max", "max\n");
  system.write("sys/fs/cgroup/jobs/seven/memory.current", "500\n");
  EXPECT_EQ(system.available(), 8000000 * 1024.0);
  // The group around it has a limit; its file cache would be given back.
  system.write("sys/fs/cgroup/jobs/memory.max", "1000000\n");
  system.write("sys/fs/cgroup/jobs/memory.current", "700000\n");
  EXPECT_EQ(system.available(), 300000.0);
  system.write("sys/fs/cgroup/jobs/memory.stat", "anon 600000\ninactive_file 50000\n");
  EXPECT_EQ(system.available(), 350000.0);
}

TEST(Memory, IsWhatControlGroupsOfVersionOneLeave) {
  const System system;
  system.write("proc/meminfo", "MemAvailable:   8000000 kB\n");
  system.write("proc/self/cgroup", "5:cpu,cpuacct:/x\n4:memory:/box\n");
  system.write("sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n");
  system.write("sys/fs/cgroup/memory/memory.usage_in_bytes", "5000\n");
  system.write("sys/fs/cgroup/memory/box/memory.limit_in_bytes", "2000000\n");
  system.write("sys/fs/cgroup/memory/box/memory.usage_in_bytes", "1500000\n");
  EXPECT_EQ(system.available(), 500000.0);
}

TEST(Memory, OfTheRanksOnOneMachineAddsUp) {
  const Comm comm;
  const double held = comm.sum(resident_memory());
  EXPECT_GT(held, 1e6 * comm.size());
  const MemoryShare share = memory_share(comm, 1e9, 5e9);  // all ranks of the tests are on one machine
  EXPECT_EQ(share.need, 1e9 * comm.size());
  EXPECT_NEAR(share.available, 5e9 + held, 0.2 * held);
  EXPECT_TRUE(share.fits());
  EXPECT_FALSE(memory_share(comm, 1e10, 5e9).fits());
  EXPECT_TRUE(memory_share(comm, 1.0).fits());
}

}  // namespace
}  // namespace fbi
