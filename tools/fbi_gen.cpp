/// fbi-gen: from a JSON case to the HDF5 file that fbi-run computes.
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/version.hpp"
#include "case/schema.hpp"
#include "io/case_file.hpp"
#include "io/pending_file.hpp"
#include "meshgen/scene.hpp"

namespace fbi {
/// Name and text of the shipped cases; generated from cases/ when the program is built.
extern const std::vector<std::pair<const char*, const char*>> case_templates;
}  // namespace fbi

namespace {

using fbi::Error;
using fbi::ExitCode;

struct Arguments {
  std::string input;
  std::string output;
  bool check = false;
  bool schema = false;
  bool reference = false;
  std::string template_name;
  bool quiet = false;
};

std::string read_text(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode))
    throw Error(ExitCode::file, path + ": is a folder, not a case file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(ExitCode::file, path + ": cannot be read: " + std::strerror(errno));
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

/// NAME.json -> NAME.h5, beside it.
std::string default_output(const std::string& input) {
  const std::size_t dot = input.rfind('.');
  const std::size_t slash = input.rfind('/');
  const bool has_ending = dot != std::string::npos && (slash == std::string::npos || dot > slash + 1) && dot > 0;
  return (has_ending ? input.substr(0, dot) : input) + ".h5";
}

void generate(const Arguments& arguments) {
  const std::string text = read_text(arguments.input);
  const std::string name = arguments.input.substr(arguments.input.rfind('/') + 1);  // npos + 1 = 0
  const fbi::cases::CaseParameters parameters = fbi::cases::parse_case(text, arguments.input);
  std::vector<std::string> warnings;
  fbi::meshgen::Scene scene;
  try {
    scene = fbi::meshgen::make_scene(parameters, warnings, arguments.input.substr(0, arguments.input.rfind('/') + 1));
    fbi::meshgen::check_probes(parameters.output, scene.fibers);
  } catch (const Error& error) {  // every line names the file
    std::string lines = arguments.input + ": " + error.what();
    for (std::size_t end = lines.find('\n'); end != std::string::npos; end = lines.find('\n', end + 1)) {
      lines.insert(end + 1, arguments.input + ": ");
    }
    throw Error(error.code(), lines);
  }
  for (const std::string& warning : warnings) fbi::log::warning("%s: %s", arguments.input.c_str(), warning.c_str());
  const std::string summary = fbi::meshgen::summary(parameters, scene);
  if (!parameters.title.empty()) fbi::log::info("%s", parameters.title.c_str());
  fbi::log::info("%s", summary.c_str());
  if (arguments.check) {
    fbi::log::info("%s is correct", arguments.input.c_str());
    return;
  }
  const std::string output = arguments.output.empty() ? default_output(arguments.input) : arguments.output;
  fbi::io::write_case_file(output, {text, name, std::move(scene.fluid), std::move(scene.fibers)});
  fbi::log::info("wrote %s", output.c_str());
}

/// The text of a shipped case.
std::string template_text(const std::string& name) {
  std::string known;
  for (const auto& [other, text] : fbi::case_templates) {
    if (other == name) return text;
    known += std::string(known.empty() ? "" : ", ") + other;
  }
  throw Error(ExitCode::usage, "there is no template \"" + name + "\"; there are: " + known);
}

void say_errors(const std::string& text) {
  std::size_t begin = 0;
  while (begin <= text.size()) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    std::fprintf(stderr, "%s\n", text.substr(begin, end - begin).c_str());
    begin = end + 1;
  }
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Checks a case, meshes its channel and fibers and writes the file that fbi-run computes.", "fbi-gen");
  app.add_option("case", arguments.input, "case file (JSON; // comments allowed)");
  app.add_option("-o,--output", arguments.output, "file to write (default: the case file's name with .h5)");
  app.add_flag("--check", arguments.check, "check the case, write nothing");
  std::string names;
  for (const auto& [name, text] : fbi::case_templates) names += std::string(names.empty() ? "" : ", ") + name;
  app.add_option("--template", arguments.template_name, "print a shipped case to start from: " + names);
  app.add_flag("--schema", arguments.schema, "print the JSON Schema of case files, for editors");
  app.add_flag("--reference", arguments.reference, "print the reference of all keys as Markdown");
  app.add_flag("--quiet", arguments.quiet, "print warnings and errors only");
  app.set_version_flag("--version", fbi::version_text("fbi-gen"));
  app.footer("Exit codes: 0 ok, 1 usage or input, 2 geometry or mesh check, 6 file error.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  try {
    fbi::log::configure(true, arguments.quiet);
    fbi::io::survive_file_size_limit();
    if (arguments.schema || arguments.reference || !arguments.template_name.empty()) {
      const std::string text = !arguments.template_name.empty() ? template_text(arguments.template_name)
                               : arguments.schema ? fbi::cases::case_json_schema() : fbi::cases::case_reference();
      if (std::fputs(text.c_str(), stdout) == EOF || std::fflush(stdout) != 0) {
        throw Error(ExitCode::file, "standard output cannot be written");
      }
    } else if (arguments.input.empty()) {
      throw Error(ExitCode::usage, "no case file given; try fbi-gen case.json, or fbi-gen --help");
    } else {
      generate(arguments);
    }
  } catch (const Error& error) {
    say_errors(error.what());
    return static_cast<int>(error.code());
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "%s: not enough memory for a mesh of this size\n", arguments.input.c_str());
    return static_cast<int>(ExitCode::geometry);
  }
  return static_cast<int>(ExitCode::ok);
}
