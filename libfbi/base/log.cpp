#include "base/log.hpp"

#include <cstdarg>
#include <cstdio>

namespace fbi::log {
namespace {

bool speaks_ = true;
bool quiet_ = false;

std::string text(const char* format, va_list arguments) {
  va_list copy;
  va_copy(copy, arguments);
  const int length = std::vsnprintf(nullptr, 0, format, copy);
  va_end(copy);
  std::string result(length > 0 ? length : 0, '\0');
  std::vsnprintf(result.data(), result.size() + 1, format, arguments);
  return result;
}

void say(std::FILE* stream, const char* prefix, const char* format, va_list arguments) {
  const std::string line = text(format, arguments);
  std::fprintf(stream, "%s%s\n", prefix, line.c_str());
  std::fflush(stream);
}

}  // namespace

void configure(bool speaks, bool quiet) {
  speaks_ = speaks;
  quiet_ = quiet;
}

void info(const char* format, ...) {
  if (!speaks_ || quiet_) return;
  va_list arguments;
  va_start(arguments, format);
  say(stdout, "", format, arguments);
  va_end(arguments);
}

void warning(const char* format, ...) {
  if (!speaks_) return;
  va_list arguments;
  va_start(arguments, format);
  say(stderr, "warning: ", format, arguments);
  va_end(arguments);
}

void error(const char* format, ...) {
  if (!speaks_) return;
  va_list arguments;
  va_start(arguments, format);
  say(stderr, "error: ", format, arguments);
  va_end(arguments);
}

std::string format(const char* format, ...) {
  va_list arguments;
  va_start(arguments, format);
  std::string result = text(format, arguments);
  va_end(arguments);
  return result;
}

}  // namespace fbi::log
