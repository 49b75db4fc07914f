/// Case files: what is written is read, on any number of ranks; every way a file can be wrong has its message.
#include "io/case_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "example_case.hpp"
#include "io/format.hpp"
#include "scratch.hpp"

namespace fbi::io {
namespace {

using test::error_of;
using test::example_case;
using test::FileSizeLimit;
using test::Scratch;
using test::spread;
using test::upright;

// Rank 0 writes, all ranks wait.
void write(const Comm& comm, const std::string& path, const CaseFile& content) {
  if (comm.rank() == 0) write_case_file(path, content);
  MPI_Barrier(comm.get());
}

TEST(CaseFile, ReadsBackWhatWasWritten) {
  const Comm comm;
  const Scratch scratch(comm);
  const std::string path = scratch / "example.h5";
  for (const bool general : {false, true}) {
    const CaseFile content = example_case(general);
    write(comm, path, content);
    const CaseHeader header = read_case_header(comm, path);
    EXPECT_EQ(header.json, content.json);
    EXPECT_EQ(header.json_name, content.json_name);
    EXPECT_EQ(header.nodes, 7 * 5 * 3);
    EXPECT_EQ(header.cells, 48);
    EXPECT_EQ(header.fibers, 7);
    EXPECT_EQ(header.fiber_nodes, 28);
    EXPECT_EQ(header.fiber_elements, 21);
    EXPECT_EQ(header.box, !general);

    const mesh::HexMesh read = read_mesh(comm, path);
    const mesh::HexMesh direct = distribute(comm, chunk_of(comm, content.mesh));
    EXPECT_EQ(read.node_id, direct.node_id);
    EXPECT_EQ(read.coordinates, direct.coordinates);
    EXPECT_EQ(read.cells, direct.cells);
    EXPECT_EQ(read.cell_id, direct.cell_id);
    ASSERT_EQ(read.faces.size(), 6u);
    for (const auto& [name, faces] : direct.faces) {
      ASSERT_EQ(read.faces.at(name).size(), faces.size());
      for (std::size_t i = 0; i < faces.size(); ++i) {
        EXPECT_EQ(read.faces.at(name)[i].cell, faces[i].cell);
        EXPECT_EQ(read.faces.at(name)[i].face, faces[i].face);
      }
    }
    ASSERT_EQ(read.box.has_value(), !general);
    if (read.box) {
      EXPECT_EQ(read.box->coordinates, content.mesh.box->coordinates);
    }

    GlobalIndex fiber = 0, node = 0;
    const mesh::FiberMeshData chunk = chunk_of(comm, content.fibers, fiber, node);
    const mesh::FiberMesh fibers = read_fibers(comm, path, &read);
    const mesh::FiberMesh wanted = distribute(comm, chunk, fiber, node, &direct);
    EXPECT_EQ(fibers.global_fibers, 7);
    EXPECT_EQ(fibers.fiber_id, wanted.fiber_id);
    EXPECT_EQ(fibers.name, wanted.name);
    EXPECT_EQ(fibers.group, wanted.group);
    EXPECT_EQ(fibers.first_node, wanted.first_node);
    EXPECT_EQ(fibers.first_node_id, wanted.first_node_id);
    EXPECT_EQ(fibers.reference_dofs(), wanted.reference_dofs());
    EXPECT_EQ(fibers.element_length, wanted.element_length);
  }
}

TEST(CaseFile, MeshWithoutFibersAndFibersWithoutMesh) {
  const Comm comm;
  const Scratch scratch(comm);
  CaseFile content = example_case();
  content.fibers = {};
  write(comm, scratch / "fluid.h5", content);
  EXPECT_FALSE(read_case_header(comm, scratch / "fluid.h5").has_fibers());
  const mesh::HexMesh fluid = read_mesh(comm, scratch / "fluid.h5");
  EXPECT_EQ(fluid.global_cells, 48);
  EXPECT_EQ(read_fibers(comm, scratch / "fluid.h5", &fluid).global_fibers, 0);

  content = example_case();
  content.mesh = {};
  content.fibers = upright(1, 2);
  write(comm, scratch / "fibers.h5", content);
  EXPECT_FALSE(read_case_header(comm, scratch / "fibers.h5").has_mesh());
  EXPECT_EQ(read_fibers(comm, scratch / "fibers.h5", nullptr).global_nodes, 3);
  EXPECT_NE(error_of([&] { read_mesh(comm, scratch / "fibers.h5"); }).find("no fluid mesh"), std::string::npos);
}

TEST(CaseFile, EveryBrokenFileHasItsMessage) {
  const Comm comm;
  const Scratch scratch(comm);
  const auto message = [&](const std::string& name) {
    const std::string first = error_of([&] { read_case_header(comm, scratch / name); });
    EXPECT_EQ(first, error_of([&] { read_mesh(comm, scratch / name); }));
    EXPECT_EQ(first, error_of([&] { read_fibers(comm, scratch / name, nullptr); }));
    EXPECT_NE(first.find(name), std::string::npos) << first;
    return first;
  };
  test::expect_contains(message("missing.h5"), "there is no such file; make it (again) with fbi-gen");
  if (comm.rank() == 0) std::ofstream(scratch / "case.json") << "{ \"fluid\": {} }";
  MPI_Barrier(comm.get());
  test::expect_contains(message("case.json"), "it is not an HDF5 file; make it (again) with fbi-gen");

  write(comm, scratch / "example.h5", example_case());
  if (comm.rank() == 0) {
    const auto size = std::filesystem::file_size(scratch / "example.h5");
    for (const double part : {0.999, 0.5, 0.1}) {
      const std::string name = scratch / ("cut" + std::to_string(static_cast<int>(1000 * part)) + ".h5");
      std::filesystem::copy_file(scratch / "example.h5", name);
      std::filesystem::resize_file(name, static_cast<std::uintmax_t>(part * static_cast<double>(size)));
    }
    std::ofstream(scratch / "empty.h5").flush();
    File newer = File::create(scratch / "newer.h5", 0);
    newer.write_attribute("/", "format", std::string("fbi case file"));
    newer.write_attribute("/", "version", file_version + 1);
    newer.commit();
    File foreign = File::create(scratch / "foreign.h5", 0);
    foreign.write("/data", std::vector<double>{1.0});
    foreign.commit();
    File result = File::create(scratch / "example.run.h5", 0);
    write_format(result, FileKind::result);
    result.commit();
    File gaps = File::create(scratch / "gaps.h5", 0);
    write_format(gaps, FileKind::case_input);
    gaps.write("/mesh/nodes", std::vector<double>(30, 0.0), 3);
    gaps.commit();
  }
  MPI_Barrier(comm.get());
  for (const char* name : {"cut999.h5", "cut500.h5", "cut100.h5"}) test::expect_contains(message(name), "truncated");
  test::expect_contains(message("empty.h5"), "not an HDF5 file");
  test::expect_contains(message("newer.h5"), "has layout version 2, but this program reads version 1; make it again");
  test::expect_contains(message("foreign.h5"), "another program");
  test::expect_contains(message("example.run.h5"), "is a result index, not a case file");
  test::expect_contains(error_of([&] { read_case_header(comm, scratch / "gaps.h5"); }), "cannot read /input");
  test::expect_contains(error_of([&] { read_mesh(comm, scratch / "gaps.h5"); }), "cannot read /mesh/cells");
}

TEST(CaseFile, AFullDiskLosesNothing) {
  const Comm comm;
  if (comm.rank() != 0) return;
  const Comm alone(MPI_COMM_SELF);
  const Scratch scratch(alone);
  const std::string path = scratch / "example.h5";
  CaseFile content = example_case();
  write_case_file(path, content);
  content.json = "another text";
  content.mesh = mesh::make_box({spread(40, 3.0), spread(20, 1.0), spread(10, 1.0)});
  {
    const FileSizeLimit limit(65536);
    const std::string message = error_of([&] { write_case_file(path, content); });
    EXPECT_NE(message.find("ulimit -f"), std::string::npos) << message;
  }
  EXPECT_EQ(scratch.files(), std::vector<std::string>{"example.h5"});  // no temporary file left
  EXPECT_EQ(read_case_header(alone, path).json, example_case().json);
  EXPECT_NE(error_of([&] { write_case_file(scratch / "nowhere/example.h5", content); }).find("create the directory"),
            std::string::npos);
}

// The reservation is only a first check: a disk that fills up while HDF5 writes is noticed as well.
TEST(CaseFile, AWriteThatFailsLateIsNoticed) {
  const Comm comm;
  if (comm.rank() != 0) return;
  const Comm alone(MPI_COMM_SELF);
  const Scratch scratch(alone);
  const std::vector<double> data(100000, 1.0);
  const FileSizeLimit limit(65536);
  const std::string message = error_of([&] {
    File file = File::create(scratch / "late.h5", 0);
    file.write("/data", data);
    file.commit();
  });
  EXPECT_NE(message.find("cannot write"), std::string::npos) << message;
  EXPECT_TRUE(scratch.files().empty());
}

TEST(CaseFile, ParallelRowsComeBackOnOtherRanks) {
  const Comm comm;
  const Scratch scratch(comm);
  const GlobalIndex mine = comm.rank() == 1 ? 0 : 5 + comm.rank();  // rank 1 has nothing
  const GlobalIndex begin = comm.sum_before(mine), total = comm.sum(mine);
  std::vector<double> numbers;
  std::vector<std::string> names;
  for (GlobalIndex i = begin; i < begin + mine; ++i) {
    numbers.insert(numbers.end(), {0.1 * static_cast<double>(i), -1.0 / (1.0 + static_cast<double>(i))});
    names.push_back(std::string(static_cast<std::size_t>(i % 4), 'a') + std::to_string(i));
  }
  {
    File file = File::create(comm, scratch / "rows.h5", 16 * total);
    file.write_attribute("/", "time", 0.1);
    file.write_rows("/deep/down/numbers", numbers, 2, begin, total);
    file.write_rows("/none", std::vector<double>{}, 3, 0, 0);
    file.write_strings("/names", names, begin, total);
    file.commit();
  }
  const File file = File::open(comm, scratch / "rows.h5", "");
  EXPECT_EQ(file.number_attribute("/", "time"), 0.1);
  EXPECT_EQ(file.shape("/deep/down/numbers"), (std::array<GlobalIndex, 2>{total, 2}));
  EXPECT_EQ(file.read_rows<double>("/deep/down/numbers", begin, mine), numbers);
  EXPECT_TRUE(file.read<double>("/none").empty());
  EXPECT_EQ(file.read_strings("/names", begin, mine), names);
  const std::vector<double> all = file.read<double>("/deep/down/numbers");
  ASSERT_EQ(all.size(), static_cast<std::size_t>(2 * total));
  for (GlobalIndex i = 0; i < total; ++i) EXPECT_EQ(all[2 * i], 0.1 * static_cast<double>(i));
}

TEST(CaseFile, ParallelFileOnAFullDisk) {
  const Comm comm;
  const Scratch scratch(comm);
  const GlobalIndex mine = 50000;
  const std::vector<double> data(static_cast<std::size_t>(mine), 1.0);
  std::string message;
  MPI_Barrier(comm.get());
  {
    const FileSizeLimit limit(65536);
    message = error_of([&] { File::create(comm, scratch / "rows.h5", 8 * mine * comm.size()); });
  }
  EXPECT_NE(message.find("ulimit -f"), std::string::npos) << message;
  MPI_Barrier(comm.get());
  if (comm.rank() == 0) {
    EXPECT_TRUE(scratch.files().empty());
  }
}

TEST(CaseFile, TheCanopyIsWrittenAndRead) {
  const Comm comm;
  const Scratch scratch(comm);
  const auto now = [] { return std::chrono::steady_clock::now(); };
  const auto seconds = [&](auto start) { return comm.max(std::chrono::duration<double>(now() - start).count()); };
  CaseFile content;
  if (comm.rank() == 0) {
    content.mesh = mesh::make_box({spread(480, 13.0), spread(32, 1.0), spread(32, 1.0)});
    content.fibers = upright(3375, 3);
  }
  MPI_Barrier(comm.get());
  auto start = now();
  write(comm, scratch / "canopy.h5", content);
  const double write_time = seconds(start);
  start = now();
  const mesh::HexMesh fluid = read_mesh(comm, scratch / "canopy.h5");
  const mesh::FiberMesh fibers = read_fibers(comm, scratch / "canopy.h5", &fluid);
  const double read_time = seconds(start);
  EXPECT_EQ(comm.sum(GlobalIndex{fluid.owned_nodes}), 523809);
  EXPECT_EQ(fibers.global_nodes, 13500);
  if (comm.rank() == 0)
    std::printf("canopy: %.1f MB written in %.3f s, read and distributed in %.3f s\n",
                1e-6 * static_cast<double>(std::filesystem::file_size(scratch / "canopy.h5")), write_time, read_time);
}

}  // namespace
}  // namespace fbi::io
