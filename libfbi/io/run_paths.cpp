#include "io/run_paths.hpp"

#include <algorithm>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::io {
namespace {

std::string numbered(GlobalIndex step) { return log::format("%06lld.h5", static_cast<long long>(step)); }

// Numbers of the files prefix + digits + ".h5" in a directory.
std::vector<GlobalIndex> numbers_in(const std::string& directory, const std::string& prefix) {
  std::vector<GlobalIndex> numbers;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(directory, error)) {
    const std::string name = entry.path().filename().string();
    if (name.size() < prefix.size() + 4 || name.size() > prefix.size() + 21) continue;
    const std::string digits = name.substr(prefix.size(), name.size() - prefix.size() - 3);
    if (name.compare(0, prefix.size(), prefix) == 0 && name.compare(name.size() - 3, 3, ".h5") == 0 &&
        digits.find_first_not_of("0123456789") == std::string::npos)
      numbers.push_back(std::stoll(digits));
  }
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

std::string without_h5(const std::string& path) {
  if (path.size() <= 3 || path.compare(path.size() - 3, 3, ".h5") != 0)
    throw Error(ExitCode::usage, "\"" + path + "\" does not end in .h5; give the name of an HDF5 file");
  return path.substr(0, path.size() - 3);
}

}  // namespace

std::string RunPaths::step(GlobalIndex step) const { return directory + "/" + numbered(step); }
std::string RunPaths::checkpoint(GlobalIndex step) const { return directory + "/restart-" + numbered(step); }
std::string RunPaths::folder_name() const { return std::filesystem::path(directory).filename().string(); }
std::vector<GlobalIndex> RunPaths::steps() const { return numbers_in(directory, ""); }
std::vector<GlobalIndex> RunPaths::checkpoints() const { return numbers_in(directory, "restart-"); }

RunPaths run_paths(const std::string& index) {
  const std::string base = without_h5(index);
  return {index, base, base + ".xdmf", base + ".csv"};
}

RunPaths run_paths_of_case(const std::string& case_file, const std::string& directory) {
  std::filesystem::path base = without_h5(case_file);
  if (!directory.empty()) base = std::filesystem::path(directory) / base.filename();
  return run_paths(base.string() + ".run.h5");
}

}  // namespace fbi::io
