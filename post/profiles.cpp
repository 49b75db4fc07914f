#include "post/profiles.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "fem/quadrature.hpp"
#include "io/format.hpp"
#include "post/hex_field.hpp"

namespace fbi::post {
namespace {

constexpr int most_parts = 20;  // of a cell in one direction
constexpr int pairs[6][2] = {{0, 0}, {0, 1}, {0, 2}, {1, 1}, {1, 2}, {2, 2}};

// Node values: velocity, pressure and, of running means, R.
struct NodeFields {
  std::vector<double> velocity, pressure, stress;
  double averaged_over = 0.0;

  NodeFields(const Run& run, const io::StepTime& output, bool instantaneous) {
    const io::File file = io::open_kind(run.paths.step(output.step), io::FileKind::step);
    const bool means = !instantaneous && file.has("/fluid/mean_velocity") && file.has("/fluid/reynolds_stress");
    const std::string prefix = means ? "/fluid/mean_" : "/fluid/";
    if (!file.has(prefix + "velocity"))
      throw Error(ExitCode::file, "\"" + file.path() + "\" has no velocity, so there is no profile of it");
    velocity = file.read<double>(prefix + "velocity");
    pressure = file.has(prefix + "pressure") ? file.read<double>(prefix + "pressure")
                                             : std::vector<double>(velocity.size() / 3, 0.0);
    if (!means) return;
    stress = file.read<double>("/fluid/reynolds_stress");
    averaged_over = file.number_attribute("/fluid/mean_velocity", "averaged_over");
  }
};

// What is averaged: velocity and height, whose covariances are wanted, and quantities of which only the mean is.
struct Sample {
  Eigen::Vector4d v = Eigen::Vector4d::Zero();                              // velocity, height
  Eigen::Matrix<double, 7, 1> other = Eigen::Matrix<double, 7, 1>::Zero();  // pressure, R

  void add(double share, const NodeFields& fields, Index node) {
    const std::size_t n = static_cast<std::size_t>(node);
    for (int d = 0; d < 3; ++d) v[d] += share * fields.velocity[3 * n + d];
    other[0] += share * fields.pressure[n];
    if (!fields.stress.empty())
      for (int c = 0; c < 6; ++c) other[1 + c] += share * fields.stress[6 * n + c];
  }
};

// Weighted means and covariances, renewed point by point as in base/running_mean.
struct Mean {
  double weight = 0.0;
  Sample mean;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();

  void add(const Sample& sample, double added) {
    weight += added;
    const double share = added / weight;
    const Eigen::Vector4d d = sample.v - mean.v;
    mean.v += share * d;
    mean.other += share * (sample.other - mean.other);
    covariance = (1.0 - share) * (covariance + share * d * d.transpose());
  }

  ProfileRow row(bool has_means) const {
    ProfileRow row;
    row.height = mean.v[3];
    row.measure = weight;
    row.velocity = mean.v.head<3>();
    row.pressure = mean.other[0];
    for (int c = 0; c < 6; ++c) {
      const int i = pairs[c][0], j = pairs[c][1];
      // Without the part that a linear change with the height explains.
      const double slope = covariance(3, 3) > 0.0 ? covariance(i, 3) * covariance(j, 3) / covariance(3, 3) : 0.0;
      (has_means ? row.dispersive : row.reynolds)[c] = covariance(i, j) - slope;
      if (has_means) row.reynolds[c] = mean.other[1 + c];
    }
    return row;
  }
};

struct Bounds {
  Vec3 from = Vec3::Constant(std::numeric_limits<double>::infinity()), to = -from;
};

Bounds bounds_of(const Grid& grid) {
  Bounds bounds;
  for (Index c = 0; c < grid.cells(); ++c) {
    const Grid::Corners x = grid.corners(c);
    bounds.from = bounds.from.cwiseMin(x.rowwise().minCoeff());
    bounds.to = bounds.to.cwiseMax(x.rowwise().maxCoeff());
  }
  return bounds;
}

// Gauss points of one direction of a box, cut to [from, to]: exact for products of two functions linear in cells.
struct LinePoint {
  Index cell;
  double share, weight;  // between the nodes `cell` and `cell` + 1
};

std::vector<LinePoint> line_points(const std::vector<double>& nodes, double from, double to) {
  static const fem::QuadratureRule rule = fem::gauss_legendre(2);
  std::vector<LinePoint> points;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double left = std::max(nodes[i], from), right = std::min(nodes[i + 1], to);
    if (!(right > left)) continue;
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      const double x = 0.5 * (left + right) + 0.5 * (right - left) * rule.points[p];
      points.push_back(
          {static_cast<Index>(i), (x - nodes[i]) / (nodes[i + 1] - nodes[i]), 0.5 * (right - left) * rule.weights[p]});
    }
  }
  return points;
}

std::vector<Mean> layer_means(const Grid& grid, const NodeFields& fields, int axis, const Bounds& box) {
  const std::array<std::vector<double>, 3>& nodes = grid.box();
  const Index stride[3] = {1, static_cast<Index>(nodes[0].size()),
                           static_cast<Index>(nodes[0].size() * nodes[1].size())};
  const int b = (axis + 1) % 3, c = (axis + 2) % 3;
  const std::vector<LinePoint> along_b = line_points(nodes[b], box.from[b], box.to[b]),
                               along_c = line_points(nodes[c], box.from[c], box.to[c]);
  std::vector<Mean> means;
  for (std::size_t k = 0; k < nodes[axis].size(); ++k) {
    const double height = nodes[axis][k], slack = 1e-9 * (nodes[axis].back() - nodes[axis].front());
    if (height < box.from[axis] - slack || height > box.to[axis] + slack) continue;
    Mean& mean = means.emplace_back();
    for (const LinePoint& q : along_c)
      for (const LinePoint& p : along_b) {
        const Index node = static_cast<Index>(k) * stride[axis] + p.cell * stride[b] + q.cell * stride[c];
        Sample sample;
        sample.add((1 - p.share) * (1 - q.share), fields, node);
        sample.add(p.share * (1 - q.share), fields, node + stride[b]);
        sample.add((1 - p.share) * q.share, fields, node + stride[c]);
        sample.add(p.share * q.share, fields, node + stride[b] + stride[c]);
        sample.v[3] = height;
        mean.add(sample, p.weight * q.weight);
      }
    mean.mean.v[3] = height;
    mean.covariance.row(3).setZero();  // round-off
    mean.covariance.col(3).setZero();
  }
  return means;
}

// Bins about as high as the cells are.
Index usual_bins(const Grid& grid, int axis, const Bounds& box) {
  double sum = 0.0;
  for (Index c = 0; c < grid.cells(); ++c) {
    const Grid::Corners x = grid.corners(c);
    sum += x.row(axis).maxCoeff() - x.row(axis).minCoeff();
  }
  const double cell = sum / grid.cells();
  return static_cast<Index>(std::clamp(std::round((box.to[axis] - box.from[axis]) / cell), 1.0, 1000.0));
}

// Gauss points of [-1,1] cut into so many equal parts.
fem::QuadratureRule composite(int parts) {
  const fem::QuadratureRule rule = fem::gauss_legendre(3);
  fem::QuadratureRule all;
  for (int k = 0; k < parts; ++k)
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      all.points.push_back((2.0 * k + 1.0 + rule.points[p]) / parts - 1.0);
      all.weights.push_back(rule.weights[p] / parts);
    }
  return all;
}

// Parts of a cell in each reference direction that are lower than a third of a bin.
std::array<int, 3> parts_of(const Grid::Corners& corners, int axis, double bin_height) {
  std::array<int, 3> parts;
  for (int d = 0; d < 3; ++d) {
    double rise = 0.0;
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < a; ++b) {
        bool edge = true;
        for (int e = 0; e < 3; ++e) edge = edge && (fem::hex8_corners[a][e] != fem::hex8_corners[b][e]) == (e == d);
        if (edge) rise = std::max(rise, std::abs(corners(axis, a) - corners(axis, b)));
      }
    parts[d] = static_cast<int>(std::clamp(std::ceil(3.0 * rise / bin_height - 1e-9), 1.0, 1.0 * most_parts));
  }
  return parts;
}

std::vector<Mean> bin_means(const Grid& grid, const NodeFields& fields, int axis, const Bounds& box, Index bins) {
  std::vector<Mean> means(static_cast<std::size_t>(bins));
  const double height = box.to[axis] - box.from[axis];
  std::vector<fem::QuadratureRule> rules;
  for (int parts = 1; parts <= most_parts; ++parts) rules.push_back(composite(parts));
  for (Index cell = 0; cell < grid.cells(); ++cell) {
    const Grid::Corners corners = grid.corners(cell);
    const Vec3 low = corners.rowwise().minCoeff(), high = corners.rowwise().maxCoeff();
    if ((high.array() < box.from.array()).any() || (low.array() > box.to.array()).any()) continue;
    const std::array<Index, 8> nodes = grid.cell_nodes(cell);
    const std::array<int, 3> parts = parts_of(corners, axis, height / bins);
    const fem::QuadratureRule &r0 = rules[parts[0] - 1], &r1 = rules[parts[1] - 1], &r2 = rules[parts[2] - 1];
    for (std::size_t k = 0; k < r2.points.size(); ++k)
      for (std::size_t j = 0; j < r1.points.size(); ++j)
        for (std::size_t i = 0; i < r0.points.size(); ++i) {
          const Vec3 xi(r0.points[i], r1.points[j], r2.points[k]);
          const std::array<double, 8> shape = fem::hex8_shape(xi);
          const Vec3 x = corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(shape.data());
          if ((x.array() < box.from.array()).any() || (x.array() > box.to.array()).any()) continue;
          Sample sample;
          for (int a = 0; a < 8; ++a) sample.add(shape[a], fields, nodes[a]);
          sample.v[3] = x[axis];
          const double place = (x[axis] - box.from[axis]) / height * bins;
          const double volume = Mat3(corners * fem::hex8_gradient(xi)).determinant();
          means[std::clamp<Index>(static_cast<Index>(place), 0, bins - 1)].add(
              sample, volume * r0.weights[i] * r1.weights[j] * r2.weights[k]);
        }
  }
  return means;
}

}  // namespace

Profiles mean_profiles(const Run& run, const ProfileOptions& options) {
  const Grid grid = Grid::read(run);
  const io::StepTime output = choose_output(run, options.at);
  const NodeFields fields(run, output, options.instantaneous);
  Bounds box = bounds_of(grid);
  if (options.from) box.from = box.from.cwiseMax(*options.from);
  if (options.to) box.to = box.to.cwiseMin(*options.to);
  if (!(box.from.array() < box.to.array()).all())
    throw Error(ExitCode::usage,
                log::format("the box from (%g, %g, %g) to (%g, %g, %g) holds no fluid of run \"%s\"; "
                            "give two opposite corners with --from X Y Z --to X Y Z",
                            box.from[0], box.from[1], box.from[2], box.to[0], box.to[1], box.to[2], run.name.c_str()));
  Profiles profiles;
  profiles.run = run.name;
  profiles.axis = options.axis;
  profiles.time = output.time;
  profiles.averaged_over = fields.averaged_over;
  profiles.layers = grid.is_box() && !options.bins;
  const std::vector<Mean> means = profiles.layers
                                      ? layer_means(grid, fields, options.axis, box)
                                      : bin_means(grid, fields, options.axis, box,
                                                  options.bins ? *options.bins : usual_bins(grid, options.axis, box));
  for (const Mean& mean : means)
    if (mean.weight > 0.0) profiles.rows.push_back(mean.row(!fields.stress.empty()));
  if (profiles.rows.empty())
    throw Error(ExitCode::usage,
                "no layer of nodes lies in the box; make it higher, or take means over volumes with --bins N");
  profiles.canopy = canopy_height(read_fiber_lines(run, output), options.axis, box.from, box.to);
  return profiles;
}

}  // namespace fbi::post
