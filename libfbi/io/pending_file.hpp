/// Files that appear whole or not at all: written under a temporary name, synced, renamed.
#pragma once

#include <string>

#include "base/types.hpp"

namespace fbi::io {

/// The temporary name of a file that is being written; without commit() it is removed and a file of the final name
/// stays as it was. The temporary name is PATH.tmp.PID in the same directory.
class PendingFile {
 public:
  /// Throws Error(file) when the file cannot be created or, as far as the file system tells, `expected_bytes` do not
  /// fit.
  explicit PendingFile(const std::string& path, GlobalIndex expected_bytes = 0);
  PendingFile(PendingFile&& other) noexcept;
  PendingFile& operator=(PendingFile&&) = delete;
  ~PendingFile();

  const std::string& path() const { return path_; }
  const std::string& temporary() const { return temporary_; }
  /// Puts these bytes into the temporary file. Throws Error(file).
  void write(const char* data, std::size_t size);
  /// Syncs the temporary file, gives it the final name and syncs the directory. Throws Error(file).
  void commit();

 private:
  std::string path_;
  std::string temporary_;
};

/// Writes a text file as above. Throws Error(file).
void write_text_file(const std::string& path, const std::string& text);

/// The text of a file. Throws Error(file).
std::string read_text_file(const std::string& path);

/// Keeps room for a file of `bytes` without changing its length, where the file system can do that. Throws Error(file).
void reserve_room(const std::string& path, GlobalIndex bytes);

/// Flushes what the system holds of a file to the disk. Throws Error(file).
void sync_file(const std::string& path);

/// Removes temporary files that killed programs left in `directory` (of one `file` name when given); returns how many.
/// Call it only where no other program writes.
int remove_leftovers(const std::string& directory, const std::string& file = "");

/// "cannot write PATH: <reason of errno>; <what to do>" as Error(file).
[[noreturn]] void throw_write_error(const std::string& path, int error_number);

/// From now on a write past the file-size limit fails with EFBIG and does not end the program (SIGXFSZ is ignored).
void survive_file_size_limit();

/// Creates a directory and those above it. Throws Error(file).
void make_directory(const std::string& path);

}  // namespace fbi::io
