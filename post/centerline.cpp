/// Center lines of two runs, or of a run and a formula, at the same material points.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/quadrature.hpp"
#include "io/format.hpp"
#include "post/center_line.hpp"
#include "post/difference.hpp"

namespace fbi::post {
namespace {

std::map<std::string, CenterLine> read_lines(const Run& run, io::StepTime output) {
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  const io::File fields = io::open_kind(run.paths.step(output.step), io::FileKind::step);
  if (!mesh.has("/fibers") || !fields.has("/fibers/dofs"))
    throw Error(ExitCode::usage, "run \"" + run.name + "\" has no fibers, so there are no center lines to compare");
  const std::vector<double> reference = mesh.read<double>("/fibers/reference_dofs"),
                            current = fields.read<double>("/fibers/dofs");
  std::vector<GlobalIndex> first = mesh.read<GlobalIndex>("/fibers/first_node");
  const std::vector<std::string> names = mesh.read_strings("/fibers/names", 0, static_cast<GlobalIndex>(first.size()));
  first.push_back(static_cast<GlobalIndex>(reference.size() / 6));
  std::map<std::string, CenterLine> lines;
  for (std::size_t f = 0; f < names.size(); ++f) {
    const auto begin = static_cast<std::ptrdiff_t>(6 * first[f]), end = static_cast<std::ptrdiff_t>(6 * first[f + 1]);
    lines.emplace(names[f], CenterLine({reference.begin() + begin, reference.begin() + end},
                                       {current.begin() + begin, current.begin() + end}));
  }
  return lines;
}

struct Pair {
  Vec3 difference, reference;
};

// Adds the integrals along one fiber; between `shares` everything is a cubic.
void integrate(const std::vector<double>& shares, double length, int points, Difference& result,
               const std::function<Pair(double)>& sample) {
  const fem::QuadratureRule rule = fem::gauss_legendre(points);
  for (std::size_t i = 0; i + 1 < shares.size(); ++i)
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      const double half = 0.5 * (shares[i + 1] - shares[i]), weight = rule.weights[p] * half * length;
      const Pair pair = sample(shares[i] + half * (1.0 + rule.points[p]));
      result.l2 += weight * pair.difference.squaredNorm();
      result.l2_reference += weight * pair.reference.squaredNorm();
      result.largest = std::max(result.largest, pair.difference.norm());
      result.largest_reference = std::max(result.largest_reference, pair.reference.norm());
      result.measure += weight;
    }
}

Difference finished(Difference result, double time) {
  result.field = "centerline";
  result.time = time;
  result.l2 = std::sqrt(result.l2);
  result.l2_reference = std::sqrt(result.l2_reference);
  return result;
}

}  // namespace

Difference centerline_difference(const Run& run, const Run& reference, const DifferenceOptions& options) {
  const std::array<io::StepTime, 2> outputs = choose_outputs(run, reference, options.at);
  const std::map<std::string, CenterLine> lines = read_lines(run, outputs[0]),
                                          others = read_lines(reference, outputs[1]);
  Difference result;
  for (const auto& [name, line] : lines) {
    const auto other = others.find(name);
    if (other == others.end() || lines.size() != others.size())
      throw Error(ExitCode::usage,
                  log::format("runs \"%s\" and \"%s\" do not have the same fibers (%zu and %zu; \"%s\" is %s); compare "
                              "runs whose fibers have the same names",
                              run.name.c_str(), reference.name.c_str(), lines.size(), others.size(), name.c_str(),
                              other == others.end() ? "in the first one only" : "in both"));
    std::vector<double> shares = line.shares(), more = other->second.shares();
    shares.insert(shares.end(), more.begin(), more.end());
    std::sort(shares.begin(), shares.end());
    shares.erase(std::unique(shares.begin(), shares.end(), [](double a, double b) { return b - a < 1e-12; }),
                 shares.end());
    integrate(shares, other->second.length(), std::max(4, options.points), result, [&](double share) {
      const Vec3 there = other->second.current(share);
      return Pair{line.current(share) - there, there - other->second.reference(share)};
    });
    result.cells += static_cast<GlobalIndex>(line.elements());
  }
  return finished(result, outputs[0].time);
}

Difference centerline_difference(const Run& run, const std::vector<input::Expression>& exact,
                                 const DifferenceOptions& options) {
  if (exact.size() != 3) throw Error(ExitCode::usage, "center lines need three formulas, one for each coordinate");
  const io::StepTime output = choose_output(run, options.at);
  Difference result;
  for (const auto& [name, line] : read_lines(run, output)) {
    integrate(line.shares(), line.length(), std::max(8, options.points), result, [&](double share) {
      const Vec3 place = line.reference(share);
      const Vec3 there(exact[0](place, output.time), exact[1](place, output.time), exact[2](place, output.time));
      if (!there.allFinite())
        throw Error(ExitCode::usage, log::format("the exact center line of fiber \"%s\" is not finite at (%g, %g, %g)",
                                                 name.c_str(), place[0], place[1], place[2]));
      return Pair{line.current(share) - there, there - place};
    });
    result.cells += static_cast<GlobalIndex>(line.elements());
  }
  return finished(result, output.time);
}

}  // namespace fbi::post
