#!/usr/bin/env python3
"""Tests of tools/check_rooms.py: correct trees pass, each kind of wrong include is caught.

Usage: check_rooms_test.py FOLDER_OF_TOOLS
"""
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, sys.argv.pop(1) if len(sys.argv) > 1 else str(pathlib.Path(__file__).parents[2] / "tools"))
sys.dont_write_bytecode = True
import check_rooms  # noqa: E402

# A small house in order: file -> its includes.
GOOD = {
    "libfbi/base/types.hpp": ["<vector>"],
    "libfbi/base/comm.hpp": ["<mpi.h>", '"base/types.hpp"'],
    "libfbi/base/version.cpp": ['"revision.hpp"'],
    "libfbi/input/expression.hpp": ['"base/types.hpp"'],
    "libfbi/input/expression.cpp": ['"input/expression.hpp"', "<muParser.h>"],
    "libfbi/fem/hex8.hpp": ['"base/types.hpp"'],
    "libfbi/mesh/hex_mesh.hpp": ['"base/comm.hpp"', '"fem/hex8.hpp"'],
    "libfbi/io/hdf5.hpp": ['"mesh/hex_mesh.hpp"'],
    "libfbi/io/hdf5.cpp": ['"io/hdf5.hpp"', "<hdf5.h>"],
    "libfbi/linalg/petsc.hpp": ["<petscksp.h>"],
    "libfbi/linalg/factor.cpp": ["<cholmod.h>"],
    "libfbi/fluid/parameters.hpp": ['"input/expression.hpp"'],
    "libfbi/fluid/fluid_field.hpp": ['"fluid/parameters.hpp"', '"linalg/petsc.hpp"'],
    "libfbi/beam/beam_field.hpp": ['"mesh/hex_mesh.hpp"'],
    "libfbi/search/tree.hpp": ['"mesh/hex_mesh.hpp"'],
    "libfbi/coupling/coupling.hpp": ['"search/tree.hpp"', '"mesh/hex_mesh.hpp"'],
    "libfbi/fsi/system.hpp": ['"coupling/coupling.hpp"', '"fluid/fluid_field.hpp"', '"beam/beam_field.hpp"'],
    "libfbi/case/schema.hpp": ['"fluid/parameters.hpp"'],
    "libfbi/case/case.hpp": ['"fsi/system.hpp"'],
    "meshgen/channel.hpp": ['"case/schema.hpp"', '"mesh/hex_mesh.hpp"'],
    "meshgen/gmsh_mesh.cpp": ["<gmsh.h>"],
    "post/reader.cpp": ['"io/hdf5.hpp"'],
    "post/vtk_export.cpp": ["<vtkCellArray.h>"],
    "tools/fbi_run.cpp": ["<CLI/CLI.hpp>", '"case/case.hpp"'],
}


def violations(extra):
    """Those of the good house with additional files (or replaced ones)."""
    with tempfile.TemporaryDirectory() as folder:
        for path, includes in (GOOD | extra).items():
            file = pathlib.Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text("// A comment.\n#pragma once\n" + "".join(f"#include {name}\n" for name in includes))
        return check_rooms.check(folder)


class CheckRooms(unittest.TestCase):
    def expect_one(self, path, includes, *texts):
        """The file causes one violation, in the line of its last include, that says all of `texts`."""
        found = violations({path: includes})
        self.assertEqual(len(found), 1, found)
        self.assertTrue(found[0].startswith(f"{path}:{2 + len(includes)}: "), found)
        for text in texts:
            self.assertIn(text, found[0])

    def test_good_house_passes(self):
        self.assertEqual(violations({}), [])

    def test_lower_room_must_not_see_higher_one(self):
        for path, header in [("libfbi/base/x.hpp", "mesh/hex_mesh.hpp"), ("libfbi/fem/x.hpp", "input/expression.hpp"),
                             ("libfbi/mesh/x.cpp", "io/hdf5.hpp"), ("libfbi/search/x.cpp", "coupling/coupling.hpp"),
                             ("libfbi/coupling/x.cpp", "fsi/system.hpp"), ("libfbi/fsi/x.cpp", "case/case.hpp")]:
            with self.subTest(path):
                self.expect_one(path, ["<vector>", f'"{header}"'], "must not include", header)

    def test_fields_do_not_see_each_other(self):
        self.expect_one("libfbi/fluid/x.cpp", ['"beam/beam_field.hpp"'], "fluid must not include")
        self.expect_one("libfbi/beam/x.cpp", ['"fluid/fluid_field.hpp"'], "beam must not include")
        self.expect_one("libfbi/coupling/x.cpp", ['"beam/beam_field.hpp"'], "coupling must not include")
        self.expect_one("libfbi/coupling/x.cpp", ['"fluid/fluid_field.hpp"'], "coupling must not include")

    def test_generator_and_post_processor_see_the_schema_only(self):
        self.expect_one("meshgen/x.cpp", ['"case/case.hpp"'], "meshgen must not include")
        self.expect_one("post/x.cpp", ['"fsi/system.hpp"'], "post must not include")
        self.expect_one("tools/x.cpp", ['"fsi/system.hpp"'], "tools must not include")

    def test_third_party_headers_stay_in_their_rooms(self):
        for path, header, name in [("libfbi/case/x.cpp", "hdf5.h", "HDF5"), ("post/reader.cpp", "H5public.h", "HDF5"),
                                   ("meshgen/channel.cpp", "gmsh.h", "gmsh"), ("post/plot.cpp", "vtkActor.h", "VTK"),
                                   ("libfbi/beam/x.cpp", "petscvec.h", "PETSc"),
                                   ("libfbi/io/x.cpp", "petscsys.h", "PETSc"),
                                   ("tools/x.cpp", "petsc.h", "PETSc"),
                                   ("libfbi/fsi/x.cpp", "umfpack.h", "SuiteSparse"),
                                   ("libfbi/fluid/x.cpp", "cholmod.h", "SuiteSparse"),
                                   ("libfbi/case/x.cpp", "nlohmann/json.hpp", "nlohmann-json")]:
            with self.subTest(path):
                self.expect_one(path, ["<vector>", f"<{header}>"], name)

    def test_schema_stays_free_of_mpi_through_other_headers(self):
        found = violations({"libfbi/fluid/parameters.hpp": ['"mesh/hex_mesh.hpp"']})
        chain = "fluid/parameters.hpp -> mesh/hex_mesh.hpp -> base/comm.hpp -> mpi.h"
        self.assertTrue(any(v.startswith("libfbi/case/schema.hpp:") and "free of MPI" in v and chain in v
                            for v in found), found)

    def test_missing_and_relative_files_are_found(self):
        self.expect_one("libfbi/fem/x.cpp", ['"hex8.hpp"'], "not a file of the project")

    def test_new_room_needs_a_place(self):
        self.assertEqual(len(violations({"libfbi/helpers/x.hpp": []})), 1)

    def test_empty_tree_is_no_success(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(len(check_rooms.check(folder)), 1)


if __name__ == "__main__":
    unittest.main()
