/// A directory of its own for each test, removed at the end, and a file-size limit for a scope.
#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "base/comm.hpp"

namespace fbi::test {

/// Same path on all ranks; rank 0 makes and removes it. Collective.
class Scratch {
 public:
  explicit Scratch(const Comm& comm) : comm_(comm) {
    char name[64] = "fbi-test-XXXXXX";
    if (comm.rank() == 0) {
      const std::string pattern = (std::filesystem::temp_directory_path() / name).string();
      std::snprintf(name, sizeof name, "%s", pattern.c_str());
      if (!mkdtemp(name)) name[0] = '\0';
    }
    MPI_Bcast(name, sizeof name, MPI_CHAR, 0, comm.get());
    path_ = name;
  }
  ~Scratch() {
    MPI_Barrier(comm_.get());
    std::error_code ignored;
    if (comm_.rank() == 0) std::filesystem::remove_all(path_, ignored);
  }
  std::string operator/(const std::string& name) const { return path_ + "/" + name; }
  const std::string& path() const { return path_; }
  /// Files in the directory, sorted.
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path_))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

 private:
  Comm comm_;
  std::string path_;
};

/// No file may grow past `bytes` in this scope: what a full disk looks like.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

}  // namespace fbi::test
