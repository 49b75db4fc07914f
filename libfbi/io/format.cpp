#include "io/format.hpp"

#include <array>

#include "base/error.hpp"

namespace fbi::io {
namespace {

struct Kind {
  FileKind kind;
  const char* name;
  const char* use;     // what to do with such a file
  const char* remedy;  // what to do when it cannot be read
};

constexpr std::array<Kind, 5> kinds = {{
    {FileKind::case_input, "case file", "run it with fbi-run", "make it (again) with fbi-gen NAME.json"},
    {FileKind::result, "result index", "look at it with fbi-post",
     "give the NAME.run.h5 that fbi-run wrote, or run the case again"},
    {FileKind::mesh, "result mesh", "it belongs to the NAME.run.h5 beside its folder", "run the case again"},
    {FileKind::step, "result step", "it belongs to the NAME.run.h5 beside its folder", "run the case again"},
    {FileKind::checkpoint, "checkpoint", "continue from it with fbi-run NAME.h5 --restart STEP",
     "restart from another step or run the case from the start"},
}};

const Kind& row(FileKind kind) { return kinds[static_cast<std::size_t>(kind)]; }

void expect_kind(const File& file, FileKind kind) {
  const FileKind found = read_kind(file);
  if (found == kind) return;
  throw Error(ExitCode::file, "\"" + file.path() + "\" is a " + row(found).name + ", not a " + row(kind).name + "; " +
                                  row(found).use + "; here " + row(kind).remedy);
}

}  // namespace

std::string kind_name(FileKind kind) { return row(kind).name; }

void write_format(File& file, FileKind kind) {
  file.write_attribute("/", "format", std::string("fbi ") + row(kind).name);
  file.write_attribute("/", "version", file_version);
}

FileKind read_kind(const File& file) {
  if (!file.has_attribute("/", "format") || !file.has_attribute("/", "version"))
    throw Error(ExitCode::file, "\"" + file.path() +
                                    "\" is an HDF5 file of another program; give a file that fbi-gen or fbi-run wrote");
  const std::string format = file.text_attribute("/", "format");
  const GlobalIndex version = file.integer_attribute("/", "version");
  for (const Kind& kind : kinds)
    if (format == std::string("fbi ") + kind.name) {
      if (version != file_version)
        throw Error(ExitCode::file, "\"" + file.path() + "\" has layout version " + std::to_string(version) +
                                        ", but this program reads version " + std::to_string(file_version) +
                                        "; make it again with the programs of this version");
      return kind.kind;
    }
  throw Error(ExitCode::file, "\"" + file.path() + "\" is an HDF5 file of unknown format \"" + format +
                                  "\"; give a file that fbi-gen or fbi-run wrote");
}

File open_kind(const std::string& path, FileKind kind) {
  File file = File::open(path, row(kind).remedy);
  expect_kind(file, kind);
  return file;
}

File open_kind(const Comm& comm, const std::string& path, FileKind kind) {
  File file = File::open(comm, path, row(kind).remedy);
  expect_kind(file, kind);  // the same attributes on every rank: all throw or none
  return file;
}

}  // namespace fbi::io
