#include "post/reader.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "base/error.hpp"
#include "io/format.hpp"

namespace fbi::post {
namespace {

std::optional<io::HistoryTable> history_of_index(const io::File& index) {
  if (!index.has("/history/rows")) return std::nullopt;
  io::HistoryTable table;
  table.columns = index.read_strings("/history/columns", 0, index.shape("/history/columns")[0]);
  table.units = index.read_strings("/history/units", 0, index.shape("/history/units")[0]);
  const std::vector<double> rows = index.read<double>("/history/rows");
  const std::size_t width = table.columns.size();
  for (std::size_t i = 0; i + width <= rows.size(); i += width)
    table.rows.emplace_back(rows.begin() + static_cast<std::ptrdiff_t>(i),
                            rows.begin() + static_cast<std::ptrdiff_t>(i + width));
  return table;
}

std::string name_of(const std::string& folder) {
  const std::size_t end = folder.rfind(".run");
  return end == std::string::npos || end == 0 ? folder : folder.substr(0, end);
}

}  // namespace

Run read_run(const std::string& index_path) {
  Run run;
  run.paths = io::run_paths(index_path);
  run.name = name_of(run.paths.folder_name());
  const bool has_csv = std::filesystem::exists(run.paths.csv);
  const std::vector<GlobalIndex> in_folder = run.paths.steps();
  std::map<GlobalIndex, double> times;
  if (std::filesystem::exists(index_path) || (!has_csv && in_folder.empty())) {
    const io::File index = io::open_kind(index_path, io::FileKind::result);
    run.complete = index.integer_attribute("/provenance", "complete") != 0;
    const std::vector<GlobalIndex> numbers = index.read<GlobalIndex>("/steps/number");
    const std::vector<double> values = index.read<double>("/steps/time");
    for (std::size_t i = 0; i < std::min(numbers.size(), values.size()); ++i) times[numbers[i]] = values[i];
    if (!has_csv) run.history = history_of_index(index);
  }
  for (const GlobalIndex step : in_folder) {
    const auto known = times.find(step);
    const double time = known != times.end()
                            ? known->second
                            : io::open_kind(run.paths.step(step), io::FileKind::step).number_attribute("/", "time");
    run.outputs.push_back({step, time});
  }
  if (has_csv) run.history = io::read_history(run.paths.csv);
  return run;
}

std::vector<std::string> fiber_names(const Run& run) {
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  if (!mesh.has("/fibers")) return {};
  return mesh.read_strings("/fibers/names", 0, mesh.shape("/fibers/names")[0]);
}

}  // namespace fbi::post
