/// Center lines of two runs, or of a run and a formula, at the same material points.
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"
#include "io/format.hpp"
#include "post/difference.hpp"

namespace fbi::post {
namespace {

// A chain of Hermite elements, in its reference and its current shape.
class CenterLine {
 public:
  CenterLine(std::vector<double> reference, std::vector<double> current)
      : reference_(std::move(reference)), current_(std::move(current)) {
    const fem::QuadratureRule rule = fem::gauss_legendre(8);
    breaks_ = {0.0};
    for (std::size_t e = 0; e + 1 < reference_.size() / 6; ++e) {
      // The length belongs to the element: l = int |r'| with r = sum H^d d + l/2 H^t t.
      const double* q = &reference_[6 * e];
      double length = (Eigen::Map<const Vec3>(q + 6) - Eigen::Map<const Vec3>(q)).norm();
      for (int iteration = 0; iteration < 100; ++iteration) {
        double next = 0.0;
        for (std::size_t p = 0; p < rule.points.size(); ++p)
          next += rule.weights[p] * shape(q, fem::hermite_first(rule.points[p]), length).norm();
        const bool done = std::abs(next - length) <= 1e-15 * length;
        length = next;
        if (done) break;
      }
      breaks_.push_back(breaks_.back() + length);
    }
  }

  double length() const { return breaks_.back(); }
  std::size_t elements() const { return breaks_.size() - 1; }
  // Shares of the length at which elements begin and end.
  std::vector<double> shares() const {
    std::vector<double> shares;
    for (const double s : breaks_) shares.push_back(s / length());
    return shares;
  }
  Vec3 current(double share) const { return at(current_, share); }
  Vec3 reference(double share) const { return at(reference_, share); }

 private:
  static Vec3 shape(const double* q, const std::array<double, 4>& h, double length) {
    const Eigen::Map<const Vec3> d1(q), t1(q + 3), d2(q + 6), t2(q + 9);
    return h[0] * d1 + 0.5 * length * h[1] * t1 + h[2] * d2 + 0.5 * length * h[3] * t2;
  }
  Vec3 at(const std::vector<double>& dofs, double share) const {
    const double s = share * length();
    const auto above = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, s);
    const std::size_t e = static_cast<std::size_t>(above - breaks_.begin()) - 1;
    const double l = breaks_[e + 1] - breaks_[e];
    return shape(&dofs[6 * e], fem::hermite(2.0 * (s - breaks_[e]) / l - 1.0), l);
  }
  std::vector<double> reference_, current_;  // shape=(nodes,6)
  std::vector<double> breaks_;               // reference arc length of the nodes
};

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
