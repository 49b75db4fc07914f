#include "post/difference.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "fem/quadrature.hpp"
#include "io/format.hpp"
#include "post/hex_field.hpp"

namespace fbi::post {
namespace {

// A scalar has zeros in the components that it does not have.
using Components = Vec3;
using Gradients = Mat3;

// A field that can be evaluated anywhere.
class Sampler {
 public:
  virtual ~Sampler() = default;
  // Value and, when `gradient` is not null, gradient at a point; false where the field is not. `size`: of a cell there.
  virtual bool sample(const Vec3& x, double size, Components& value, Gradients* gradient) = 0;
};

class MeshField : public Sampler {
 public:
  MeshField(const Run& run, io::StepTime output, const std::string& name) : grid(Grid::read(run)), locator_(grid) {
    const io::File file = io::open_kind(run.paths.step(output.step), io::FileKind::step);
    if (!file.has("/fluid/" + name)) {
      std::string known;
      for (const std::string& other : file.children("/fluid")) known += other + ", ";
      throw Error(ExitCode::usage, "run \"" + run.name + "\" has no field \"" + name + "\"; it has: " + known +
                                       "and centerline where there are fibers");
    }
    components = static_cast<int>(file.shape("/fluid/" + name)[1]);
    values_ = file.read<double>("/fluid/" + name);
  }

  bool sample(const Vec3& x, double, Components& value, Gradients* gradient) override {
    Vec3 xi;
    const Index cell = locator_.find(x, xi);
    if (cell < 0) return false;
    evaluate(cell, xi, value, gradient);
    return true;
  }

  void evaluate(Index cell, const Vec3& xi, Components& value, Gradients* gradient) const {
    const std::array<Index, 8> nodes = grid.cell_nodes(cell);
    const std::array<double, 8> shape = fem::hex8_shape(xi);
    value.setZero();
    for (int a = 0; a < 8; ++a)
      for (int i = 0; i < components; ++i)
        value[i] += shape[a] * values_[static_cast<std::size_t>(components) * nodes[a] + i];
    if (gradient == nullptr) return;
    const Eigen::Matrix<double, 8, 3> local = fem::hex8_gradient(xi);
    const Mat3 inverse = Mat3(grid.corners(cell) * local).inverse();
    gradient->setZero();
    for (int a = 0; a < 8; ++a) {
      const Eigen::RowVector3d slope = local.row(a) * inverse;
      for (int i = 0; i < components; ++i)
        gradient->row(i) += values_[static_cast<std::size_t>(components) * nodes[a] + i] * slope;
    }
  }

  Grid grid;
  int components = 1;

 private:
  Locator locator_;
  std::vector<double> values_;  // shape=(nodes,components)
};

class Formulas : public Sampler {
 public:
  Formulas(const std::vector<input::Expression>& formulas, double time) : formulas_(formulas), time_(time) {}

  bool sample(const Vec3& x, double size, Components& value, Gradients* gradient) override {
    evaluate(x, value);
    if (gradient == nullptr) return true;
    const double step = 1e-2 * size;
    Components plus = Components::Zero(), minus = plus;
    gradient->setZero();
    for (int d = 0; d < 3; ++d)
      for (const auto& [distance, weight] : {std::pair{1.0, 2.0 / 3.0}, std::pair{2.0, -1.0 / 12.0}}) {
        Vec3 shift = Vec3::Zero();
        shift[d] = distance * step;
        evaluate(x + shift, plus);
        evaluate(x - shift, minus);
        gradient->col(d) += weight / step * (plus - minus);
      }
    return true;
  }

 private:
  void evaluate(const Vec3& x, Components& value) const {
    value.setZero();
    for (std::size_t i = 0; i < formulas_.size(); ++i) {
      value[static_cast<Eigen::Index>(i)] = formulas_[i](x, time_);
      if (!std::isfinite(value[static_cast<Eigen::Index>(i)]))
        throw Error(ExitCode::usage, log::format("\"%s\" is not finite at (%g, %g, %g), t = %g",
                                                 formulas_[i].text().c_str(), x[0], x[1], x[2], time_));
    }
  }
  const std::vector<input::Expression>& formulas_;
  double time_;
};

// Squares of a field and of its deviation from its mean, summed about its first value so that a large mean costs no
// digits.
class Moments {
 public:
  void add(const Components& value, double weight) {
    if (weight_ == 0.0) shift_ = value;
    const Components moved = value - shift_;
    squares_ += weight * value.squaredNorm();
    moved_squares_ += weight * moved.squaredNorm();
    sum_ += weight * moved;
    weight_ += weight;
  }
  double norm(bool without_mean) const {
    if (weight_ == 0.0) return 0.0;
    if (!without_mean) return std::sqrt(squares_);
    return std::sqrt(std::max(0.0, moved_squares_ - sum_.squaredNorm() / weight_));
  }
  double weight() const { return weight_; }
  Components mean() const { return Components(shift_ + sum_ / weight_); }

 private:
  Components shift_ = Components::Zero(), sum_ = Components::Zero();
  double squares_ = 0.0, moved_squares_ = 0.0, weight_ = 0.0;
};

// The integrals over the cells of `own`, with `other` at the same points. The difference is first - second, where `own`
// is the first or the second one.
class Integral {
 public:
  Integral(const MeshField& own, Sampler& other, const MeshField* same_cells, bool own_is_reference,
           const DifferenceOptions& options)
      : own_(own), other_(other), same_cells_(same_cells), own_is_reference_(own_is_reference), options_(options) {
    const fem::QuadratureRule rule = fem::gauss_legendre(options.points);
    for (int c = 0; c < options.points; ++c)
      for (int b = 0; b < options.points; ++b)
        for (int a = 0; a < options.points; ++a) {
          const Vec3 xi(rule.points[a], rule.points[b], rule.points[c]);
          const std::array<double, 8> shape = fem::hex8_shape(xi);
          points_.push_back({xi, Eigen::Map<const Eigen::Matrix<double, 8, 1>>(shape.data()), fem::hex8_gradient(xi),
                             rule.weights[a] * rule.weights[b] * rule.weights[c]});
        }
  }

  Difference run() {
    visit(false);
    if (options_.remove_mean && difference_.weight() > 0.0) visit(true);  // the largest values without the means
    Difference result;
    result.l2 = difference_.norm(options_.remove_mean);
    result.l2_reference = reference_.norm(options_.remove_mean);
    result.largest = largest_;
    result.largest_reference = largest_reference_;
    result.h1 = std::sqrt(gradient_difference_);
    result.h1_reference = std::sqrt(gradient_reference_);
    result.measure = difference_.weight();
    return result;
  }

 private:
  struct Point {
    Vec3 xi;
    Eigen::Matrix<double, 8, 1> shape;
    Eigen::Matrix<double, 8, 3> gradient;
    double weight;
  };

  void visit(bool only_largest) {
    Components mine, theirs, mean = Components::Zero(), mean_reference = mean;
    Gradients my_gradient = Gradients::Zero(), their_gradient = my_gradient;
    const bool gradients = options_.with_gradient && !only_largest;
    if (only_largest) {
      mean = difference_.mean();
      mean_reference = reference_.mean();
      largest_ = largest_reference_ = 0.0;
    }
    for (Index cell = 0; cell < own_.grid.cells(); ++cell) {
      const Grid::Corners corners = own_.grid.corners(cell);
      for (const Point& point : points_) {
        const double volume = Mat3(corners * point.gradient).determinant();
        const Vec3 x = corners * point.shape;
        if (same_cells_ != nullptr)
          same_cells_->evaluate(cell, point.xi, theirs, gradients ? &their_gradient : nullptr);
        else if (!other_.sample(x, std::cbrt(8.0 * std::abs(volume)), theirs, gradients ? &their_gradient : nullptr))
          continue;
        own_.evaluate(cell, point.xi, mine, gradients ? &my_gradient : nullptr);
        const double weight = point.weight * volume;
        Components difference = own_is_reference_ ? Components(theirs - mine) : Components(mine - theirs);
        const Components& reference = own_is_reference_ ? mine : theirs;
        if (only_largest) {
          largest_ = std::max(largest_, (difference - mean).norm());
          largest_reference_ = std::max(largest_reference_, (reference - mean_reference).norm());
          continue;
        }
        difference_.add(difference, weight);
        reference_.add(reference, weight);
        largest_ = std::max(largest_, difference.norm());
        largest_reference_ = std::max(largest_reference_, reference.norm());
        if (!gradients) continue;
        gradient_difference_ += weight * (my_gradient - their_gradient).squaredNorm();
        gradient_reference_ += weight * (own_is_reference_ ? my_gradient : their_gradient).squaredNorm();
      }
    }
  }

  const MeshField& own_;
  Sampler& other_;
  const MeshField* same_cells_;
  bool own_is_reference_;
  const DifferenceOptions& options_;
  std::vector<Point> points_;
  Moments difference_, reference_;
  double largest_ = 0.0, largest_reference_ = 0.0, gradient_difference_ = 0.0, gradient_reference_ = 0.0;
};

}  // namespace

Difference field_difference(const Run& run, const Run& reference, const DifferenceOptions& options) {
  if (options.field == "centerline") return centerline_difference(run, reference, options);
  const std::array<io::StepTime, 2> outputs = choose_outputs(run, reference, options.at);
  MeshField first(run, outputs[0], options.field), second(reference, outputs[1], options.field);
  const bool same = first.grid == second.grid;
  const bool second_is_finer = second.grid.cells() > first.grid.cells();
  const bool on_second = !same && (options.on_coarse ? !second_is_finer : second_is_finer);
  Integral integral(on_second ? second : first, on_second ? first : second, same ? &second : nullptr, on_second,
                    options);
  Difference result = integral.run();
  const double larger = std::max(first.grid.volume(), second.grid.volume());
  result.uncovered = 1.0 - result.measure / larger;
  if (result.uncovered < 1e-12) result.uncovered = 0.0;
  if (result.measure <= 0.0)
    throw Error(ExitCode::geometry, "the fluids of runs \"" + run.name + "\" and \"" + reference.name +
                                        "\" have no volume in common; compare runs of the same domain");
  if (result.uncovered > options.allowed_uncovered)
    throw Error(ExitCode::geometry,
                log::format("%.3g %% of the volume lies in only one of the runs \"%s\" and \"%s\"; compare runs of the "
                            "same domain, or allow it with --uncovered %.2g",
                            100.0 * result.uncovered, run.name.c_str(), reference.name.c_str(),
                            std::min(1.0, 1.1 * result.uncovered)));
  result.field = options.field;
  result.time = outputs[0].time;
  result.cells = first.grid.cells();
  return result;
}

Difference field_difference(const Run& run, const std::vector<input::Expression>& exact,
                            const DifferenceOptions& options) {
  if (options.field == "centerline") return centerline_difference(run, exact, options);
  const io::StepTime output = choose_output(run, options.at);
  const MeshField field(run, output, options.field);
  if (exact.size() != static_cast<std::size_t>(field.components))
    throw Error(ExitCode::usage, log::format("field \"%s\" has %d components but %zu formulas are given",
                                             options.field.c_str(), field.components, exact.size()));
  Formulas formulas(exact, output.time);
  Difference result = Integral(field, formulas, nullptr, false, options).run();
  result.field = options.field;
  result.time = output.time;
  result.cells = field.grid.cells();
  return result;
}

std::vector<input::Expression> parse_formulas(const std::string& text, std::size_t components,
                                              const std::string& option) {
  std::vector<std::string> parts(1);
  int depth = 0;
  for (const char c : text) {
    depth += c == '(' ? 1 : c == ')' ? -1 : 0;
    if (c == ',' && depth == 0)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  if (parts.size() != components)
    throw Error(ExitCode::usage,
                log::format("%s needs %zu formula%s of x, y, z and t, separated by commas, and has %zu", option.c_str(),
                            components, components > 1 ? "s" : "", parts.size()));
  std::vector<input::Expression> formulas;
  for (const std::string& part : parts) try {
      formulas.emplace_back(part);
    } catch (const std::invalid_argument& error) {
      throw Error(ExitCode::usage, option + ": \"" + part + "\": " + error.what());
    }
  return formulas;
}

}  // namespace fbi::post
