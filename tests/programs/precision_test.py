#!/usr/bin/env python3
"""tools/precision: its series are cases that fbi-gen takes, only what they say differs; what it says about mistakes."""
import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import sys

from programs import BIN, ProgramTest, environment, main

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "precision"


def module():
    loader = importlib.machinery.SourceFileLoader("precision", str(TOOL))
    result = importlib.util.module_from_spec(importlib.util.spec_from_loader("precision", loader))
    loader.exec_module(result)
    return result


class Precision(ProgramTest):

    def tool(self, *arguments):
        return subprocess.run([sys.executable, TOOL, "--bin", BIN, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, env=environment())

    def test_every_run_is_a_case(self):
        precision = module()
        base, series = precision.series(20)
        self.assertEqual(len({name for _, _, members in series.values() for name, _ in members}),
                         sum(len(members) for _, _, members in series.values()))
        for reference, exact, members in series.values():
            for name, changes in [(reference, exact), *members]:
                case = precision.merged(base, changes)
                (self.folder / f"{name}.json").write_text(json.dumps(case))
                self.run_program("fbi-gen", f"{name}.json", "--quiet")
                steps = case["time"]["end"] / case["time"]["step"]
                self.assertAlmostEqual(steps, round(steps), 6)

    def test_default_of_the_library(self):
        parameters = (TOOL.parents[1] / "libfbi/fsi/parameters.hpp").read_text()
        default = re.search(r"newton_tolerance = .*second_order \? [0-9.e-]+ : ([0-9.e-]+);", parameters)
        self.assertEqual(float(default.group(1)), module().DEFAULT)
        self.assertIn(module().DEFAULT, module().TOLERANCES)

    def test_page_between_marks(self):
        page = "a\n<!-- table of tools/precision -->\nold\n<!-- end of table -->\nb\n<!-- table of tools/precision x -->\n" \
               "kept\n<!-- end of table -->\n"
        self.assertEqual(module().put(page, "", "new\n"), page.replace("old", "\nnew\n"))
        self.assertEqual(module().put(page, " x", "new\n"), page.replace("kept", "\nnew\n"))

    def test_mistakes(self):
        outcome = self.tool("--only", "mesh, theta 2")
        self.assertEqual(outcome.returncode, 2)
        self.assertIn("mesh, theta 1", outcome.stderr)

    def test_table_and_plot(self):
        precision = module()
        runs = precision.Runs(type("Options", (), {"output": self.folder / "out", "again": False, "ranks": 1, "bin": BIN,
                                                   "cells": 20})())
        precision.PLOT_END = 0.002
        precision.STEPS = [4.0, 2.0, 1.0]
        table, plot = precision.work_precision(runs, ["step, theta 1"])
        rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in table.splitlines()[2:]]
        self.assertEqual([row[1] for row in rows], ["theta-1-4", "theta-1-2", "theta-1-1"])
        self.assertEqual([row[3] for row in rows], ["5", "10", "20"])
        errors = [float(row[6]) for row in rows]
        for coarse, fine in zip(errors, errors[1:]):
            self.assertAlmostEqual(coarse / fine, 2.0, delta=0.5)  # first order
        self.assertGreater(plot.stat().st_size, 0)
        times = [(self.folder / "out" / f"{row[1]}.run.h5").stat().st_mtime_ns for row in rows]
        self.assertEqual(precision.work_precision(runs, ["step, theta 1"])[0], table)  # nothing runs again
        self.assertEqual([(self.folder / "out" / f"{row[1]}.run.h5").stat().st_mtime_ns for row in rows], times)


if __name__ == "__main__":
    main()
