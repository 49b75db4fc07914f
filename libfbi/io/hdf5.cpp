#include "io/hdf5.hpp"

#include <hdf5.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <limits>

#include "base/error.hpp"

namespace fbi::io {
namespace {

// A handle that is closed at the end of its scope.
class Scoped {
 public:
  Scoped(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Scoped() {
    if (id_ >= 0) close_(id_);
  }
  Scoped(const Scoped&) = delete;
  Scoped& operator=(const Scoped&) = delete;
  operator hid_t() const { return id_; }
  bool good() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

// Starts HDF5 once: silent, and without locks, which are not needed (files are renamed when they are complete) and fail
// on some network file systems.
void start() {
  static const bool started = [] {
    setenv("HDF5_USE_FILE_LOCKING", "FALSE", 0);
    H5open();
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    return true;
  }();
  (void)started;
}

template <class T>
hid_t type_of();
template <>
hid_t type_of<double>() {
  return H5T_NATIVE_DOUBLE;
}
template <>
hid_t type_of<std::int32_t>() {
  return H5T_NATIVE_INT32;
}
template <>
hid_t type_of<std::int64_t>() {
  return H5T_NATIVE_INT64;
}

hid_t string_type(std::size_t length) {
  const hid_t type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, std::max<std::size_t>(length, 1));
  H5Tset_strpad(type, H5T_STR_NULLPAD);
  return type;
}

// Why a file cannot be opened for reading: empty when HDF5 should be able to.
std::string open_failure(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::exists(path, error)) return "there is no such file";
  if (std::filesystem::is_directory(path, error)) return "it is a directory";
  std::FILE* stream = std::fopen(path.c_str(), "rb");
  if (!stream) return std::strerror(errno);
  std::fclose(stream);
  if (H5Fis_hdf5(path.c_str()) <= 0) return "it is not an HDF5 file";
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file < 0) return "it is truncated or damaged";
  H5Fclose(file);
  return "";
}

}  // namespace

void File::check(bool good, const std::string& what) const {
  const int error = errno;
  const auto fail = [&] {
    if (!writing_)
      throw Error(ExitCode::file,
                  "cannot read " + what + " of \"" + path_ + "\": it is missing or damaged; " + remedy_);
    throw_write_error(path_, error == ENOSPC || error == EFBIG || error == EDQUOT || error == EIO ? error : 0);
  };
  if (!parallel()) {
    if (!good) fail();
    return;
  }
  std::string text;
  try {
    if (!good) fail();
  } catch (const Error& caught) {
    text = caught.what();
  }
  agree_on_error(*comm_, ExitCode::file, text);
}

// A serial file is built in memory and written by ourselves: HDF5 cannot close a file, nor itself, after a failed
// write.
File File::create(const std::string& path, GlobalIndex expected_bytes) {
  start();
  File file(std::nullopt, path);
  file.writing_ = true;
  file.pending_.emplace(path, expected_bytes);
  const Scoped access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_core(access, static_cast<std::size_t>(std::max<GlobalIndex>(expected_bytes, 65536)), false);
  file.handle_ = H5Fcreate(file.pending_->temporary().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  file.check(file.handle_ >= 0, "the file");
  return file;
}

File File::create(const Comm& comm, const std::string& path, GlobalIndex expected_bytes) {
  if (comm.size() == 1) return create(path, expected_bytes);
  start();
  survive_file_size_limit();
  File file(comm, path);
  file.writing_ = true;
  std::string text;
  if (comm.rank() == 0) try {
      file.pending_.emplace(path, expected_bytes);
      file.temporary_ = file.pending_->temporary();
    } catch (const Error& error) {
      text = error.what();
    }
  agree_on_error(comm, ExitCode::file, text);
  int length = static_cast<int>(file.temporary_.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm.get());
  file.temporary_.resize(static_cast<std::size_t>(length));
  MPI_Bcast(file.temporary_.data(), length, MPI_CHAR, 0, comm.get());
  const Scoped access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, comm.get(), MPI_INFO_NULL);
  errno = 0;
  file.handle_ = H5Fcreate(file.temporary_.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  file.check(file.handle_ >= 0, "the file");
  // Creating the file gave the room back that was just found to be there: take it again, before anything else does,
  // because a parallel HDF5 that meets a full disk can neither close the file nor end MPI.
  if (comm.rank() == 0) try {
      reserve_room(file.temporary_, expected_bytes);
    } catch (const Error& error) {
      text = error.what();
    }
  agree_on_error(comm, ExitCode::file, text);
  return file;
}

File File::open(const std::string& path, const std::string& remedy) {
  start();
  const std::string failure = open_failure(path);
  if (!failure.empty()) throw Error(ExitCode::file, "cannot read \"" + path + "\": " + failure + "; " + remedy);
  File file(std::nullopt, path);
  file.remedy_ = remedy;
  file.handle_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  file.check(file.handle_ >= 0, "the file");
  return file;
}

File File::open(const Comm& comm, const std::string& path, const std::string& remedy) {
  if (comm.size() == 1) return open(path, remedy);
  start();
  std::string failure;
  if (comm.rank() == 0) failure = open_failure(path);
  agree_on_error(comm, ExitCode::file,
                 failure.empty() ? "" : "cannot read \"" + path + "\": " + failure + "; " + remedy);
  File file(comm, path);
  file.remedy_ = remedy;
  const Scoped access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, comm.get(), MPI_INFO_NULL);
  H5Pset_all_coll_metadata_ops(access, true);
  file.handle_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  file.check(file.handle_ >= 0, "the file");
  return file;
}

File::File(File&& other) noexcept
    : comm_(other.comm_),
      path_(std::move(other.path_)),
      remedy_(std::move(other.remedy_)),
      writing_(other.writing_),
      handle_(other.handle_),
      pending_(std::move(other.pending_)),
      temporary_(std::move(other.temporary_)) {
  other.handle_ = -1;
  other.pending_.reset();
}

File::~File() {
  if (handle_ >= 0) H5Fclose(handle_);
}

void File::commit() {
  errno = 0;
  check(H5Fflush(handle_, H5F_SCOPE_GLOBAL) >= 0, "the file");
  if (parallel())
    commit_parallel();
  else
    commit_serial();
}

void File::commit_serial() {
  const ssize_t size = H5Fget_file_image(handle_, nullptr, 0);
  std::vector<char> image(static_cast<std::size_t>(std::max<ssize_t>(size, 0)));
  check(size > 0 && H5Fget_file_image(handle_, image.data(), image.size()) == size, "the file");
  H5Fclose(handle_);
  handle_ = -1;
  pending_->write(image.data(), image.size());
  pending_->commit();
}

void File::commit_parallel() {
  errno = 0;
  const bool closed = H5Fclose(handle_) >= 0;
  handle_ = -1;
  check(closed, "the file");
  std::string text;
  try {
    sync_file(temporary_);
  } catch (const Error& error) {
    text = error.what();
  }
  agree_on_error(*comm_, ExitCode::file, text);
  if (pending_) try {
      pending_->commit();
    } catch (const Error& error) {
      text = error.what();
    }
  agree_on_error(*comm_, ExitCode::file, text);
}

bool File::has(const std::string& name) const {
  for (std::size_t end = name.find('/', 1);; end = name.find('/', end + 1)) {
    if (H5Lexists(handle_, name.substr(0, end).c_str(), H5P_DEFAULT) <= 0) return false;
    if (end == std::string::npos) return true;
  }
}

std::vector<std::string> File::children(const std::string& group) const {
  std::vector<std::string> names;
  if (group != "/" && !has(group)) return names;
  const auto add = [](hid_t, const char* name, const H5L_info_t*, void* list) -> herr_t {
    static_cast<std::vector<std::string>*>(list)->push_back(name);
    return 0;
  };
  const Scoped id(H5Gopen2(handle_, group.c_str(), H5P_DEFAULT), H5Gclose);
  if (id.good()) H5Literate(id, H5_INDEX_NAME, H5_ITER_INC, nullptr, add, &names);
  std::sort(names.begin(), names.end());
  return names;
}

bool File::is_group(const std::string& name) const {
  if (!has(name)) return false;
  const Scoped id(H5Oopen(handle_, name.c_str(), H5P_DEFAULT), H5Oclose);
  return id.good() && H5Iget_type(id) == H5I_GROUP;
}

void File::make_group(const std::string& name) {
  const Scoped links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  errno = 0;
  const Scoped id(H5Gcreate2(handle_, name.c_str(), links, H5P_DEFAULT, H5P_DEFAULT), H5Gclose);
  check(id.good(), name);
}

void File::write_attribute_value(const std::string& object, const std::string& name, Handle type, const void* value) {
  const Scoped space(H5Screate(H5S_SCALAR), H5Sclose);
  errno = 0;
  const Scoped id(
      H5Acreate_by_name(handle_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Aclose);
  check(id.good() && H5Awrite(id, type, value) >= 0, name);
}

void File::read_attribute_value(const std::string& object, const std::string& name, Handle type, void* value) const {
  const Scoped id(H5Aopen_by_name(handle_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  check(id.good() && H5Aread(id, type, value) >= 0, "attribute \"" + name + "\"");
}

void File::write_attribute(const std::string& object, const std::string& name, const std::string& value) {
  const Scoped type(string_type(value.size()), H5Tclose);
  write_attribute_value(object, name, type, value.empty() ? "" : value.data());
}
void File::write_attribute(const std::string& object, const std::string& name, GlobalIndex value) {
  write_attribute_value(object, name, H5T_NATIVE_INT64, &value);
}
void File::write_attribute(const std::string& object, const std::string& name, double value) {
  write_attribute_value(object, name, H5T_NATIVE_DOUBLE, &value);
}

bool File::has_attribute(const std::string& object, const std::string& name) const {
  return (object == "/" || has(object)) && H5Aexists_by_name(handle_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
}

std::string File::text_attribute(const std::string& object, const std::string& name) const {
  const Scoped id(H5Aopen_by_name(handle_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  const Scoped type(id.good() ? H5Aget_type(id) : -1, H5Tclose);
  const bool good = type.good() && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  std::string value(good ? H5Tget_size(type) : 0, '\0');
  check(good && H5Aread(id, type, value.data()) >= 0, "attribute \"" + name + "\"");
  value.resize(std::min(value.find('\0'), value.size()));
  return value;
}

GlobalIndex File::integer_attribute(const std::string& object, const std::string& name) const {
  GlobalIndex value = 0;
  read_attribute_value(object, name, H5T_NATIVE_INT64, &value);
  return value;
}

double File::number_attribute(const std::string& object, const std::string& name) const {
  double value = 0.0;
  read_attribute_value(object, name, H5T_NATIVE_DOUBLE, &value);
  return value;
}

std::array<GlobalIndex, 2> File::shape(const std::string& name) const {
  const Scoped dataset(has(name) ? H5Dopen2(handle_, name.c_str(), H5P_DEFAULT) : -1, H5Dclose);
  const Scoped space(dataset.good() ? H5Dget_space(dataset) : -1, H5Sclose);
  const int rank = space.good() ? H5Sget_simple_extent_ndims(space) : -1;
  check(rank >= 0 && rank <= 2, name);
  hsize_t extent[2] = {1, 1};
  H5Sget_simple_extent_dims(space, extent, nullptr);
  return {static_cast<GlobalIndex>(extent[0]), static_cast<GlobalIndex>(extent[1])};
}

File::Handle File::create_dataset(const std::string& name, Handle type, const std::vector<GlobalIndex>& shape) {
  const std::vector<hsize_t> extent(shape.begin(), shape.end());
  const Scoped space(extent.empty() ? H5Screate(H5S_SCALAR)
                                    : H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr),
                     H5Sclose);
  const Scoped links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  const Scoped layout(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_fill_time(layout, H5D_FILL_TIME_NEVER);  // every row is written
  errno = 0;
  const hid_t dataset = H5Dcreate2(handle_, name.c_str(), type, space, links, layout, H5P_DEFAULT);
  check(dataset >= 0, name);
  return dataset;
}

void File::transfer_rows(const std::string& name, Handle dataset, Handle type, GlobalIndex begin, GlobalIndex count,
                         void* data, bool writing) const {
  const Scoped file_space(H5Dget_space(dataset), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(file_space);
  hsize_t extent[2] = {1, 1};
  if (rank >= 1) H5Sget_simple_extent_dims(file_space, extent, nullptr);
  bool good = rank >= 1 && begin >= 0 && begin + count <= static_cast<GlobalIndex>(extent[0]);
  const hsize_t start[2] = {static_cast<hsize_t>(begin), 0};
  const hsize_t size[2] = {static_cast<hsize_t>(count), extent[1]};
  const Scoped memory_space(H5Screate_simple(std::max(rank, 1), size, nullptr), H5Sclose);
  if (count > 0 && extent[1] > 0 && good) {
    good = H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, nullptr, size, nullptr) >= 0;
  } else {
    H5Sselect_none(file_space);
    H5Sselect_none(memory_space);
  }
  const Scoped transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose);
  if (parallel()) H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
  if (good && !(extent[0] == 0 || extent[1] == 0)) {
    errno = 0;
    good = (writing ? H5Dwrite(dataset, type, memory_space, file_space, transfer, data)
                    : H5Dread(dataset, type, memory_space, file_space, transfer, data)) >= 0;
  }
  check(good, name);
}

template <class T>
void File::write_rows(const std::string& name, const std::vector<T>& data, int columns, GlobalIndex begin,
                      GlobalIndex total) {
  const std::vector<GlobalIndex> shape =
      columns == 1 ? std::vector<GlobalIndex>{total} : std::vector<GlobalIndex>{total, columns};
  const Scoped dataset(create_dataset(name, type_of<T>(), shape), H5Dclose);
  transfer_rows(name, dataset, type_of<T>(), begin, static_cast<GlobalIndex>(data.size()) / columns,
                const_cast<T*>(data.data()), true);
}

template <class T>
std::vector<T> File::read_rows(const std::string& name, GlobalIndex begin, GlobalIndex count) const {
  const std::array<GlobalIndex, 2> extent = shape(name);
  const Scoped dataset(H5Dopen2(handle_, name.c_str(), H5P_DEFAULT), H5Dclose);
  check(dataset.good() && begin >= 0 && count >= 0 && begin + count <= extent[0], name);
  std::vector<T> data(static_cast<std::size_t>(count * extent[1]));
  transfer_rows(name, dataset, type_of<T>(), begin, count, data.data(), false);
  return data;
}

template void File::write_rows(const std::string&, const std::vector<double>&, int, GlobalIndex, GlobalIndex);
template void File::write_rows(const std::string&, const std::vector<std::int32_t>&, int, GlobalIndex, GlobalIndex);
template void File::write_rows(const std::string&, const std::vector<std::int64_t>&, int, GlobalIndex, GlobalIndex);
template std::vector<double> File::read_rows(const std::string&, GlobalIndex, GlobalIndex) const;
template std::vector<std::int32_t> File::read_rows(const std::string&, GlobalIndex, GlobalIndex) const;
template std::vector<std::int64_t> File::read_rows(const std::string&, GlobalIndex, GlobalIndex) const;

void File::write_strings(const std::string& name, const std::vector<std::string>& data, GlobalIndex begin,
                         GlobalIndex total) {
  GlobalIndex length = 1;
  for (const std::string& text : data) length = std::max(length, static_cast<GlobalIndex>(text.size()));
  if (parallel()) length = comm_->max(length);
  std::vector<char> packed(data.size() * static_cast<std::size_t>(length), '\0');
  for (std::size_t i = 0; i < data.size(); ++i)
    std::copy(data[i].begin(), data[i].end(), packed.begin() + static_cast<std::ptrdiff_t>(i) * length);
  const Scoped type(string_type(static_cast<std::size_t>(length)), H5Tclose);
  const Scoped dataset(create_dataset(name, type, {total}), H5Dclose);
  transfer_rows(name, dataset, type, begin, static_cast<GlobalIndex>(data.size()), packed.data(), true);
}

std::vector<std::string> File::read_strings(const std::string& name, GlobalIndex begin, GlobalIndex count) const {
  const std::array<GlobalIndex, 2> extent = shape(name);
  const Scoped dataset(H5Dopen2(handle_, name.c_str(), H5P_DEFAULT), H5Dclose);
  const Scoped type(dataset.good() ? H5Dget_type(dataset) : -1, H5Tclose);
  const bool good = type.good() && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0 && begin >= 0 &&
                    count >= 0 && begin + count <= extent[0];
  check(good, name);
  const std::size_t length = H5Tget_size(type);
  std::vector<char> packed(static_cast<std::size_t>(count) * length);
  transfer_rows(name, dataset, type, begin, count, packed.data(), false);
  std::vector<std::string> data;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    const char* text = packed.data() + i * length;
    data.emplace_back(text, strnlen(text, length));
  }
  return data;
}

void File::write_text(const std::string& name, const std::string& text) {
  const Scoped type(string_type(text.size()), H5Tclose);
  const Scoped dataset(create_dataset(name, type, {}), H5Dclose);
  check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.c_str()) >= 0, name);
}

std::string File::read_text(const std::string& name) const {
  const Scoped dataset(has(name) ? H5Dopen2(handle_, name.c_str(), H5P_DEFAULT) : -1, H5Dclose);
  const Scoped type(dataset.good() ? H5Dget_type(dataset) : -1, H5Tclose);
  const bool good = type.good() && H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0;
  std::string text(good ? H5Tget_size(type) : 0, '\0');
  check(good && H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data()) >= 0, name);
  text.resize(std::min(text.find('\0'), text.size()));
  return text;
}

void File::link(const std::string& name, const std::string& file, const std::string& target) {
  const Scoped links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  errno = 0;
  check(H5Lcreate_external(file.c_str(), target.c_str(), handle_, name.c_str(), links, H5P_DEFAULT) >= 0, name);
}

}  // namespace fbi::io
