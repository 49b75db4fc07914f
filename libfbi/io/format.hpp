/// What every file of ours says about itself: attributes "format", "version" and "written_by" of the root group.
#pragma once

#include <string>

#include "io/hdf5.hpp"

namespace fbi::io {

/// Version of the layout of all our HDF5 files; raised whenever an older program would misread a newer file.
inline constexpr GlobalIndex file_version = 1;

enum class FileKind {
  case_input,  ///< NAME.h5: mesh, fibers and input text, from fbi-gen
  result,      ///< NAME.run.h5: index of a run
  mesh,        ///< NAME.run/mesh.h5: mesh and fibers of a run
  step,        ///< NAME.run/000050.h5: fields of one step
  checkpoint   ///< NAME.run/restart-000050.h5: everything a restart needs
};

/// "case file", "result index", ... as written to the file and shown in messages.
std::string kind_name(FileKind kind);

/// Marks a new file. Collective for a parallel file.
void write_format(File& file, FileKind kind);

/// The kind of an open file. Throws Error(file) when it is none of ours or of another version. Collective for a
/// parallel file.
FileKind read_kind(const File& file);

/// Opens a file of one kind. Throws Error(file) for a missing, foreign or damaged file, another version, another kind;
/// each message says what to do.
File open_kind(const std::string& path, FileKind kind);
/// The same on all ranks. Collective.
File open_kind(const Comm& comm, const std::string& path, FileKind kind);

}  // namespace fbi::io
