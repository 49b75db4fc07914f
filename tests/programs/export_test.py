#!/usr/bin/env python3
"""fbi-post export: the VTK files hold what the run holds, read here byte by byte and by the VTK library."""
import json
import pathlib
import re
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

from programs import ProgramTest, dataset, fiber_alone, main, reed, table_of, without_fibers

READER = pathlib.Path(__file__).with_name("read_vtk.py")
CODES = {"Float64": "d", "Float32": "f", "Int64": "q", "UInt8": "B"}
TENSOR = (0, 3, 5, 1, 4, 2)  # VTK's xx, yy, zz, xy, yz, xz from xx, xy, xz, yy, yz, zz


def read_arrays(path):
    """{name: numbers} of the appended arrays of a VTK XML file."""
    data = path.read_bytes()
    start = data.index(b"_", data.index(b'<AppendedData encoding="raw">')) + 1
    head = data[:start].decode()
    arrays = {}
    for tag in re.findall(r"<DataArray [^>]*format=\"appended\"[^>]*>", head):
        keys = dict(re.findall(r'(\w+)="([^"]*)"', tag))
        at = start + int(keys["offset"])
        size, code = struct.unpack_from("<Q", data, at)[0], CODES[keys["type"]]
        arrays[keys["Name"]] = list(struct.unpack_from(f"<{size // struct.calcsize(code)}{code}", data, at + 8))
    return arrays


def flat(rows):
    return [number for row in rows for number in row]


class Export(ProgramTest):

    def setUp(self):
        super().setUp()
        self.run_folder = self.complete_run(reed(output__averages={}, output__every=10), "run")

    def export(self, *arguments):
        return self.expect_code(0, self.run_program("fbi-post", "export", "reed.run.h5", *arguments,
                                                    folder=self.run_folder))

    def series(self):
        root = ElementTree.parse(self.run_folder / "reed.export.pvd").getroot()
        return [(float(entry.get("timestep")), int(entry.get("part")), self.run_folder / entry.get("file"))
                for entry in root.iter("DataSet")]

    def run_values(self, step):
        """What the files of the run hold: {name: numbers} of fluid and fibers."""
        file, mesh = self.run_folder / f"reed.run/{step:06d}.h5", self.run_folder / "reed.run/mesh.h5"
        fluid = {"Points": dataset(mesh, "/fluid/nodes"), "connectivity": dataset(mesh, "/fluid/cells", "i")}
        for name in ("velocity", "pressure", *(["mean_velocity", "mean_pressure"] if step else [])):
            fluid[name] = dataset(file, f"/fluid/{name}")
        if step:
            ours = dataset(file, "/fluid/reynolds_stress")
            fluid["reynolds_stress"] = [ours[k + c] for k in range(0, len(ours), 6) for c in TENSOR]
        fibers = {"Points": dataset(file, "/fibers/position"), "velocity": dataset(file, "/fibers/velocity"),
                  "force": dataset(file, "/fibers/force")}
        return fluid, fibers

    def test_series(self):
        outcome = self.export()
        self.assertIn("6 files in", outcome.out)
        self.assertEqual([(time, part, file.name) for time, part, file in self.series()],
                         [(time, part, f"{step:06d}.{kind}") for step, time in ((0, 0.0), (10, 0.01), (20, 0.02))
                          for part, kind in enumerate(("fluid.vtu", "fibers.vtp"))])

    def test_values_byte_by_byte(self):
        self.export()
        columns, rows = table_of(self.run_folder / "reed.run.csv")
        for step in (0, 10, 20):
            files = [read_arrays(self.run_folder / f"reed.export.vtk/{step:06d}.{kind}")
                     for kind in ("fluid.vtu", "fibers.vtp")]
            for ours, theirs in zip(self.run_values(step), files):
                for name, values in ours.items():
                    self.assertEqual(theirs[name], values, f"{name} of step {step}")
            fluid, fibers = files
            self.assertEqual(fluid["offsets"], list(range(8, len(fluid["connectivity"]) + 1, 8)))
            self.assertEqual(set(fluid["types"]), {12})
            self.assertEqual(fibers["connectivity"], list(range(len(fibers["Points"]) // 3)))
            self.assertEqual(fibers["offsets"], [len(fibers["Points"]) // 3])
            self.assertAlmostEqual(fibers["radius"][0], 0.01, delta=1e-15)
            if step:  # the tip as the probe has it
                tip = [float(rows[step - 1][columns.index(f"reed:displacement_{axis}")]) for axis in "xyz"]
                for ours, theirs in zip(fibers["displacement"][-3:], tip):
                    self.assertAlmostEqual(ours, theirs, delta=1e-12)

    def test_values_by_the_vtk_library(self):
        self.export()
        for step, (kind, ours) in ((step, pair) for step in (0, 20)
                                   for pair in zip(("fluid.vtu", "fibers.vtp"), self.run_values(step))):
            file = self.run_folder / f"reed.export.vtk/{step:06d}.{kind}"
            outcome = None
            for python in (sys.executable, "/usr/bin/python3"):
                outcome = subprocess.run([python, READER, file], capture_output=True, text=True)
                if outcome.returncode != 77:
                    break
            if outcome.returncode == 77:
                self.skipTest("no VTK library for Python; install python3-vtk9")
            self.assertEqual((outcome.returncode, outcome.stderr), (0, ""))
            theirs = json.loads(outcome.stdout)
            # The library keeps numbers of coordinates and fields as they are.
            self.assertEqual(flat(theirs["points"]), ours["Points"])
            for name, values in ours.items():
                if name not in ("Points", "connectivity"):
                    self.assertEqual(flat(theirs["arrays"][name]), values, f"{name} of step {step}")
            self.assertEqual(theirs["arrays"]["TimeValue"], [[step * 1e-3]])
            if kind == "fluid.vtu":
                self.assertEqual(flat(theirs["cells"]), ours["connectivity"])
                self.assertEqual(set(theirs["types"]), {12})
                self.assertEqual(theirs["components"], ["XX", "YY", "ZZ", "XY", "YZ", "XZ"] if step else [])
            else:
                self.assertEqual(theirs["types"], [4])  # a polyline
                self.assertEqual(theirs["cells"], [list(range(len(theirs["points"])))])

    def test_single_precision_and_one_step(self):
        self.export()
        file = self.run_folder / "reed.export.vtk/000010.fluid.vtu"
        before, double = read_arrays(file), file.stat().st_size
        self.export("--step", 10, "--single", "--quiet")
        self.assertEqual([file.name for _, _, file in self.series()], ["000010.fluid.vtu", "000010.fibers.vtp"])
        after = read_arrays(file)
        self.assertLess(file.stat().st_size, 0.7 * double)  # whole numbers stay as they are
        largest = max(map(abs, before["velocity"]))
        for x, y in zip(before["velocity"], after["velocity"], strict=True):
            self.assertAlmostEqual(x, y, delta=1e-7 * largest)

    def test_parts_alone(self):
        for name, case, kinds in (("fluid", without_fibers(), ["fluid.vtu"]), ("fiber", fiber_alone(), ["fibers.vtp"])):
            self.run_folder = self.complete_run(case, name)
            self.export("--time", 0.02)
            self.assertEqual([file.name for _, _, file in self.series()], [f"000020.{kind}" for kind in kinds])

    def test_mistakes(self):
        for code, arguments, words in ((1, ["reed.run.h5", "--step", 7], "there are: 0, 10, 20"),
                                       (6, ["other.run.h5"], "no such file"), (1, ["reed.json"], ".h5")):
            outcome = self.expect_code(code, self.run_program("fbi-post", "export", *arguments, folder=self.run_folder))
            self.assertIn(words, outcome.err)
        self.assertFalse((self.run_folder / "reed.export.pvd").exists())


if __name__ == "__main__":
    main()
