#include "post/render.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <memory>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "io/format.hpp"
#include "io/pending_file.hpp"
#include "post/canvas.hpp"
#include "post/fiber_lines.hpp"
#include "post/hex_field.hpp"
#include "post/plot.hpp"
#include "post/scalars.hpp"

namespace fbi::post {
namespace {

constexpr int fine = 2;                                      // pixels are averages of fine x fine
constexpr double thinnest = 0.6;                             // radius of a tube in pixels
constexpr std::array<double, 4> margin = {60, 60, 70, 120};  // left, right, top, bottom [pixel]
const Color ink(0.35f, 0.35f, 0.35f), floor_color(0.93f, 0.93f, 0.91f);

ColorScale scale_of(const std::array<double, 2>& range, bool of_fibers) {
  const bool both_signs = range[0] < 0.0 && std::abs(range[0] + range[1]) <= 1e-9 * range[1];
  const std::vector<std::string> colors =
      of_fibers ? (both_signs ? std::vector<std::string>{"#00441b", "#4dac26", "#f0f0e0", "#d01c8b", "#67001f"}
                              : std::vector<std::string>{"#fff0a0", "#fdae3c", "#e8421c", "#7a0020"})
                : (both_signs ? std::vector<std::string>{"#053061", "#4393c3", "#f7f7f7", "#d6604d", "#67001f"}
                              : std::vector<std::string>{"#ffffff", "#b5d4e9", "#60a6d1", "#2070b4", "#08306b"});
  return ColorScale(colors, range[0], range[1]);
}

// A quantity with its colors.
struct Colored {
  std::string name;
  ColorScale scale;
};

class Scene {
 public:
  Scene(const Run& run, const RenderOptions& options) : options_(options), output_(choose_output(run, options.at)) {
    const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
    const io::File fields = io::open_kind(run.paths.step(output_.step), io::FileKind::step);
    if (mesh.has("/fluid/nodes")) grid_ = std::make_unique<Grid>(Grid::read(run));
    if (options.fibers != "none") lines_ = read_fiber_lines(run, output_);
    find_box();
    choose_fibers();
    if (grid_) read_slices(fields);
    if (shown_.empty() && slices_.empty())
      throw Error(ExitCode::usage, "nothing of run \"" + run.name +
                                       "\" lies in the picture; choose another --slice or "
                                       "box, or do not hide the fibers");
    if (!shown_.empty() && options.fibers != "plain") color_fibers(fields);
  }

  const io::StepTime& output() const { return output_; }
  const std::vector<Slice>& slices() const { return slices_; }
  const std::optional<Colored>& fluid() const { return fluid_; }
  const std::optional<Colored>& fibers() const { return fibers_; }
  const Vec3& low() const { return low_; }
  const Vec3& high() const { return high_; }

  Vec3 corner(int number) const {
    Vec3 x;
    for (int d = 0; d < 3; ++d) x[d] = number >> d & 1 ? high_[d] : low_[d];
    return x;
  }

  void draw(const Camera& camera, Canvas& canvas) const {
    for (int a = 0; a < 8; ++a)
      for (int d = 0; d < 3; ++d)
        if (!(a >> d & 1)) canvas.line(camera, corner(a), corner(a | 1 << d), 1.2, ink);
    for (const Slice& slice : slices_) outline(camera, canvas, slice);
    for (const std::size_t f : shown_)
      for (GlobalIndex p = lines_.first[f]; p + 1 < lines_.first[f + 1]; ++p) {
        const std::size_t at = static_cast<std::size_t>(p);
        const Eigen::Map<const Vec3> a(&lines_.position[3 * at]), b(&lines_.position[3 * at + 3]);
        const double radius = options_.radius ? *options_.radius : lines_.radius[f];
        const Color plain(0.85f, 0.28f, 0.0f);
        canvas.tube(camera, a, b, radius, thinnest, fibers_ ? fibers_->scale(fiber_values_[at]) : plain,
                    fibers_ ? fibers_->scale(fiber_values_[at + 1]) : plain);
      }
    if (grid_) draw_planes(camera, canvas);
  }

 private:
  void find_box() {
    low_ = Vec3::Constant(std::numeric_limits<double>::infinity());
    high_ = -low_;
    if (grid_)
      for (Index c = 0; c < grid_->cells(); ++c) {
        const Grid::Corners x = grid_->corners(c);
        low_ = low_.cwiseMin(x.rowwise().minCoeff());
        high_ = high_.cwiseMax(x.rowwise().maxCoeff());
      }
    else
      for (std::size_t p = 0; p < lines_.points(); ++p)
        for (const std::vector<double>* points : {&lines_.position, &lines_.reference}) {
          low_ = low_.cwiseMin(Eigen::Map<const Vec3>(&(*points)[3 * p]));
          high_ = high_.cwiseMax(Eigen::Map<const Vec3>(&(*points)[3 * p]));
        }
    if (options_.from) low_ = grid_ ? low_.cwiseMax(*options_.from) : *options_.from;
    if (options_.to) high_ = grid_ ? high_.cwiseMin(*options_.to) : *options_.to;
    if (!(low_.array() <= high_.array()).all() || low_ == high_)
      throw Error(ExitCode::usage, log::format("the box from (%g, %g, %g) to (%g, %g, %g) is empty; give two opposite "
                                               "corners with --from X Y Z --to X Y Z",
                                               low_[0], low_[1], low_[2], high_[0], high_[1], high_[2]));
  }

  void choose_fibers() {
    for (std::size_t f = 0; f < lines_.fibers(); ++f) {
      const Eigen::Map<const Vec3> foot(&lines_.reference[3 * static_cast<std::size_t>(lines_.first[f])]);
      const double slack = 1e-9 * (high_ - low_).norm();
      if ((foot.array() >= low_.array() - slack).all() && (foot.array() <= high_.array() + slack).all())
        shown_.push_back(f);
    }
  }

  void read_slices(const io::File& fields) {
    slices_ = options_.slices;
    const int axis = options_.view.up == 2 ? 1 : 2;
    if (slices_.empty() && options_.middle_slice) slices_.push_back({axis, 0.5 * (low_[axis] + high_[axis])});
    for (const Slice& slice : slices_)
      if (slice.position < low_[slice.axis] || slice.position > high_[slice.axis])
        throw Error(ExitCode::usage,
                    log::format("the slice %c = %g is not in the box, where %c goes from %g to %g", "xyz"[slice.axis],
                                slice.position, "xyz"[slice.axis], low_[slice.axis], high_[slice.axis]));
    if (slices_.empty()) return;
    values_ = read_scalar(fields, "/fluid", options_.quantity);
    fluid_ = Colored{options_.quantity, scale_of(options_.range ? *options_.range : values_.range(), false)};
  }

  void color_fibers(const io::File& fields) {
    const std::string& name = options_.fibers;
    if (name.rfind("displacement", 0) == 0) {
      std::vector<double> displacement(lines_.position.size());
      for (std::size_t k = 0; k < displacement.size(); ++k) displacement[k] = lines_.position[k] - lines_.reference[k];
      const std::string part =
          name == "displacement" ? "magnitude" : name.substr(std::min<std::size_t>(13, name.size()));
      if (part == "x" || part == "y" || part == "z" || part == "magnitude")
        fiber_values_ = component_of(displacement, part);
    }
    if (fiber_values_.empty())
      fiber_values_ = read_scalar(fields, "/fibers", name,
                                  ", displacement, displacement_x, displacement_y, displacement_z, plain, none")
                          .values;
    Scalar seen;
    for (const std::size_t f : shown_)
      seen.values.insert(seen.values.end(), fiber_values_.begin() + lines_.first[f],
                         fiber_values_.begin() + lines_.first[f + 1]);
    fibers_ = Colored{name, scale_of(options_.fiber_range ? *options_.fiber_range : seen.range(), true)};
  }

  void outline(const Camera& camera, Canvas& canvas, const Slice& slice) const {
    const int b = (slice.axis + 1) % 3, c = (slice.axis + 2) % 3;
    Vec3 corners[4];
    for (int k = 0; k < 4; ++k) {
      corners[k][slice.axis] = slice.position;
      corners[k][b] = k == 0 || k == 3 ? low_[b] : high_[b];
      corners[k][c] = k < 2 ? low_[c] : high_[c];
    }
    for (int k = 0; k < 4; ++k) canvas.line(camera, corners[k], corners[(k + 1) % 4], 1.2, ink);
  }

  // Slices, and the floor of a box, where nothing is in front of them.
  void draw_planes(const Camera& camera, Canvas& canvas) const {
    std::vector<Slice> planes = slices_;
    const int up = options_.view.up;
    if (grid_->is_box()) planes.push_back({up, low_[up]});
    std::vector<Locator> locators(slices_.size(), Locator(*grid_));
    std::vector<std::pair<double, Color>> hits;
    const Vec3 slack = Vec3::Constant(1e-9 * (high_ - low_).norm());
    canvas.for_each_pixel([&](double px, double py, float seen, Color& color) {
      const Ray ray = camera.ray(px, py);
      hits.clear();
      for (std::size_t k = 0; k < planes.size(); ++k) {
        const int axis = planes[k].axis;
        if (std::abs(ray.direction[axis]) < 1e-9) continue;  // seen from the edge
        const double depth = (planes[k].position - ray.origin[axis]) / ray.direction[axis];
        if (!(depth > 0.0) || depth >= static_cast<double>(seen)) continue;
        Vec3 x = ray.origin + depth * ray.direction;
        x[axis] = planes[k].position;
        if ((x.array() < (low_ - slack).array()).any() || (x.array() > (high_ + slack).array()).any()) continue;
        if (k == slices_.size()) {
          hits.emplace_back(depth, floor_color);
          continue;
        }
        Vec3 xi;
        const Index cell = locators[k].find(x.cwiseMax(low_).cwiseMin(high_), xi);
        if (cell < 0) continue;
        const std::array<Index, 8> nodes = grid_->cell_nodes(cell);
        const std::array<double, 8> shape = fem::hex8_shape(xi);
        double value = 0.0;
        for (int a = 0; a < 8; ++a) value += shape[a] * values_.values[static_cast<std::size_t>(nodes[a])];
        hits.emplace_back(depth, fluid_->scale(value));
      }
      std::sort(hits.begin(), hits.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
      const float share = static_cast<float>(options_.opacity);
      for (const auto& [depth, hit] : hits)
        color = hit == floor_color ? hit : Color((1.0f - share) * color + share * hit);
    });
  }

  const RenderOptions& options_;
  io::StepTime output_;
  std::unique_ptr<Grid> grid_;
  FiberLines lines_;
  std::vector<std::size_t> shown_;  // fibers
  std::vector<Slice> slices_;
  Scalar values_;
  std::vector<double> fiber_values_;
  std::optional<Colored> fluid_, fibers_;
  Vec3 low_, high_;
};

// Commands of gnuplot for text in a picture; places in pixels from the top left.
class Labels {
 public:
  explicit Labels(int height) : height_(height) {}

  void add(double x, double y, const std::string& text, const std::string& how) {
    commands_ += "set label " + gnuplot_quoted(text) + log::format(" at %.1f,%.1f ", x, height_ - y) + how +
                 " noenhanced front\n";
  }
  // A bar of colors with its name and three values.
  void bar(Canvas& canvas, int left, int top, int width, const Colored& colored, const std::string& of) {
    canvas.bar(left - 1, top - 1, width + 2, 16, ColorScale({"#606060", "#606060"}, 0.0, 1.0));
    canvas.bar(left, top, width, 14, colored.scale);
    add(left + 0.5 * width, top - 14, of + ": " + colored.name, "center");
    const double low = colored.scale.low(), high = colored.scale.high();
    for (const double share : {0.0, 0.5, 1.0})
      add(left + share * width, top + 27, log::format("%.3g", low + share * (high - low)), "center");
  }
  // Names and limits of the axes, on outer edges of the box that point along them.
  void axes(const Camera& camera, const Scene& scene, int up) {
    const Pixel middle = camera.project(0.5 * (scene.low() + scene.high()));
    for (int d = 0; d < 3; ++d) {
      Pixel first{}, last{};
      double best = -1e300;
      for (int a = 0; a < 8; ++a) {
        if (a >> d & 1) continue;
        const Pixel p = camera.project(scene.corner(a)), q = camera.project(scene.corner(a | 1 << d));
        const double outside = d == up ? -(p.x + q.x) : p.y + q.y;
        if (outside <= best + 1e-6) continue;
        best = outside;
        first = p;
        last = q;
      }
      // Too short for three texts.
      if (std::hypot(last.x - first.x, last.y - first.y) < 70.0) continue;
      const double x = 0.5 * (first.x + last.x), y = 0.5 * (first.y + last.y);
      const std::string name(1, "xyz"[d]);
      if (d == up) {
        add(first.x - 8, first.y, log::format("%g", scene.low()[d]), "right");
        add(last.x - 8, last.y, log::format("%g", scene.high()[d]), "right");
        add(x - 8, y, name, "right");
      } else {
        // Below a flat edge, beside a steep one; the limits away from the corners, where edges meet.
        const double dx = last.x - first.x, dy = last.y - first.y, part = std::min(26.0 / std::hypot(dx, dy), 0.15);
        const bool steep = std::abs(dy) > 0.5 * std::abs(dx), left = x < middle.x - 1;
        const double right_by = steep ? (left ? -10 : 10) : 0, down_by = steep ? 4 : 18;
        const char* align = !steep ? "center" : left ? "right" : "left";
        for (const auto& [share, text] : {std::pair{part, log::format("%g", scene.low()[d])},
                                          {1.0 - part, log::format("%g", scene.high()[d])},
                                          {0.5, name}})
          add(first.x + share * dx + right_by, first.y + share * dy + down_by, text, align);
      }
    }
  }
  const std::string& commands() const { return commands_; }

 private:
  int height_;
  std::string commands_;
};

}  // namespace

Slice parse_slice(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == 1 && text[0] >= 'x' && text[0] <= 'z') {
    std::size_t used = 0;
    try {
      const double position = std::stod(text.substr(2), &used);
      if (used + 2 == text.size()) return {text[0] - 'x', position};
    } catch (const std::exception&) {  // said below
    }
  }
  throw Error(ExitCode::usage, "\"" + text + "\" is no slice; write for example z=0.5, or none");
}

std::vector<std::string> write_render(const std::string& base, const Run& run, const RenderOptions& options) {
  for (const auto& range : {options.range, options.fiber_range})
    if (range && !((*range)[0] < (*range)[1]))
      throw Error(ExitCode::usage, log::format("colors from %g to %g are no range; give --range and --fiber-range as "
                                               "LOW HIGH",
                                               (*range)[0], (*range)[1]));
  const Scene scene(run, options);
  std::vector<Vec3> corners;
  for (int a = 0; a < 8; ++a) corners.push_back(scene.corner(a));
  const Camera camera(options.view, corners, options.width, options.height, margin);
  Canvas canvas(camera.width(), camera.height(), fine);
  scene.draw(camera, canvas);

  Labels labels(camera.height());
  std::string title = log::format("%s, time %.6g", run.name.c_str(), scene.output().time);
  for (std::size_t k = 0; k < scene.slices().size(); ++k)
    title +=
        log::format("%s %c = %g", k == 0 ? "; slice" : ",", "xyz"[scene.slices()[k].axis], scene.slices()[k].position);
  labels.add(0.5 * camera.width(), 26, title, "center font ',17'");
  labels.axes(camera, scene, options.view.up);
  const int top = camera.height() - 48, width = static_cast<int>(0.32 * camera.width());
  const bool both = scene.fluid() && scene.fibers();
  const int middle = (camera.width() - width) / 2, left = both ? static_cast<int>(0.12 * camera.width()) : middle;
  if (scene.fluid()) labels.bar(canvas, left, top, width, *scene.fluid(), "fluid");
  if (scene.fibers())
    labels.bar(canvas, both ? camera.width() - left - width : left, top, width, *scene.fibers(), "fibers");

  const std::string name = std::filesystem::path(base).filename().string();
  const std::string script =
      "# Run it with: gnuplot " + name +
      log::format(".gp\nset encoding utf8\nset terminal pngcairo size %d,%d font 'sans,14'\nset output ",
                  camera.width(), camera.height()) +
      gnuplot_quoted(name + ".png") +
      "\nunset border\nunset tics\nunset key\nset lmargin at screen 0\nset rmargin at screen 1\nset bmargin at screen "
      "0\nset tmargin at screen 1\n" +
      log::format("set xrange [0:%d]\nset yrange [0:%d]\n", camera.width(), camera.height()) + labels.commands() +
      "plot " + gnuplot_quoted(name + ".rgb") +
      log::format(
          " binary array=(%d,%d) flipy origin=(0.5,0.5) format='%%uchar' using 1:2:3 with rgbimage\nset output\n",
          camera.width(), camera.height());
  io::write_text_file(base + ".rgb", canvas.rgb());
  io::write_text_file(base + ".gp", script);
  run_gnuplot(base + ".gp");
  return {base + ".rgb", base + ".gp", base + ".png"};
}

}  // namespace fbi::post
