#include "io/pending_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/error.hpp"

namespace fbi::io {
namespace {

const char* remedy(int error_number) {
  switch (error_number) {
    case ENOSPC:
    case EDQUOT:
      return "make room on the disk or write to another place";
    case EFBIG:
      return "raise the file-size limit (ulimit -f)";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a directory you may write to";
    case ENOENT:
    case ENOTDIR:
      return "create the directory first or choose another one";
    default:
      return "check the disk and try again";
  }
}

bool cannot_reserve(int error_number) {
  return error_number == EOPNOTSUPP || error_number == ENOSYS || error_number == EINTR;
}

// Makes sure that `bytes` fit, where the file system can tell; 0 or the error number.
int reserve(int descriptor, GlobalIndex bytes) {
  if (bytes <= 0) return 0;
  if (fallocate(descriptor, 0, 0, bytes) == 0) return ftruncate(descriptor, 0) == 0 ? 0 : errno;
  return cannot_reserve(errno) ? 0 : errno;
}

std::string directory_of(const std::string& path) {
  const std::string parent = std::filesystem::path(path).parent_path().string();
  return parent.empty() ? "." : parent;
}

// Errors of fsync that only say that this kind of file cannot be synced.
bool cannot_sync(int error_number) { return error_number == EINVAL || error_number == ENOTSUP; }

}  // namespace

void throw_write_error(const std::string& path, int error_number) {
  throw Error(ExitCode::file, "cannot write \"" + path +
                                  "\": " + (error_number ? std::strerror(error_number) : "write failed") + "; " +
                                  remedy(error_number));
}

void survive_file_size_limit() { std::signal(SIGXFSZ, SIG_IGN); }

PendingFile::PendingFile(const std::string& path, GlobalIndex expected_bytes)
    : path_(path), temporary_(path + ".tmp." + std::to_string(getpid())) {
  survive_file_size_limit();
  const int descriptor = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) throw_write_error(path_, errno);
  int error = reserve(descriptor, expected_bytes);
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error == 0) return;
  unlink(temporary_.c_str());
  throw_write_error(path_, error);
}

PendingFile::PendingFile(PendingFile&& other) noexcept
    : path_(std::move(other.path_)), temporary_(std::move(other.temporary_)) {
  other.temporary_.clear();
}

PendingFile::~PendingFile() {
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void PendingFile::commit() {
  sync_file(temporary_);
  if (rename(temporary_.c_str(), path_.c_str()) != 0) throw_write_error(path_, errno);
  temporary_.clear();
  const int directory = open(directory_of(path_).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (directory >= 0) {
    fsync(directory);  // some file systems cannot sync a directory; the rename is done all the same
    close(directory);
  }
}

void sync_file(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDWR | O_CLOEXEC);
  if (descriptor < 0) throw_write_error(path, errno);
  int error = fsync(descriptor) == 0 || cannot_sync(errno) ? 0 : errno;
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error) throw_write_error(path, error);
}

void PendingFile::write(const char* data, std::size_t size) {
  const int descriptor = open(temporary_.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) throw_write_error(path_, errno);
  std::size_t done = 0;
  int error = 0;
  while (done < size && error == 0) {
    const ssize_t written = ::write(descriptor, data + done, size - done);
    if (written >= 0)
      done += static_cast<std::size_t>(written);
    else if (errno != EINTR)
      error = errno;
  }
  if (close(descriptor) != 0 && error == 0) error = errno;
  if (error) throw_write_error(path_, error);
}

void reserve_room(const std::string& path, GlobalIndex bytes) {
  const int descriptor = open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) throw_write_error(path, errno);
  const int error =
      bytes <= 0 || fallocate(descriptor, FALLOC_FL_KEEP_SIZE, 0, bytes) == 0 || cannot_reserve(errno) ? 0 : errno;
  close(descriptor);
  if (error) throw_write_error(path, error);
}

void write_text_file(const std::string& path, const std::string& text) {
  PendingFile pending(path);
  pending.write(text.data(), text.size());
  pending.commit();
}

std::string read_text_file(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  std::ostringstream text;
  if (stream) text << stream.rdbuf();
  if (!stream)
    throw Error(ExitCode::file, "cannot read \"" + path + "\": " + std::strerror(errno) + "; check the name");
  return text.str();
}

int remove_leftovers(const std::string& directory, const std::string& file) {
  std::error_code error;
  int removed = 0;
  for (const auto& entry : std::filesystem::directory_iterator(directory.empty() ? "." : directory, error)) {
    const std::string name = entry.path().filename().string();
    const std::size_t mark = name.rfind(".tmp.");
    if (mark == std::string::npos || name.find_first_not_of("0123456789", mark + 5) != std::string::npos) continue;
    if (!file.empty() && name.substr(0, mark) != file) continue;
    std::error_code ignored;
    removed += std::filesystem::remove(entry.path(), ignored);
  }
  return removed;
}

void make_directory(const std::string& path) {
  std::error_code error;
  std::filesystem::create_directories(path, error);
  if (error)
    throw Error(ExitCode::file,
                "cannot create directory \"" + path + "\": " + error.message() + "; " + remedy(error.value()));
}

}  // namespace fbi::io
