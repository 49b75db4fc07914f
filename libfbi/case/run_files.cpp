#include "case/run_files.hpp"

#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"
#include "io/history.hpp"
#include "io/pending_file.hpp"

namespace fbi::cases {
namespace {

namespace fs = std::filesystem;

bool is_there(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code ignored;
  return fs::equivalent(a, b, ignored);
}

/// What is wrong with writing the results to `paths`; empty: nothing.
std::string result_problem(const std::string& case_path, const io::RunPaths& paths) {
  const std::string choose = "; choose another name with -o";
  const fs::path folder = fs::path(paths.index).parent_path();
  std::error_code ignored;
  if (!folder.empty() && !fs::is_directory(folder, ignored))
    return "cannot write \"" + paths.index + "\": there is no folder \"" + folder.string() +
           "\"; create it first or choose another one with -o";
  if (is_same_file(case_path, paths.index))
    return "the results would replace the case file \"" + case_path + "\"" + choose;
  if (is_there(paths.index)) try {
      io::open_kind(paths.index, io::FileKind::result);
    } catch (const Error&) {
      return "\"" + paths.index + "\" is there and is not a result of fbi-run; it is not replaced" + choose +
             " or move it away";
    }
  if (is_there(paths.csv)) try {
      io::read_history(paths.csv);
    } catch (const Error&) {
      return "\"" + paths.csv + "\" is there and is not a history of fbi-run; it is not replaced" + choose +
             " or move it away";
    }
  if (is_there(paths.directory) && !fs::is_directory(paths.directory, ignored))
    return "\"" + paths.directory + "\" is there and is not a folder, but step files go into one of that name" +
           choose + " or move it away";
  return "";
}

}  // namespace

void check_case_path(const Comm& comm, const std::string& case_path) {
  const fs::path path = case_path;
  const std::string extension = path.extension().string();
  if (extension != ".h5") {
    fs::path case_file = path;
    case_file.replace_extension(".h5");
    const bool is_text = extension == ".json";
    throw Error(ExitCode::usage,
                "\"" + case_path + "\" " +
                    (is_text ? "is the text of a case; run fbi-gen first:  fbi-gen " + case_path
                             : std::string("does not end in .h5; give the case file that fbi-gen wrote")) +
                    (is_text ? "  and then:  fbi-run " + case_file.string() : ""));
  }
  std::string problem;
  if (comm.rank() == 0 && !is_there(path)) {
    fs::path text = path;
    text.replace_extension(".json");
    problem = "cannot read \"" + case_path + "\": there is no such file; ";
    problem += is_there(text) ? "run fbi-gen first:  fbi-gen " + text.string()
                              : "check the name, or make the file with fbi-gen NAME.json";
  }
  agree_on_error(comm, ExitCode::file, problem);
}

void check_result_paths(const Comm& comm, const std::string& case_path, const io::RunPaths& paths) {
  agree_on_error(comm, ExitCode::file, comm.rank() == 0 ? result_problem(case_path, paths) : "");
}

void warn_if_outdated(const Comm& comm, const std::string& case_path, const io::CaseHeader& header) {
  if (comm.rank() != 0) return;
  const fs::path text = fs::path(case_path).parent_path() / header.json_name;
  try {
    if (!is_there(text) || io::read_text_file(text) == header.json) return;
  } catch (const Error&) {
    return;  // nobody needs that file here
  }
  log::warning("\"%s\" has changed since \"%s\" was made from it; to use the new text run fbi-gen %s again",
               text.c_str(), case_path.c_str(), text.c_str());
}

void warn_of_unfinished_run(const Comm& comm, const io::RunPaths& paths) {
  if (comm.rank() != 0 || !is_there(paths.index)) return;
  const std::vector<GlobalIndex> checkpoints = paths.checkpoints();
  if (checkpoints.empty()) return;
  try {
    const io::File index = io::open_kind(paths.index, io::FileKind::result);
    if (index.integer_attribute("/provenance", "complete") != 0) return;
  } catch (const Error&) {
    return;
  }
  log::warning(
      "an unfinished run in \"%s\" is replaced (its last checkpoint: step %lld; --restart last would have gone "
      "on from there)",
      paths.index.c_str(), static_cast<long long>(checkpoints.back()));
}

void write_expected(const Comm& comm, const io::RunPaths& paths, const std::string& rows) {
  std::string problem;
  if (comm.rank() == 0) try {
      std::error_code ignored;
      if (rows.empty())
        fs::remove(paths.expected(), ignored);
      else
        io::write_text_file(paths.expected(), rows);
    } catch (const Error& error) {
      problem = error.what();
    }
  agree_on_error(comm, ExitCode::file, problem);
}

}  // namespace fbi::cases
