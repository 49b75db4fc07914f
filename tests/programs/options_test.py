#!/usr/bin/env python3
"""What the options of fbi-run do and say, expected values, and cases that need only some of the parts."""
import os
import pty
import re
import subprocess

from programs import ProgramTest, command, environment, fiber_alone, main, reed, table_of, without_fibers


class Options(ProgramTest):

    def test_help_and_version(self):
        for ranks in (1, 2):
            outcome = self.expect_code(0, self.run_program("fbi-run", "--help", ranks=ranks))
            self.assertEqual(outcome.out.count("Usage:"), 1)
            for word in ("--restart", "--steps", "--max-walltime", "--dry-run", "--quiet", "SIGUSR1", "Exit codes"):
                self.assertIn(word, outcome.out)
            outcome = self.expect_code(0, self.run_program("fbi-run", "--version", ranks=ranks))
            self.assertEqual(outcome.out.count("fbi-run"), 1)
            for word in ("revision", "build", "Open MPI", "HDF5", "PETSc"):
                self.assertIn(word, outcome.out)
            self.assertEqual(outcome.err, "")
        for program in ("fbi-gen", "fbi-post"):
            self.expect_code(0, self.run_program(program, "--help"))
            self.expect_code(0, self.run_program(program, "--version"))

    def test_wrong_use(self):
        self.generate(fiber_alone())
        for ranks in (1, 2):
            self.expect_error(1, self.run_program("fbi-run", ranks=ranks), "no case file given", "--help")
            for arguments, words in ((["--chek"], ["--chek"]), (["reed.h5", "other.h5"], ["other.h5"]),
                                     (["reed.h5", "--steps", "0"], ["--steps", "must be a number above 0, not 0"]),
                                     (["reed.h5", "--steps", "many"], ["--steps", "many"]),
                                     (["reed.h5", "--max-walltime", "-1"], ["--max-walltime", "not -1"])):
                outcome = self.expect_code(1, self.run_program("fbi-run", *arguments, ranks=ranks))
                for word in words:
                    self.assertIn(word, outcome.err)
                self.assertEqual(outcome.err.count("--help"), 1, outcome.err)
                self.assertLess(max(map(len, outcome.err.splitlines())), 120)
        for program in ("fbi-gen", "fbi-post"):
            self.expect_code(1, self.run_program(program))
        self.assertFalse((self.folder / "reed.run").exists())

    def test_crossing_fibers(self):
        """Fibers that pass through each other are counted in every row, and said once; a restart goes on counting."""
        case = {
            "fibers": [
                {"name": "bar", "elements": 3, "formulation": "fixed", "section": {"radius": 0.02},
                 "curve": {"type": "line", "from": [0, 0, 0], "to": [1, 0, 0]}},
                {"name": "swing", "elements": 2, "formulation": "prescribed", "section": {"radius": 0.01},
                 "motion": [0, 0, "-t"], "curve": {"type": "line", "from": [0.4, -0.5, 0.055], "to": [0.4, 0.5, 0.055]},
                 "array": {"counts": [2, 1, 1], "spacing": [0.2, 0, 0]}},
                {"name": "post", "elements": 1, "section": {"radius": 0.01}, "material": {"young": 1e6, "density": 10},
                 "curve": {"type": "line", "from": [2, 0, 0], "to": [2, 1, 0]}, "clamped": "start"}],
            "time": {"step": 0.01, "end": 0.1}, "output": {"every": 5, "checkpoint": 5}}
        counts = [0, 0, 2, 2, 2, 2, 2, 2, 0, 0]  # at 0.045 ... -0.045 above the bar, 0.03 is near

        def counted():
            columns, rows = table_of(self.folder / "reed.run.csv")
            return [float(row[columns.index("fibers:crossing")]) for row in rows]

        for ranks in (1, 2):
            self.new_folder()
            self.generate(case)
            outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", ranks=ranks))
            self.assertEqual(counted(), counts)
            self.assertEqual(outcome.err.count("pairs of fibers touch or cross"), 1, outcome.err)
            self.assertIn('"bar" and "swing/0"', outcome.err)
            self.new_folder()
            self.generate(case)
            self.run_program("fbi-run", "reed.h5", "--steps", "5", ranks=ranks)
            self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--restart", "last", ranks=ranks))
            self.assertEqual(counted(), counts)

    def test_dry_run(self):
        self.generate(reed())
        before = sorted(self.folder.rglob("*"))
        for ranks in (1, 2):
            outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--dry-run", ranks=ranks))
            for pattern in (r"^fluid +540 unknowns \(135 nodes\)", r"^fibers +1 with 24 unknowns, 12 multipliers$",
                            r"h = [\d.]+ fiber diameters", r"^Reynolds +\d", r"^CFL +\d", r"^Cauchy +\d",
                            r"^fiber modes +highest omega dt = \d", r"^memory +about [\d.]+ MiB",
                            r"^disk +about \d+ KiB an output, \d+ KiB for all 5; \d+ KiB a checkpoint", r"^skipped +.*box mesh"):
                self.assertEqual(len(re.findall(pattern, outcome.out, re.MULTILINE)), 1, f"{pattern}\n{outcome}")
            self.assertEqual(outcome.err, "")
            self.assertEqual(sorted(self.folder.rglob("*")), before)

    def test_disk_estimate(self):
        """An output and a checkpoint are of the size that was announced, but for what HDF5 adds."""
        self.generate(reed(channel__elements=[24, 12, 8]))
        out = self.run_program("fbi-run", "reed.h5", "--dry-run").out
        output, _, checkpoint = (1024 * int(size) for size in re.findall(r"(\d+) KiB", re.search("^disk.*$", out, re.M)[0]))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 1))
        for announced, name in ((output, "000001.h5"), (checkpoint, "restart-000001.h5")):
            size = (self.folder / "reed.run" / name).stat().st_size
            self.assertLess(abs(size - announced), 0.05 * size + 12288, name)

    def test_quiet(self):
        for case in (reed(time__end=0.005), fiber_alone(time__end=0.005)):
            self.generate(case)
            for ranks in (1, 2):
                outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", ranks=ranks))
                self.assertEqual((outcome.out, outcome.err), ("", ""))

    def check_lines(self, out, steps):
        """A header and one line a step under it, in columns."""
        lines = out.splitlines()
        first = next(k for k, line in enumerate(lines) if re.match(r" +% +step +t ", line))
        names = lines[first].split()
        for k in range(1, steps + 1):
            line = lines[first + k]
            self.assertEqual(len(line), len(lines[first]), line)
            self.assertRegex(line, rf"^ +{100 * k / steps:.1f} +{k} +{k * 1e-3:g} ")
            self.assertLess(len(line), 121)
        self.assertEqual(lines[first + steps + 1], "")
        return names

    def test_progress(self):
        self.generate(reed(time__end=0.008))
        for ranks in (1, 2):
            out = self.expect_code(0, self.run_program("fbi-run", "reed.h5", ranks=ranks)).out
            names = self.check_lines(out, 8)
            self.assertEqual(names, ["%", "step", "t", "newton", "krylov", "residual", "CFL", "slip", "s/step", "ETA"])
            self.assertRegex(out, r"\n8 steps, iterations a step: [\d.]+ Newton, [\d.]+ Krylov \(most: \d+, \d+\)\n")
            self.assertRegex(out, r"\nwall time \d+ s, peak memory \d+ MiB")
            self.assertRegex(out, r"\nresults in reed.run.h5\n$")
            self.assertNotIn("\r", out)
            self.assertNotIn("\033", out)
        self.generate(fiber_alone(time__end=0.008))
        out = self.run_program("fbi-run", "reed.h5").out
        self.assertEqual(self.check_lines(out, 8), ["%", "step", "t", "newton", "s/step", "ETA"])
        self.generate(reed(time__end=0.008, coupling__scheme="aitken"))
        self.assertIn("coupling", self.check_lines(self.run_program("fbi-run", "reed.h5").out, 8))

    def test_progress_in_a_terminal(self):
        self.generate(fiber_alone(time__end=0.008))
        inside, outside = pty.openpty()
        process = subprocess.Popen(command("fbi-run", ["reed.h5"], 1), cwd=self.folder, env=environment(), stdout=outside,
                                   stderr=outside)
        os.close(outside)
        text = b""
        try:
            while chunk := os.read(inside, 65536):
                text += chunk
        except OSError:  # the other side is closed
            pass
        self.assertEqual(process.wait(), 0)
        self.check_lines(text.decode().replace("\r\n", "\n"), 8)

    def test_steps(self):
        self.generate(fiber_alone())
        outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--steps", 7))
        self.assertIn("go on with: fbi-run reed.h5 --restart last", outcome.out)
        self.assertEqual(self.outputs(), [0, 5, 7])
        self.assertEqual(self.checkpoints(), [5, 7])
        self.assertFalse(self.is_complete())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--steps", 1000, "--restart", "last"))
        self.assertTrue(self.is_complete())

    def test_output_elsewhere(self):
        self.generate(fiber_alone(time__end=0.01))
        (self.folder / "there").mkdir()
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "-o", "there/try.h5"))
        self.assertEqual(sorted(path.name for path in (self.folder / "there").iterdir()),
                         ["try", "try.csv", "try.h5", "try.xdmf"])
        self.expect_code(0, self.run_program("fbi-post", "tip", "there/try.h5", "--no-plot"))


class Expected(ProgramTest):

    def case(self, *expected):
        return fiber_alone(time__end=0.01, expect=list(expected))

    def tip(self):
        columns, rows = table_of(self.folder / "reed.run.csv")
        return [float(row[columns.index("reed:displacement_x")]) for row in rows]

    def test_met_and_missed(self):
        self.generate(self.case())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        values = self.tip()
        quantity = "reed:displacement_x"
        good = [{"quantity": quantity, "value": values[-1], "tolerance": 1e-9},
                {"quantity": quantity, "value": max(map(abs, values)), "reduce": "max_abs", "tolerance": 1e-9},
                {"quantity": quantity, "value": values[4], "time": 0.005, "absolute_tolerance": 1e-12}]
        bad = {"quantity": quantity, "value": 2 * values[-1], "tolerance": 1e-3}
        self.generate(self.case(*good))
        outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5"))
        self.assertEqual(outcome.out.count(": ok\n"), 3)
        self.assertEqual(self.run_program("fbi-run", "reed.h5", "--quiet").out, "")
        self.generate(self.case(*good, bad))
        for arguments in ([], ["--quiet"], ["--restart", "last"]):
            for ranks in (1, 2):
                outcome = self.run_program("fbi-run", "reed.h5", *arguments, ranks=ranks)
                self.expect_error(5, outcome, quantity, "MISSED", f"expected {2 * values[-1]:.8g}")
                self.assertTrue(self.is_complete())
        # Rows from before a restart count; a run that is not complete is not judged.
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 7))
        self.expect_error(5, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"), quantity)
        self.generate(self.case(*good))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 7))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"))

    def test_unknown_quantity(self):
        self.generate(self.case({"quantity": "reed:displacement_w", "value": 1, "tolerance": 1}))
        for ranks in (1, 2):
            self.expect_error(1, self.run_program("fbi-run", "reed.h5", ranks=ranks), '"reed:displacement_w" is not a column',
                              "reed:displacement_x")
        self.assertFalse((self.folder / "reed.run").exists())


class Parts(ProgramTest):
    """Cases with some of the parts only, through the three programs; the timings tell what was not done."""

    def through_all(self, case, fibers, fluid):
        self.generate(case)
        out = self.expect_code(0, self.run_program("fbi-run", "reed.h5")).out
        self.check_readable()
        self.assertTrue(self.is_complete())
        if fibers:
            self.expect_code(0, self.run_program("fbi-post", "tip", "reed.run.h5", "--no-plot"))
        if fluid:
            self.expect_code(0, self.run_program("fbi-post", "picture", "reed.run.h5"))
        report = out[out.index("times of rank 0"):]
        calls = {}
        for name, count in re.findall(r"^ +(\S.*?\S) +[\d.]+ s +[\d.]+ % +(\d+)$", report, re.MULTILINE):
            calls[name] = calls.get(name, 0) + int(count)
        return calls, " ".join(re.findall("^skipped.*$", out, re.MULTILINE))

    def expect_none(self, calls, *words):
        for word in words:
            self.assertFalse([name for name in calls if word in name], calls)

    def test_both(self):
        calls, _ = self.through_all(reed(), True, True)
        self.assertEqual(calls["step"], 20)
        self.assertEqual(calls["search and D, M, kappa"] // 20, 1)
        self.assertGreaterEqual(calls["fiber tangents"], 20)

    def test_fibers_alone(self):
        calls, skipped = self.through_all(fiber_alone(), True, False)
        self.assertEqual(calls["step"], 20)
        self.expect_none(calls, "fluid", "search", "kappa", "linear solve", "condensation", "M v")
        self.assertIn("no fluid", skipped)

    def test_fluid_alone(self):
        calls, skipped = self.through_all(without_fibers(), False, True)
        self.assertEqual(calls["step"], 20)
        self.expect_none(calls, "fiber", "search", "kappa", "condensation", "M v", "M^T")
        self.assertIn("no fibers", skipped)

    def test_fibers_that_do_not_move(self):
        case = reed()
        case["fibers"][0]["formulation"] = "fixed"
        del case["fibers"][0]["material"]
        case["output"]["checkpoint"] = 0
        calls, skipped = self.through_all(case, True, True)
        self.assertEqual(calls["search and D, M, kappa"], 1)
        self.expect_none(calls, "fiber tangents", "fiber solve", "fiber increments")
        self.assertIn("fibers do not move", skipped)

    def test_steady_flow_past_fibers(self):
        case = reed(time={"fluid": {"scheme": "steady"}})
        case["channel"]["boundaries"]["xmin"]["velocity"][0] = "4*y*(1-y)"
        case["fibers"][0]["formulation"] = "fixed"
        del case["fibers"][0]["material"]
        calls, _ = self.through_all(case, True, True)
        self.assertEqual(calls["step"], 1)
        self.assertEqual(self.outputs(), [0, 1])

    def test_statics(self):
        case = fiber_alone(time={"step": 0.25, "beam": {"scheme": "static"}})
        case["fibers"][0]["loads"][0]["value"] = [0.01, 0, 0]
        calls, _ = self.through_all(case, True, False)
        self.assertEqual(calls["step"], 4)
        self.expect_none(calls, "fluid", "search")


if __name__ == "__main__":
    main()
