#!/usr/bin/env python3
"""Steps that do not converge: repeated in parts, reported, restarted in the middle, and given up in the end."""
import re
import unittest

from programs import ProgramTest, main, reed, table_of

STEP = 0.02


def hard(amplitude, newton, **changes):
    """The reed in fast flow with few Newton iterations a step; with more of them steps of this size converge, and in them
    the tip may leave the channel through its floor."""
    return reed(time__step=STEP, time__end=12 * STEP,
                solver={"linear": "direct", "newton_iterations": newton, "newton_tolerance": 1e-6},
                channel__boundaries__xmin__velocity=[f"{amplitude}*y*(1-y)*sin(20*t)", 0, 0],
                output={"every": 3, "checkpoint": 1, "probes": [{"fiber": "reed"}]}, **changes)


def failed_step(outcome):
    """The step that the error names: which one it is depends on how far Newton's method gets in the few iterations."""
    return int(re.search(r"^error: step (\d+) ", outcome.err, re.MULTILINE).group(1))


class Halvings(ProgramTest):

    def test_a_run_that_needs_them(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.new_folder()
                self.generate(hard(60, 4))
                outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", ranks=ranks))
                columns, rows = table_of(self.folder / "reed.run.csv")
                # One row for each step of the grid, at its times, whatever the steps were done in.
                self.assertEqual([row[0] for row in rows], [str(n) for n in range(1, 13)])
                for n, row in enumerate(rows, 1):
                    self.assertAlmostEqual(float(row[1]), n * STEP, places=12)
                sizes = [float(row[columns.index("dt")]) for row in rows]
                smallest = min(sizes)
                self.assertLess(smallest, STEP)
                # Each size was needed before a smaller one, and whole steps were done again.
                self.assertEqual(sorted(set(sizes)), [STEP / 2 ** k for k in range(len(set(sizes)) - 1, -1, -1)])
                self.assertEqual(sizes[0], STEP)
                self.assertEqual(self.outputs(), [0, 3, 6, 9, 12])
                repeated = len(re.findall(r"did not converge:.*repeated with dt = [0-9.]+$", outcome.err, re.MULTILINE))
                self.assertGreater(repeated, 0)
                divided = sum(size < STEP for size in sizes)
                self.assertRegex(outcome.out, rf"{repeated} attempts? did not converge and (was|were) repeated with a smaller "
                                              rf"dt; {divided} steps? (was|were) done in parts, the smallest of {smallest:g}")
                self.assertIn(f"# work: steps repeated = {repeated}\n", (self.folder / "reed.run.csv").read_text())
                # The work of what was thrown away is counted in the row.
                newton = [int(row[columns.index("newton")]) for row in rows]
                self.assertGreater(max(newton), 8)
                self.check_readable()

    def test_restart_between_parts(self):
        # A restart knows the size that the steps have come to.
        case = hard(160, 3)
        case["time"]["end"] = 10 * STEP
        case["output"]["every"] = 1
        whole = self.complete_run(case, "whole")
        for step in (2, 4, 5, 7):
            with self.subTest(step=step):
                self.new_folder()
                self.generate(case)
                self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", step))
                self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"))
                self.expect_same_results(whole, self.folder)

    def test_a_run_that_they_do_not_save(self):
        case = hard(160, 3)
        self.generate(case)
        outcome = self.run_program("fbi-run", "reed.h5")
        step = failed_step(outcome)
        self.assertEqual(len(table_of(self.folder / "reed.run.csv")[1]), step - 1)
        self.expect_error(4, outcome, f"step {step} (t = {step * STEP:g}) did not converge, not even in parts of 0.00125",
                          f"the state after step {step - 1} is saved", "more time.halvings")
        self.assertEqual(self.checkpoints()[-1], step - 1)
        self.assertEqual(self.outputs()[-1], step - 1)
        self.assertIn(f"# failed: step {step} ", (self.folder / "reed.run.csv").read_text())
        self.check_readable()
        # More halvings go on from there.
        self.generate(hard(160, 3, time__halvings=7))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"))
        self.assertEqual(len(table_of(self.folder / "reed.run.csv")[1]), 12)

    def test_none_at_all(self):
        self.generate(hard(60, 4, time__halvings=0))
        outcome = self.run_program("fbi-run", "reed.h5")
        step = failed_step(outcome)
        self.assertEqual(len(table_of(self.folder / "reed.run.csv")[1]), step - 1)
        self.expect_error(4, outcome, f"step {step} (t = {step * STEP:g}) did not converge:",
                          f"the state after step {step - 1} is saved")
        self.assertNotIn("repeated", outcome.err)


if __name__ == "__main__":
    main()
