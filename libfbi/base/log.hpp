/// What the programs say on the terminal: rank 0 speaks, the others are silent.
#pragma once

#include <string>

namespace fbi::log {

/// Sets who speaks: `speaks` is false on all ranks but 0; `quiet` leaves only warnings and errors.
void configure(bool speaks, bool quiet);

/// printf-like line to standard output (not when quiet).
void info(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// printf-like line "warning: ..." to standard error.
void warning(const char* format, ...) __attribute__((format(printf, 1, 2)));
/// printf-like line "error: ..." to standard error.
void error(const char* format, ...) __attribute__((format(printf, 1, 2)));

/// printf into a string.
std::string format(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace fbi::log
