#include "post/info.hpp"

#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/case_file.hpp"
#include "io/format.hpp"
#include "post/reader.hpp"

namespace fbi::post {
namespace {

using io::File;

// "  what   value"; further lines of the value stand below its first.
std::string line(const char* what, const std::string& value) {
  std::string text = log::format("  %-20s ", what);
  for (const char c : value) text += c == '\n' ? "\n" + std::string(23, ' ') : std::string(1, c);
  return text + "\n";
}
std::string line(const char* what, GlobalIndex value) { return line(what, std::to_string(value)); }

std::string bytes(double size) {
  if (size < 1e4) return log::format("%.0f B", size);
  if (size < 1e7) return log::format("%.1f kB", 1e-3 * size);
  return size < 1e10 ? log::format("%.1f MB", 1e-6 * size) : log::format("%.1f GB", 1e-9 * size);
}

double size_of(const std::string& path) {
  std::error_code error;
  const auto size = std::filesystem::file_size(path, error);
  return error ? 0.0 : static_cast<double>(size);
}

// Datasets of a group with their shapes.
std::string arrays(const File& file, const std::string& group) {
  std::string text;
  for (const std::string& name : file.children(group)) {
    const std::string path = group + "/" + name;
    if (!file.is_group(path)) {
      const auto [rows, columns] = file.shape(path);
      text += line(path.c_str(), std::to_string(rows) + (columns > 1 ? " x " + std::to_string(columns) : ""));
    } else {
      text += arrays(file, path);
    }
  }
  return text;
}

std::string describe_case(const File& file) {
  const std::string json = file.read_text("/input");
  std::string text = line("made from", file.text_attribute("/input", "name"));
  text += line("input fingerprint", io::fingerprint(json));
  if (file.has("/mesh")) {
    text += line("nodes", file.shape("/mesh/nodes")[0]);
    text += line("cells", file.shape("/mesh/cells")[0]);
    if (file.has("/mesh/box")) {
      std::string cells, from, to;
      for (const char* axis : {"x", "y", "z"}) {
        const std::vector<double> x = file.read<double>(std::string("/mesh/box/") + axis);
        const char* between = cells.empty() ? "" : " x ";
        cells += between + std::to_string(x.size() - 1);
        from += log::format(from.empty() ? "%g" : ", %g", x.front());
        to += log::format(to.empty() ? "%g" : ", %g", x.back());
      }
      text += line("box of cells", cells + ", from (" + from + ") to (" + to + ")");
    }
    for (const std::string& name : file.children("/mesh/faces"))
      text += line(("face set " + name).c_str(), std::to_string(file.shape("/mesh/faces/" + name)[0]) + " faces");
    text += line("fluid unknowns", 4 * file.shape("/mesh/nodes")[0]);
  } else {
    text += line("fluid", std::string("none"));
  }
  if (file.has("/fibers")) {
    const GlobalIndex count = file.shape("/fibers/names")[0];
    const std::vector<std::string> names = file.read_strings("/fibers/names", 0, count);
    std::string shown = names.front() + " ... " + names.back();
    if (count <= 12) {
      shown = names[0];
      for (std::size_t f = 1; f < names.size(); ++f) shown += ", " + names[f];
    }
    text += line("fibers", std::to_string(count) + " (" + shown + ")");
    text += line("fiber elements", file.shape("/fibers/element_length")[0]);
    text += line("fiber unknowns", 6 * file.shape("/fibers/position")[0]);
  } else {
    text += line("fibers", std::string("none"));
  }
  return text;
}

std::string describe_result(const File& file) {
  const Run run = read_run(file.path());
  const auto attribute = [&](const char* name) { return file.text_attribute("/provenance", name); };
  std::string text =
      line("input", file.text_attribute("/input", "name") + ", fingerprint " + attribute("case_fingerprint"));
  text += line("computed by", attribute("version"));
  text += line("command", attribute("command"));
  text += line("ranks", file.integer_attribute("/provenance", "ranks"));
  text += line("started", attribute("started"));
  text += line("last written", attribute("written"));
  text += line("state", std::string(run.complete ? "ended properly" : "going on, or stopped before its end"));
  if (run.history) {
    std::string rows = std::to_string(run.history->rows.size()) + " steps";
    const int time = run.history->column("time");
    if (time >= 0 && !run.history->rows.empty()) rows += log::format(", to time %g", run.history->rows.back()[time]);
    text += line("history", rows + ", " + std::to_string(run.history->columns.size()) + " columns");
  }
  double total = size_of(run.paths.mesh());
  std::string steps;
  for (const io::StepTime& output : run.outputs) {
    const double size = size_of(run.paths.step(output.step));
    total += size;
    steps += line(log::format("  step %lld", static_cast<long long>(output.step)).c_str(),
                  log::format("time %-12g ", output.time) + bytes(size));
  }
  text += line("outputs", std::to_string(run.outputs.size()) + ", with the mesh " + bytes(total)) + steps;
  std::string checkpoints;
  for (const GlobalIndex step : run.paths.checkpoints())
    checkpoints += (checkpoints.empty() ? "" : ", ") + std::to_string(step);
  return text + line("checkpoints", checkpoints.empty() ? std::string("none") : "steps " + checkpoints);
}

std::string describe_checkpoint(const File& file) {
  std::string text = line("step", file.integer_attribute("/", "step"));
  text += line("time", log::format("%.17g", file.number_attribute("/", "time")));
  text += line("case fingerprint", file.text_attribute("/", "case_fingerprint"));
  for (const std::string& name : file.children("/numbers"))
    text += line(name.c_str(), log::format("%.17g", file.read<double>("/numbers/" + name).at(0)));
  return text + arrays(file, "/vectors") + arrays(file, "/fluid") + arrays(file, "/fibers");
}

std::string describe_step(const File& file) {
  return line("step", file.integer_attribute("/", "step")) +
         line("time", log::format("%.17g", file.number_attribute("/", "time"))) + arrays(file, "/fluid") +
         arrays(file, "/fibers");
}

}  // namespace

std::string describe_file(const std::string& path) {
  const File file = File::open(path, "give a file that fbi-gen or fbi-run wrote");
  const io::FileKind kind = io::read_kind(file);
  const std::string head = path + ": " + io::kind_name(kind) + ", " + bytes(size_of(path)) + "\n";
  switch (kind) {
    case io::FileKind::case_input:
      return head + describe_case(file);
    case io::FileKind::result:
      return head + describe_result(file);
    case io::FileKind::checkpoint:
      return head + describe_checkpoint(file);
    case io::FileKind::step:
      return head + describe_step(file);
    default:
      return head + arrays(file, "/fluid") + arrays(file, "/fibers");
  }
}

}  // namespace fbi::post
