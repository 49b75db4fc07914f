#include "post/history_series.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <unsupported/Eigen/FFT>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::post {
namespace {

double at(const Series& series, std::size_t i, double t) {
  const double share = (t - series.time[i]) / (series.time[i + 1] - series.time[i]);
  return (1.0 - share) * series.value[i] + share * series.value[i + 1];
}

// Integral between two times by the trapezoidal rule.
double integral(const Series& series, double begin, double end) {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < series.time.size(); ++i) {
    const double from = std::max(begin, series.time[i]), to = std::min(end, series.time[i + 1]);
    if (to > from) sum += 0.5 * (at(series, i, from) + at(series, i, to)) * (to - from);
  }
  return sum;
}

// Times of the upward crossings of the middle.
std::vector<double> crossings(const Series& series, double middle, double range) {
  std::vector<double> times;
  bool armed = false;
  for (std::size_t i = 0; i < series.value.size(); ++i) {
    if (armed && i > 0 && series.value[i - 1] < middle && series.value[i] >= middle) {
      const double share = (middle - series.value[i - 1]) / (series.value[i] - series.value[i - 1]);
      times.push_back(series.time[i - 1] + share * (series.time[i] - series.time[i - 1]));
      armed = false;
    }
    if (series.value[i] < middle - 0.25 * range) armed = true;
  }
  return times;
}

double spectral_peak(const Series& series) {
  const std::size_t count = series.time.size();
  if (count < 8) return 0.0;
  const double begin = series.time.front(), duration = series.time.back() - begin;
  const std::size_t samples = std::size_t{1} << static_cast<int>(std::ceil(std::log2(static_cast<double>(count))));
  std::vector<double> values(4 * samples, 0.0);  // zeros behind refine the spectrum
  const double mean = integral(series, begin, series.time.back()) / duration;
  std::size_t i = 0;
  for (std::size_t k = 0; k < samples; ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(samples - 1), t = begin + share * duration;
    while (i + 2 < count && series.time[i + 1] < t) ++i;
    values[k] = (at(series, i, t) - mean) * (0.5 - 0.5 * std::cos(2.0 * M_PI * share));
  }
  Eigen::FFT<double> transform;
  std::vector<std::complex<double>> spectrum;
  transform.fwd(spectrum, values);
  std::size_t peak = 0;
  const std::size_t lowest = 6, last = values.size() / 2;  // below, the window sees no whole period
  for (std::size_t k = lowest; k < last; ++k)
    if (peak == 0 || std::norm(spectrum[k]) > std::norm(spectrum[peak])) peak = k;
  if (peak <= lowest || peak + 1 >= last || std::norm(spectrum[peak]) == 0.0) return 0.0;
  const double before = std::log(std::norm(spectrum[peak - 1]) + 1e-300), there = std::log(std::norm(spectrum[peak])),
               after = std::log(std::norm(spectrum[peak + 1]) + 1e-300);
  const double bend = before - 2.0 * there + after;
  const double shift = bend < 0.0 ? 0.5 * (before - after) / bend : 0.0;
  const double interval = duration / static_cast<double>(samples - 1);
  return (static_cast<double>(peak) + shift) / (static_cast<double>(values.size()) * interval);
}

}  // namespace

const io::HistoryTable& history_of(const Run& run) {
  if (!run.history || run.history->rows.empty())
    throw Error(ExitCode::file, "\"" + run.paths.csv + "\" has no rows yet; wait for the first step");
  return *run.history;
}

Series read_series(const Run& run, const std::string& column, std::optional<double> from) {
  const io::HistoryTable& history = history_of(run);
  const int at = history.column(column), time = history.column("time");
  if (at < 0 || time < 0) {
    std::string known;
    for (const std::string& name : history.columns) known += (known.empty() ? "" : ", ") + name;
    throw Error(ExitCode::usage,
                "the history of run \"" + run.name + "\" has no column \"" + column + "\"; it has: " + known);
  }
  Series series{column, history.units[static_cast<std::size_t>(at)], {}, {}};
  for (const std::vector<double>& row : history.rows) {
    if (from && row[time] < *from * (1.0 - 1e-12)) continue;
    series.time.push_back(row[time]);
    series.value.push_back(row[at]);
  }
  if (series.time.empty())
    throw Error(ExitCode::usage, log::format("run \"%s\" ends at time %g, before --from %g", run.name.c_str(),
                                             history.rows.back()[time], *from));
  return series;
}

Statistics statistics(const Series& series) {
  Statistics s;
  const auto [low, high] = std::minmax_element(series.value.begin(), series.value.end());
  s.smallest = *low;
  s.largest = *high;
  s.middle = 0.5 * (*low + *high);
  s.amplitude = 0.5 * (*high - *low);
  const double duration = series.time.back() - series.time.front();
  s.mean = duration > 0.0 ? integral(series, series.time.front(), series.time.back()) / duration : series.value.back();
  const double range = s.largest - s.smallest;
  if (range <= 1e-12 * std::max(std::abs(s.largest), std::abs(s.smallest))) return s;
  const std::vector<double> times = crossings(series, s.middle, range);
  if (times.size() < 3) return s;
  s.periods = static_cast<GlobalIndex>(times.size()) - 1;
  const double period = (times.back() - times.front()) / static_cast<double>(s.periods);
  s.frequency = 1.0 / period;
  for (std::size_t i = 0; i + 1 < times.size(); ++i)
    s.scatter = std::max(s.scatter, std::abs(times[i + 1] - times[i] - period) / period);
  s.mean = integral(series, times.front(), times.back()) / (times.back() - times.front());
  double smallest = INFINITY, largest = -INFINITY;
  for (std::size_t i = 0; i < series.time.size(); ++i)
    if (series.time[i] >= times[times.size() - 2] && series.time[i] <= times.back()) {
      smallest = std::min(smallest, series.value[i]);
      largest = std::max(largest, series.value[i]);
    }
  if (largest > smallest) {
    s.middle = 0.5 * (largest + smallest);
    s.amplitude = 0.5 * (largest - smallest);
  }
  s.spectral = spectral_peak(series);
  return s;
}

}  // namespace fbi::post
