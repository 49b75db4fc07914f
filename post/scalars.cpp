#include "post/scalars.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace fbi::post {
namespace {

std::vector<std::string> components(GlobalIndex columns) {
  if (columns == 3) return {"x", "y", "z", "magnitude"};
  if (columns == 6) return {"xx", "xy", "xz", "yy", "yz", "zz"};
  return {};
}

}  // namespace

std::array<double, 2> Scalar::range() const {
  if (values.empty()) return {0.0, 0.0};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double most = std::max(-*low, *high);
  if (std::min(-*low, *high) < 0.25 * most) return {*low, *high};
  return {-most, most};
}

std::vector<double> component_of(const std::vector<double>& vectors, const std::string& component) {
  std::vector<double> values(vectors.size() / 3);
  for (std::size_t n = 0; n < values.size(); ++n) {
    const double* v = &vectors[3 * n];
    values[n] = component == "magnitude" ? std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) : v[component[0] - 'x'];
  }
  return values;
}

Scalar read_scalar(const io::File& step, const std::string& group, const std::string& name, const std::string& also) {
  const std::string wanted = name == "speed"        ? "velocity_magnitude"
                             : name == "mean_speed" ? "mean_velocity_magnitude"
                                                    : name;
  std::string known;
  for (const std::string& field : step.children(group)) {
    if (field == "dofs" || field == "position") continue;
    const std::string path = group + "/" + field;
    const GlobalIndex columns = step.shape(path)[1];
    if (columns == 1) {
      if (field == wanted) return {name, step.read<double>(path)};
      known += (known.empty() ? "" : ", ") + field;
    }
    const std::vector<std::string> parts = components(columns);
    for (std::size_t c = 0; c < parts.size(); ++c) {
      known += (known.empty() ? "" : ", ") + field + "_" + parts[c];
      if (field + "_" + parts[c] != wanted) continue;
      const std::vector<double> all = step.read<double>(path);
      if (columns == 3) return {name, component_of(all, parts[c])};
      Scalar scalar{name, std::vector<double>(all.size() / 6)};
      for (std::size_t n = 0; n < scalar.values.size(); ++n) scalar.values[n] = all[6 * n + c];
      return scalar;
    }
  }
  throw Error(ExitCode::usage, "\"" + step.path() + "\" has no quantity \"" + name + "\" of " + group.substr(1) +
                                   "; there are: " + known + also);
}

}  // namespace fbi::post
