/// A small case for the tests of this room: a box of 6 x 4 x 2 cells with seven upright fibers of three elements.
#pragma once

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/case_file.hpp"

namespace fbi::test {

inline std::vector<double> spread(Index cells, double length) {
  std::vector<double> x(static_cast<std::size_t>(cells) + 1);
  for (Index i = 0; i <= cells; ++i) x[i] = length * i / cells;
  return x;
}

inline mesh::FiberMeshData upright(Index count, Index elements) {
  mesh::FiberMeshData fibers;
  fibers.first_node = {0};
  for (Index f = 0; f < count; ++f) {
    fibers.name.push_back("patch/" + std::to_string(f));
    fibers.group.push_back(f % 3);
    for (Index n = 0; n <= elements; ++n) {
      fibers.position.insert(fibers.position.end(), {0.1 + 2.8 * f / count, 0.3 * n / elements, 0.5});
      fibers.tangent.insert(fibers.tangent.end(), {0.0, 1.0, 0.0});
    }
    fibers.element_length.insert(fibers.element_length.end(), static_cast<std::size_t>(elements), 0.3 / elements);
    fibers.first_node.push_back(static_cast<GlobalIndex>(fibers.position.size()) / 3);
  }
  return fibers;
}

inline io::CaseFile example_case(bool general = false) {
  io::CaseFile content;
  content.json = "{ \"title\": \"example\" } // all of it";
  content.json_name = "example.json";
  content.mesh = mesh::make_box({spread(6, 3.0), spread(4, 1.0), spread(2, 1.0)}, general);
  content.fibers = upright(7, 3);
  return content;
}

inline mesh::HexMesh distribute_mesh(const Comm& comm, const io::CaseFile& content) {
  return distribute(comm, chunk_of(comm, content.mesh));
}

inline mesh::FiberMesh distribute_fibers(const Comm& comm, const io::CaseFile& content, const mesh::HexMesh* fluid) {
  GlobalIndex fiber = 0, node = 0;
  const mesh::FiberMeshData chunk = chunk_of(comm, content.fibers, fiber, node);
  return distribute(comm, chunk, fiber, node, fluid);
}

/// The message of the Error(code) that `action` throws; "" when it throws none.
inline std::string error_of(const std::function<void()>& action, ExitCode code = ExitCode::file) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    return error.what();
  }
  return "";
}

inline void expect_contains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

}  // namespace fbi::test
