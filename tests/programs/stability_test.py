#!/usr/bin/env python3
"""tools/stability: the criterion on signals that are known, and a small map from runs to picture."""
import importlib.machinery
import importlib.util
import math
import os
import pathlib
import sys
from unittest import mock

from programs import BIN, ProgramTest, environment, main, reed

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "stability"


def load():
    loader = importlib.machinery.SourceFileLoader("stability", str(TOOL))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("stability", loader))
    loader.exec_module(module)
    return module


class Stability(ProgramTest):
    tool = load()

    def history(self, force, pressure=lambda k, i: 1.0 - 0.1 * i, energy=0.0):
        rows = []
        for k in range(1, 61):
            rows.append({"time": 1e-3 * k, "dt": 1e-3, "newton": 2 + k % 2, "krylov": 10, "coupling_iterations": 1,
                         "beam:drag_x": force(k), "beam:drag_y": 0.0, "beam:displacement_x": 1e-3 * math.sin(0.05 * k),
                         "beam:displacement_y": 0.0, "energy:fiber_kinetic": energy, "energy:fiber_elastic": 0.0,
                         "energy:fluid_kinetic": 1e-3, "power:fiber": 1.0,
                         **{f"point/{i}:pressure": pressure(k, i) for i in range(7)}})
        return rows

    def outcome_of(self, *arguments, **named):
        result = self.tool.judge(self.history(*arguments, **named), False)
        return self.tool.outcome(result, 60), result

    def test_smooth_signals_are_stable(self):
        word, result = self.outcome_of(lambda k: math.sin(0.3 * k) + 0.2 * math.sin(0.6 * k))
        self.assertEqual(word, "stable")
        self.assertLess(result["level"], 0.02)
        self.assertEqual((result["newton mean"], result["newton most"]), (2.5, 3))

    def test_growth_of_alternation_is_found(self):
        """Whatever the smooth part: theory's factor comes back."""
        for factor in (0.8, 0.97, 1.05):
            _, result = self.outcome_of(lambda k: (-factor) ** k + 0.05 * math.cos(0.05 * k))
            self.assertAlmostEqual(result["growth"], factor, delta=0.01)

    def test_outcomes(self):
        self.assertEqual(self.outcome_of(lambda k: 1.0 + 0.5 * (-1.0) ** k)[0], "alternating")
        self.assertEqual(self.outcome_of(lambda k: 1.0 + 0.01 * (-1.1) ** k)[0], "growing")
        self.assertEqual(self.outcome_of(lambda k: 1.0 + (-0.7) ** k)[0], "stable")
        self.assertEqual(self.outcome_of(lambda k: 1.0, energy=1.0)[0], "growing")  # more than the work of 0.06
        self.assertEqual(self.outcome_of(lambda k: 1.0, pressure=lambda k, i: 1.0 + 0.5 * (-1) ** i)[0], "rough")
        short = self.tool.judge(self.history(lambda k: 1.0)[:5], False)
        self.assertEqual(self.tool.outcome(short, 60), "failed")

    def test_a_map(self):
        tool = self.tool
        step = tool.axis("time step", "time.step", [1e-3, 1e-1])
        small = {"small": ("A small map", step, tool.choices("penalty", [("100", {"coupling.penalty": 100.0})]))}
        arguments = ["stability", "--bin", str(BIN), "-o", str(self.folder / "data"), "--pictures",
                     str(self.folder / "pictures"), "--steps", "20"]
        with mock.patch.object(tool, "maps", lambda: small), mock.patch.object(tool, "ROOT", self.folder), \
                mock.patch.object(tool, "CASE", TOOL.parent.parent / "cases/single-beam/single-beam.json"), \
                mock.patch.object(sys, "argv", arguments), mock.patch.dict(os.environ, environment()):
            tool.main()
        lines = (self.folder / "data" / "stability-small.tsv").read_text().splitlines()
        self.assertEqual(lines[:3], ["# title: A small map", "# x: time step", "# y: penalty"])
        names, *rows = [line.split("\t") for line in lines[3:]]
        self.assertEqual([row[names.index("outcome")] for row in rows], ["stable", "failed"])
        self.assertEqual(rows[0][names.index("steps")], "20")
        self.assertNotEqual(rows[1][names.index("ended")], "-")
        self.assertGreater((self.folder / "pictures" / "stability-small.png").stat().st_size, 1000)

    def test_warning_before_a_run(self):
        """A case outside the stable region is told so, quiet or not, on any number of ranks; the same case inside is not."""
        for density, ranks, warned in ((1e-4, 1, True), (1e-4, 2, True), (1000, 1, False)):
            self.generate(reed(coupling={"scheme": "aitken"}, fibers=[{**reed()["fibers"][0], "material": {
                "young": 1e6, "density": density}}]))
            outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--dry-run", "--quiet", ranks=ranks))
            self.assertEqual(outcome.err.count("solved in turns"), int(warned), outcome)
            self.assertEqual(outcome.err == "", not warned, outcome)


if __name__ == "__main__":
    main()
