/// HDF5 files, serial and parallel; hdf5.cpp is the only place that includes the HDF5 headers.
///
/// Names of datasets and groups are absolute paths such as "/mesh/nodes"; groups on the way are created. Every failure
/// is an Error(file) that names the file, thrown on every rank of a parallel file. HDF5 itself prints nothing.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"
#include "io/pending_file.hpp"

namespace fbi::io {

/// An open HDF5 file. All members of a parallel file (made with a communicator of more than one rank) are collective.
class File {
 public:
  /// Starts a new file under a temporary name; commit() gives it its own. `expected_bytes` [byte] of data are checked
  /// to fit.
  static File create(const std::string& path, GlobalIndex expected_bytes);
  static File create(const Comm& comm, const std::string& path, GlobalIndex expected_bytes);
  /// Opens for reading. Errors tell a missing file, one that is not HDF5, and a truncated one apart; `remedy` ends the
  /// message.
  static File open(const std::string& path, const std::string& remedy);
  static File open(const Comm& comm, const std::string& path, const std::string& remedy);

  File(File&& other) noexcept;
  File& operator=(File&&) = delete;
  /// Closes; a file that was not committed is removed.
  ~File();

  /// Flushes, closes, syncs and renames a new file.
  void commit();

  const std::string& path() const { return path_; }

  bool has(const std::string& name) const;
  /// Names of what is in a group, sorted; empty when there is no such group.
  std::vector<std::string> children(const std::string& group) const;
  /// True for a group, false for a dataset.
  bool is_group(const std::string& name) const;
  void make_group(const std::string& name);

  void write_attribute(const std::string& object, const std::string& name, const std::string& value);
  void write_attribute(const std::string& object, const std::string& name, GlobalIndex value);
  void write_attribute(const std::string& object, const std::string& name, double value);
  bool has_attribute(const std::string& object, const std::string& name) const;
  std::string text_attribute(const std::string& object, const std::string& name) const;
  GlobalIndex integer_attribute(const std::string& object, const std::string& name) const;
  double number_attribute(const std::string& object, const std::string& name) const;

  /// Rows and columns of a dataset; columns is 1 for one dimension.
  std::array<GlobalIndex, 2> shape(const std::string& name) const;

  /// Writes rows [begin, begin + data.size()/columns) of a dataset of shape=(total,columns), (total) for one column.
  /// Every rank passes its own rows, together all of them. T: double, int32, int64.
  template <class T>
  void write_rows(const std::string& name, const std::vector<T>& data, int columns, GlobalIndex begin,
                  GlobalIndex total);
  /// Writes a whole dataset of a serial file.
  template <class T>
  void write(const std::string& name, const std::vector<T>& data, int columns = 1) {
    const GlobalIndex rows = static_cast<GlobalIndex>(data.size()) / columns;
    write_rows(name, data, columns, 0, rows);
  }
  /// Reads rows [begin, begin + count), row-major; integers and doubles are converted from what the file holds.
  template <class T>
  std::vector<T> read_rows(const std::string& name, GlobalIndex begin, GlobalIndex count) const;
  /// Reads a whole dataset (on every rank of a parallel file).
  template <class T>
  std::vector<T> read(const std::string& name) const {
    return read_rows<T>(name, 0, shape(name)[0]);
  }

  /// The same for strings, stored with a fixed length.
  void write_strings(const std::string& name, const std::vector<std::string>& data, GlobalIndex begin,
                     GlobalIndex total);
  std::vector<std::string> read_strings(const std::string& name, GlobalIndex begin, GlobalIndex count) const;

  /// One text of any length as a scalar dataset (serial files only).
  void write_text(const std::string& name, const std::string& text);
  std::string read_text(const std::string& name) const;

  /// A link to the root group (or `target`) of another file; `file` is relative to this file's directory.
  void link(const std::string& name, const std::string& file, const std::string& target = "/");

 private:
  using Handle = std::int64_t;
  File(std::optional<Comm> comm, std::string path) : comm_(comm), path_(std::move(path)) {}
  bool parallel() const { return comm_.has_value(); }
  void commit_serial();
  void commit_parallel();
  void check(bool good, const std::string& what) const;
  Handle create_dataset(const std::string& name, Handle type, const std::vector<GlobalIndex>& shape);
  void transfer_rows(const std::string& name, Handle dataset, Handle type, GlobalIndex begin, GlobalIndex count,
                     void* data, bool writing) const;
  void write_attribute_value(const std::string& object, const std::string& name, Handle type, const void* value);
  void read_attribute_value(const std::string& object, const std::string& name, Handle type, void* value) const;

  std::optional<Comm> comm_;  // set for a parallel file
  std::string path_;
  std::string remedy_;  // ends messages of read errors
  bool writing_ = false;
  Handle handle_ = -1;
  std::optional<PendingFile> pending_;  // rank 0 of a new file
  std::string temporary_;               // of a new parallel file, on every rank
};

}  // namespace fbi::io
