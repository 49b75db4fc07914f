#include "post/outputs.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::post {
namespace {

bool at_time(const io::StepTime& output, double time) {
  return std::abs(output.time - time) <= same_time * std::max({std::abs(time), std::abs(output.time), 1e-300});
}

void check_not_empty(const Run& run) {
  if (run.outputs.empty())
    throw Error(ExitCode::file,
                "\"" + run.paths.index + "\" has no field output yet; set \"every\" in \"output\" or wait");
}

// The last output of that time: a steady run has its start and its solution at the same time.
const io::StepTime* find_time(const Run& run, double time) {
  for (auto output = run.outputs.rbegin(); output != run.outputs.rend(); ++output)
    if (at_time(*output, time)) return &*output;
  return nullptr;
}

io::StepTime output_at_time(const Run& run, double time) {
  if (const io::StepTime* output = find_time(run, time)) return *output;
  std::string near;  // the last one before and the first one after
  const auto after = std::find_if(run.outputs.begin(), run.outputs.end(),
                                  [&](const io::StepTime& output) { return output.time > time; });
  if (after != run.outputs.begin())
    near += log::format("%.10g (step %lld)", (after - 1)->time, static_cast<long long>((after - 1)->step));
  if (after != run.outputs.end())
    near += log::format("%s%.10g (step %lld)", near.empty() ? "" : " and ", after->time,
                        static_cast<long long>(after->step));
  throw Error(ExitCode::usage, log::format("run \"%s\" has no output at time %.10g; the nearest are at %s",
                                           run.name.c_str(), time, near.c_str()));
}

}  // namespace

io::StepTime choose_output(const Run& run, const OutputChoice& choice) {
  check_not_empty(run);
  if (choice.time) return output_at_time(run, *choice.time);
  if (!choice.step) return run.outputs.back();
  std::string known;
  for (const io::StepTime& output : run.outputs)
    if (output.step == *choice.step) return output;
  std::vector<io::StepTime> nearest = run.outputs;
  constexpr std::size_t most = 12;
  if (nearest.size() > most) {
    std::stable_sort(nearest.begin(), nearest.end(), [&](const io::StepTime& a, const io::StepTime& b) {
      return std::abs(a.step - *choice.step) < std::abs(b.step - *choice.step);
    });
    nearest.resize(most);
    std::sort(nearest.begin(), nearest.end(),
              [](const io::StepTime& a, const io::StepTime& b) { return a.step < b.step; });
  }
  for (const io::StepTime& output : nearest) known += (known.empty() ? "" : ", ") + std::to_string(output.step);
  throw Error(ExitCode::usage, "there is no output of step " + std::to_string(*choice.step) + "; there are: " + known +
                                   (run.outputs.size() > most ? log::format(" (%zu in all)", run.outputs.size()) : ""));
}

std::array<io::StepTime, 2> choose_outputs(const Run& first, const Run& second, const OutputChoice& choice) {
  check_not_empty(second);
  if (choice.step || choice.time) {
    const io::StepTime chosen = choose_output(first, choice);
    return {chosen, output_at_time(second, chosen.time)};
  }
  check_not_empty(first);
  for (auto output = first.outputs.rbegin(); output != first.outputs.rend(); ++output)
    if (const io::StepTime* other = find_time(second, output->time)) return {*output, *other};
  return {first.outputs.back(), output_at_time(second, first.outputs.back().time)};  // throws
}

}  // namespace fbi::post
