#!/usr/bin/env python3
"""tools/baseline: a history against a stored one - what passes, what is found, what is a mistake of the user."""
import pathlib
import subprocess
import sys

from programs import ProgramTest, environment, main, reed, table_of, without_fibers

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "baseline"
STEPS = 12


class Baseline(ProgramTest):

    def tool(self, *arguments):
        return subprocess.run([sys.executable, TOOL, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, env=environment())

    def history(self, name, **changes):
        """The history of a short run of the reed."""
        folder = self.folder / name
        self.generate(reed(solver__linear="iterative", **changes), folder=folder)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", STEPS, folder=folder))
        return folder / "reed.run.csv"

    def changed(self, path, name, column, change, steps=range(1, STEPS + 1)):
        """A copy of a history with other numbers in a column."""
        columns, rows = table_of(path)
        at = columns.index(column)
        comments = [line for line in path.read_text().splitlines() if line.startswith("#")]
        for row in rows:
            if int(row[0]) in steps:
                row[at] = str(change(float(row[at])))
        copy = self.folder / name
        copy.write_text("\n".join([*comments, ",".join(columns), *map(",".join, rows)]) + "\n")
        return copy

    def expect(self, code, outcome, *words):
        self.assertEqual(outcome.returncode, code, f"{outcome.stdout}\n{outcome.stderr}")
        for word in words:
            self.assertIn(word, outcome.stdout + outcome.stderr)

    def test_what_agrees_and_what_differs(self):
        run = self.history("plain")
        tight = self.history("tight", solver__newton_tolerance=1e-8)
        self.expect(0, self.tool("extract", run, "-o", "base.csv", "--every", 3, "--tight", tight), "4 rows")
        columns, rows = table_of(self.folder / "base.csv")
        self.assertEqual([row[0] for row in rows], ["3", "6", "9", "12"])
        self.assertNotIn("wall_seconds", columns)
        for name in ("reed:displacement_x", "mean:velocity_x", "constraint_violation", "energy:fluid_kinetic", "krylov"):
            self.assertIn(name, columns)
        all_columns, all_rows = table_of(run)
        krylov = [float(row[all_columns.index("krylov")]) for row in all_rows]
        self.assertEqual(float(rows[0][columns.index("krylov")]), sum(krylov[:3]))

        self.expect(0, self.tool("compare", run, "base.csv"), "4 rows of 4")
        outcome = self.tool("compare", tight, "base.csv")  # the same results by more iterations
        self.expect(5, outcome, "krylov")
        self.assertNotIn("differs", outcome.stdout + outcome.stderr)
        shorter = self.folder / "shorter.csv"
        shorter.write_text("\n".join(run.read_text().splitlines()[:3 + 7]) + "\n")
        self.expect(0, self.tool("compare", shorter, "base.csv"), "2 rows of 4")

        x = "reed:displacement_x"
        self.expect(0, self.tool("compare", self.changed(run, "a.csv", x, lambda v: 1.005 * v), "base.csv"))
        self.expect(5, self.tool("compare", self.changed(run, "b.csv", x, lambda v: 1.03 * v), "base.csv"), x, "step 6 on")
        self.expect(5, self.tool("compare", self.changed(run, "c.csv", x, lambda v: 1.03 * v, [9]), "base.csv"), x, "step 9")
        self.expect(0, self.tool("compare", self.changed(run, "d.csv", x, lambda v: 1.03 * v, [8]), "base.csv"))
        self.expect(5, self.tool("compare", self.changed(run, "e.csv", x, lambda v: float("nan"), [12]), "base.csv"), x)
        self.expect(0, self.tool("compare", self.changed(run, "f.csv", "krylov", lambda v: 1.4 * v), "base.csv"))
        self.expect(5, self.tool("compare", self.changed(run, "g.csv", "krylov", lambda v: 1.6 * v), "base.csv"), "krylov")
        self.expect(0, self.tool("compare", self.changed(run, "h.csv", "wall_seconds", lambda v: 9 * v), "base.csv"))

    def test_mean_velocity(self):
        # A plug flow of speed 1.5 between slip walls stays what it is.
        case = without_fibers(fluid__initial_velocity=["1.5", "0", "0"], channel__boundaries__ymin={"type": "slip"},
                              channel__boundaries__xmin={"type": "inflow", "velocity": [1.5, 0, 0]})
        for ranks in (1, 2):
            folder = self.complete_run(case, f"plug-{ranks}", ranks, "--steps", 8)
            columns, rows = table_of(folder / "reed.run.csv")
            first = columns.index("mean:velocity_x")
            self.assertEqual(columns[first:first + 3], ["mean:velocity_x", "mean:velocity_y", "mean:velocity_z"])
            mean = [float(number) for number in rows[-1][first:first + 3]]
            for value, expected in zip(mean, [1.5, 0, 0]):
                self.assertAlmostEqual(value, expected, delta=1e-12)

    def test_iteration_error_widens_tolerances(self):
        run = self.history("plain")
        name = "point/0:velocity_x"
        other = self.changed(run, "tight.csv", name, lambda v: 1.02 * v)
        self.expect(0, self.tool("extract", run, "-o", "base.csv", "--every", 2, "--tight", other), "iteration error")
        self.expect(0, self.tool("compare", self.changed(run, "a.csv", name, lambda v: 1.04 * v), "base.csv"))
        self.expect(5, self.tool("compare", self.changed(run, "b.csv", name, lambda v: 1.2 * v), "base.csv"), name)

    def test_mistakes(self):
        run = self.history("plain")
        self.expect(6, self.tool("compare", "nothing.csv", "base.csv"), "nothing.csv")
        self.expect(1, self.tool("extract", run, "-o", "base.csv", "--every", 100), "12 steps")
        self.expect(0, self.tool("extract", run, "-o", "base.csv", "--every", 6))
        self.expect(6, self.tool("compare", run, run), "tolerance")
        fewer = self.history("fewer", output={"probes": []})
        self.expect(5, self.tool("compare", fewer, "base.csv"), "lacks columns", "reed:displacement_x")
        self.expect(6, self.tool("check", "no-such-case"), "missing")
        self.expect(1, self.tool("check"))


if __name__ == "__main__":
    main()
