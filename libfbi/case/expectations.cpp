#include "case/expectations.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::cases {

Expectations::Expectations(const std::vector<Expectation>& expected, const std::vector<std::string>& columns) {
  std::string problem;
  for (const Expectation& expectation : expected) {
    const auto found = std::find(columns.begin(), columns.end(), expectation.quantity);
    if (found == columns.end()) {
      problem +=
          log::format("expect: \"%s\" is not a column of the history; the columns are", expectation.quantity.c_str());
      for (const std::string& column : columns) problem += " " + column;
      problem += "\n";
      continue;
    }
    watched_.push_back({expectation, static_cast<std::size_t>(found - columns.begin()), false, 0.0, 1e300});
  }
  if (problem.empty()) return;
  problem.pop_back();
  throw Error(ExitCode::usage, problem);
}

void Expectations::add_row(double t, const std::vector<double>& values) {
  for (Watched& watched : watched_) {
    const double value = values[watched.column];
    if (watched.expected.time) {
      const double distance = std::abs(t - *watched.expected.time);
      if (distance < watched.nearest) {
        watched.nearest = distance;
        watched.value = value;
      }
    } else if (!watched.seen || watched.expected.reduce == "last") {
      watched.value = watched.expected.reduce == "max_abs" ? std::abs(value) : value;
    } else if (watched.expected.reduce == "max") {
      watched.value = std::max(watched.value, value);
    } else if (watched.expected.reduce == "min") {
      watched.value = std::min(watched.value, value);
    } else if (watched.expected.reduce == "max_abs") {
      watched.value = std::max(watched.value, std::abs(value));
    }
    watched.seen = true;
  }
}

bool Expectations::report() const {
  bool met = true;
  for (const Watched& watched : watched_) {
    const Expectation& expected = watched.expected;
    const double error = std::abs(watched.value - expected.value);
    const double limit = expected.relative ? expected.tolerance * std::abs(expected.value) : expected.tolerance;
    const bool good = watched.seen && error <= limit;
    met = met && good;
    const std::string when = expected.time ? log::format("at t = %g", *expected.time) : expected.reduce;
    const std::string line = log::format("%-36s %-12s %.8g, expected %.8g +- %.2g", expected.quantity.c_str(),
                                         when.c_str(), watched.value, expected.value, limit);
    if (good)
      log::info("expect  %s: ok", line.c_str());
    else
      log::error("expect  %s: MISSED", line.c_str());
  }
  return met;
}

std::string Expectations::rows(const std::string& case_name) const {
  std::string text;
  for (const Watched& watched : watched_) {
    const Expectation& expected = watched.expected;
    const std::string when = expected.time                ? log::format(" at t = %g", *expected.time)
                             : expected.reduce == "last" ? " at the end"
                                                         : ", " + expected.reduce;
    const double error = std::abs(watched.value - expected.value) / std::abs(expected.value);
    text += "Cases\t" + case_name + "\t" + expected.quantity + when + "\t" + expected.source +
            log::format("\t%.17g\t%.17g\t", expected.value, watched.value) +
            (std::isfinite(error) ? log::format("%.17g", error) : "") + "\t\t" +
            (expected.relative ? log::format("%g %%", 100.0 * expected.tolerance)
                               : log::format("± %g", expected.tolerance)) +
            "\tcases/" + case_name + "\t\n";
  }
  return text;
}

}  // namespace fbi::cases
