#include "io/result_file.hpp"

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <limits>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "io/case_file.hpp"
#include "io/format.hpp"
#include "io/history.hpp"
#include "io/pending_file.hpp"

namespace fbi::io {
namespace {

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&now, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

// The line force at the sampled points: linear in each element.
std::vector<double> sample_linear(const mesh::FiberMesh& fibers, const std::vector<double>& values, int per_element) {
  std::vector<double> points;
  for (Index f = 0; f < fibers.fibers(); ++f)
    for (Index n = fibers.first_node[f]; n < fibers.first_node[f + 1]; ++n) {
      const bool last = n + 1 == fibers.first_node[f + 1];
      for (int k = 0; k < (last ? 1 : per_element); ++k) {
        const double share = static_cast<double>(k) / per_element;
        for (int d = 0; d < 3; ++d)
          points.push_back(last ? values[3 * n + d] : (1 - share) * values[3 * n + d] + share * values[3 * n + 3 + d]);
      }
    }
  return points;
}

// Number of the first point of a fiber when every element has `per_element` intervals.
GlobalIndex first_point(GlobalIndex fiber_id, GlobalIndex first_node_id, int per_element) {
  return (first_node_id - fiber_id) * per_element + fiber_id;
}

}  // namespace

std::vector<double> sample_center_lines(const mesh::FiberMesh& fibers, const std::vector<double>& dofs,
                                        int per_element) {
  std::vector<double> points;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e) {
      const double* start = &dofs[6 * static_cast<std::size_t>(e + f)];  // node of the element's beginning
      const double half = 0.5 * fibers.element_length[e];
      for (int k = 0; k < per_element; ++k) {
        const std::array<double, 4> h = fem::hermite(-1.0 + 2.0 * k / per_element);
        for (int d = 0; d < 3; ++d)
          points.push_back(k == 0 ? start[d]
                                  : h[0] * start[d] + half * h[1] * start[3 + d] + h[2] * start[6 + d] +
                                        half * h[3] * start[9 + d]);
      }
    }
    const double* end = &dofs[6 * static_cast<std::size_t>(fibers.first_node[f + 1] - 1)];
    points.insert(points.end(), end, end + 3);
  }
  return points;
}

template <class Action>
void ResultWriter::on_rank_zero(Action action) const {
  std::string text;
  if (comm_.rank() == 0) try {
      action();
    } catch (const std::exception& error) {
      text = error.what();
    }
  agree_on_error(comm_, ExitCode::file, text);
}

ResultWriter::ResultWriter(const Comm& comm, const RunPaths& paths, const mesh::HexMesh* fluid,
                           const mesh::FiberMesh* fibers, Provenance provenance, int fiber_points,
                           std::optional<GlobalIndex> restart_step)
    : comm_(comm),
      paths_(paths),
      fluid_(fluid),
      fibers_(fibers && fibers->global_fibers > 0 ? fibers : nullptr),
      provenance_(std::move(provenance)),
      fiber_points_(std::max(fiber_points, 1)),
      started_(utc_now()) {
  GlobalIndex largest = 0;
  xdmf_.folder = paths_.folder_name();
  if (fluid_) {
    nodes_ = output_order(*fluid_);
    xdmf_.nodes = fluid_->global_nodes;
    xdmf_.cells = fluid_->global_cells;
    largest = fluid_->global_nodes;
  }
  if (fibers_) {
    fiber_nodes_ = fiber_node_order(*fibers_);
    points_ = fibers_->global_elements * fiber_points_ + fibers_->global_fibers;
    std::vector<GlobalIndex> numbers;
    for (Index f = 0; f < fibers_->fibers(); ++f) {
      const GlobalIndex first = first_point(fibers_->fiber_id[f], fibers_->first_node_id[f], fiber_points_);
      const Index elements = fibers_->first_element(f + 1) - fibers_->first_element(f);
      for (GlobalIndex k = 0; k <= GlobalIndex{elements} * fiber_points_; ++k) numbers.push_back(first + k);
    }
    fiber_point_order_.emplace(comm_, numbers, points_);
    xdmf_.fibers = fibers_->global_fibers;
    xdmf_.points = points_;
    largest = std::max(largest, points_);
  }
  xdmf_.integer_bytes = largest > std::numeric_limits<std::int32_t>::max() ? 8 : 4;
  on_rank_zero([&] { make_directory(paths_.directory); });
  write_mesh_file();  // first of all: when the disk is full the older results stay
  on_rank_zero([&] {
    take_over_older_files(restart_step);
    write_index(false);
    write_text_file(paths_.xdmf, xdmf_text(xdmf_, steps_));
  });
}

void ResultWriter::take_over_older_files(std::optional<GlobalIndex> restart_step) {
  remove_leftovers(paths_.directory);
  for (const std::string& path : {paths_.index, paths_.xdmf, paths_.csv}) {
    const std::filesystem::path beside(path);
    remove_leftovers(beside.parent_path().string(), beside.filename().string());
  }
  for (const GlobalIndex step : paths_.steps()) {
    if (restart_step && step <= *restart_step) {
      const File file = open_kind(paths_.step(step), FileKind::step);
      XdmfStep& taken = steps_.emplace_back(XdmfStep{{step, file.number_attribute("/", "time")}, {}, {}});
      for (const std::string& name : file.children("/fluid"))
        taken.fluid.push_back({name, static_cast<int>(file.shape("/fluid/" + name)[1])});
      for (const std::string& name : file.children("/fibers"))
        if (name != "dofs" && name != "position")
          taken.fiber.push_back({name, static_cast<int>(file.shape("/fibers/" + name)[1])});
    } else {
      std::filesystem::remove(paths_.step(step));
    }
  }
  // Later checkpoints belong to rows and outputs that are gone now.
  for (const GlobalIndex step : paths_.checkpoints())
    if (!restart_step || step > *restart_step) std::filesystem::remove(paths_.checkpoint(step));
}

void ResultWriter::write_mesh_file() const {
  GlobalIndex bytes = 65536;
  if (fluid_) bytes += 24 * fluid_->global_nodes + 8 * xdmf_.integer_bytes * fluid_->global_cells;
  if (fibers_) bytes += 8 * (points_ + 16 * fibers_->global_fibers) + 48 * fibers_->global_nodes;
  const GlobalIndex largest = xdmf_.integer_bytes == 8 ? std::numeric_limits<GlobalIndex>::max() : 0;
  File file = File::create(comm_, paths_.mesh(), bytes);
  write_format(file, FileKind::mesh);
  if (fluid_) {
    file.write_rows("/fluid/nodes", nodes_->to_file(fluid_->coordinates.data(), 3, 3, 0), 3, nodes_->begin(),
                    nodes_->total());
    if (fluid_->box)
      for (int a = 0; a < 3; ++a) {
        const std::vector<double>& all = fluid_->box->coordinates[a];
        file.write_rows(std::string("/fluid/box/") + "xyz"[a], comm_.rank() == 0 ? all : std::vector<double>{}, 1, 0,
                        static_cast<GlobalIndex>(all.size()));
      }
    const FileOrder order(comm_, fluid_->cell_id, fluid_->global_cells);
    std::vector<GlobalIndex> cells(fluid_->cells.size());
    for (std::size_t k = 0; k < cells.size(); ++k) cells[k] = fluid_->node_id[fluid_->cells[k]];
    write_numbers(file, "/fluid/cells", order.to_file(cells, 8), 8, order.begin(), order.total(), largest);
  }
  if (fibers_) {
    const FileOrder order(comm_, fibers_->fiber_id, fibers_->global_fibers);
    GlobalIndex longest = 1;
    for (const std::string& name : fibers_->name) longest = std::max(longest, static_cast<GlobalIndex>(name.size()));
    const int length = static_cast<int>(comm_.max(longest));
    std::vector<char> letters(fibers_->name.size() * static_cast<std::size_t>(length), '\0');
    std::vector<GlobalIndex> numbers, polylines, polyline_numbers;
    for (Index f = 0; f < fibers_->fibers(); ++f) {
      std::copy(fibers_->name[f].begin(), fibers_->name[f].end(), &letters[static_cast<std::size_t>(f) * length]);
      const GlobalIndex first = first_point(fibers_->fiber_id[f], fibers_->first_node_id[f], fiber_points_);
      const GlobalIndex points =
          GlobalIndex{fibers_->first_element(f + 1) - fibers_->first_element(f)} * fiber_points_ + 1;
      numbers.insert(numbers.end(), {fibers_->group[f], fibers_->first_node_id[f], first});
      const GlobalIndex place = first + 2 * fibers_->fiber_id[f];
      polylines.insert(polylines.end(),
                       {2, points});  // XDMF: cell type 2 is a polyline, followed by its number of points
      for (GlobalIndex k = 0; k < points; ++k) polylines.push_back(first + k);
      for (GlobalIndex k = 0; k < points + 2; ++k) polyline_numbers.push_back(place + k);
    }
    const std::vector<char> names = order.to_file(letters, length);
    std::vector<std::string> strings;
    for (GlobalIndex i = 0; i < order.count(); ++i)
      strings.emplace_back(std::string(&names[static_cast<std::size_t>(i) * length], length).c_str());
    file.write_strings("/fibers/names", strings, order.begin(), order.total());
    const std::vector<GlobalIndex> rows = order.to_file(numbers, 3);
    const char* columns[3] = {"/fibers/group", "/fibers/first_node", "/fibers/first_point"};
    for (int c = 0; c < 3; ++c) {
      std::vector<GlobalIndex> column;
      for (std::size_t i = 0; i < rows.size(); i += 3) column.push_back(rows[i + c]);
      file.write_rows(columns[c], column, 1, order.begin(), order.total());
    }
    file.write_rows("/fibers/reference_dofs", fiber_nodes_->to_file(fibers_->reference_dofs(), 6), 6,
                    fiber_nodes_->begin(), fiber_nodes_->total());
    const FileOrder places(comm_, polyline_numbers, points_ + 2 * fibers_->global_fibers);
    write_numbers(file, "/fibers/polylines", places.to_file(polylines, 1), 1, places.begin(), places.total(), largest);
  }
  file.commit();
}

void ResultWriter::write_step(GlobalIndex step, double time, const std::vector<NodeField>& fluid,
                              const FiberState& fibers) {
  GlobalIndex bytes = 65536;
  for (const NodeField& field : fluid) bytes += 8 * field.components * (fluid_ ? fluid_->global_nodes : 0);
  if (fibers_) bytes += 72 * points_ + 48 * fibers_->global_nodes;
  XdmfStep written{{step, time}, {}, {}};
  {
    File file = File::create(comm_, paths_.step(step), bytes);
    write_format(file, FileKind::step);
    file.write_attribute("/", "step", step);
    file.write_attribute("/", "time", time);
    if (fluid_)
      for (const NodeField& field : fluid) {
        file.write_rows("/fluid/" + field.name,
                        nodes_->to_file(field.data, field.components, field.stride, field.offset), field.components,
                        nodes_->begin(), nodes_->total());
        if (field.averaged_over > 0.0)
          file.write_attribute("/fluid/" + field.name, "averaged_over", field.averaged_over);
        written.fluid.push_back({field.name, field.components});
      }
    if (fibers_ && fibers.dofs) {
      file.write_rows("/fibers/dofs", fiber_nodes_->to_file(*fibers.dofs, 6), 6, fiber_nodes_->begin(),
                      fiber_nodes_->total());
      const auto write_points = [&](const std::string& name, const std::vector<double>& values) {
        file.write_rows("/fibers/" + name, fiber_point_order_->to_file(values, 3), 3, fiber_point_order_->begin(),
                        fiber_point_order_->total());
        if (name != "position") written.fiber.push_back({name, 3});
      };
      write_points("position", sample_center_lines(*fibers_, *fibers.dofs, fiber_points_));
      if (fibers.velocity) write_points("velocity", sample_center_lines(*fibers_, *fibers.velocity, fiber_points_));
      if (fibers.force) write_points("force", sample_linear(*fibers_, *fibers.force, fiber_points_));
    }
    file.commit();
  }
  const auto after =
      std::find_if(steps_.begin(), steps_.end(), [&](const XdmfStep& other) { return other.step >= step; });
  steps_.erase(after, steps_.end());
  steps_.push_back(std::move(written));
  on_rank_zero([&] {
    write_index(false);
    write_text_file(paths_.xdmf, xdmf_text(xdmf_, steps_));
  });
}

void ResultWriter::write_index(bool complete) const {
  File file = File::create(paths_.index, static_cast<GlobalIndex>(provenance_.json.size() + 65536));
  write_format(file, FileKind::result);
  file.write_text("/input", provenance_.json);
  file.write_attribute("/input", "name", provenance_.json_name);
  file.make_group("/provenance");
  file.write_attribute("/provenance", "version", provenance_.version);
  file.write_attribute("/provenance", "command", provenance_.command);
  file.write_attribute("/provenance", "ranks", GlobalIndex{provenance_.ranks});
  file.write_attribute("/provenance", "started", started_);
  file.write_attribute("/provenance", "written", utc_now());
  file.write_attribute("/provenance", "complete", GlobalIndex{complete});
  file.write_attribute("/provenance", "case_fingerprint", fingerprint(provenance_.json));
  file.link("/mesh", paths_.folder_name() + "/mesh.h5");
  std::vector<GlobalIndex> numbers;
  std::vector<double> times;
  file.make_group("/outputs");
  for (const StepTime& step : steps_) {
    numbers.push_back(step.step);
    times.push_back(step.time);
    const std::string name = std::filesystem::path(paths_.step(step.step)).filename().string();
    file.link("/outputs/" + name.substr(0, name.size() - 3), paths_.folder_name() + "/" + name);
  }
  file.write("/steps/number", numbers);
  file.write("/steps/time", times);
  if (complete && std::filesystem::exists(paths_.csv)) {
    const HistoryTable history = read_history(paths_.csv);
    std::vector<double> rows;
    for (const std::vector<double>& row : history.rows) rows.insert(rows.end(), row.begin(), row.end());
    file.write_strings("/history/columns", history.columns, 0, static_cast<GlobalIndex>(history.columns.size()));
    file.write_strings("/history/units", history.units, 0, static_cast<GlobalIndex>(history.units.size()));
    if (!history.columns.empty()) file.write("/history/rows", rows, static_cast<int>(history.columns.size()));
  }
  file.commit();
}

void ResultWriter::finish() {
  on_rank_zero([&] { write_index(true); });
}

}  // namespace fbi::io
