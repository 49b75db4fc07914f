#!/usr/bin/env python3
"""Runs that cannot go on: exit code, a message with the step and the reason, the last good state kept."""
import json

from programs import ProgramTest, fiber_alone, main, reed


class Failures(ProgramTest):

    def fail_and_keep(self, case, code, good, words, ranks=1):
        """Step good + 1 fails; what is kept of step `good` is what a run of that many steps leaves."""
        self.new_folder()
        reference = self.complete_run(case, "reference", ranks, "--steps", good)
        self.generate(case)
        outcome = self.run_program("fbi-run", "reed.h5", ranks=ranks)
        self.expect_error(code, outcome, f"step {good + 1} (t = {case['time']['step'] * (good + 1):.6g})",
                          f"the state after step {good} is saved", "fbi-run reed.h5 --restart last goes on from it", *words)
        self.check_readable()
        self.assertFalse(self.is_complete())
        self.expect_same_results(reference, self.folder)
        # It fails at the same place again, and what is there stays.
        again = self.run_program("fbi-run", "reed.h5", "--restart", "last", ranks=ranks)
        self.expect_error(code, again, f"step {good + 1} ", f"the checkpoint of step {good} is kept", *words)
        self.expect_same_results(reference, self.folder)

    def test_boundary_value_that_is_not_finite(self):
        inflow = ["4*y*(1-y)*sqrt(0.0068-t)", 0, 0]
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.fail_and_keep(reed(channel__boundaries__xmin__velocity=inflow), 4, 6,
                                   ["velocity on 'xmin' is not finite at (0, ", "t = 0.007"], ranks)

    def test_body_force_that_is_not_finite(self):
        self.fail_and_keep(reed(fluid__body_force=["1/max(0, 0.0068-t)", 0, 0]), 4, 6,
                           ["the body force is not finite", "t = 0.007"])

    def test_load_that_is_not_finite(self):
        case = fiber_alone()
        case["fibers"][0]["loads"][0]["value"][0] = "0.01*sqrt(0.0068-t)"
        self.fail_and_keep(case, 4, 6, [])

    def test_flow_that_blows_up(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.fail_and_keep(reed(fluid__body_force=["t > 0.0068 ? 1e200 : 0", 0, 0]), 4, 6,
                                   ["did not converge", "residual"], ranks)

    def test_schemes_that_do_not_converge(self):
        case = reed(coupling={"scheme": "aitken", "max_iterations": 1, "tolerance": 1e-14, "absolute_tolerance": 0})
        self.generate(case)
        self.expect_error(4, self.run_program("fbi-run", "reed.h5"), "step 1 (t = 0.001) did not converge",
                          "coupling.max_iterations", "no step was finished")
        self.assertIn("# failed: step 1 (t = 0.001) did not converge", (self.folder / "reed.run.csv").read_text())
        table = self.run_program("fbi-post", "iterations", "reed.run.h5", "--no-plot", "--format", "csv")
        self.assertTrue(table.out.splitlines()[1].endswith(",1"), table)  # the step that failed
        self.check_readable()

    def test_not_finite_from_the_start(self):
        for code, where, changes in (
            (4, "velocity on 'xmin' is not finite at (0, ", {"channel__boundaries__xmin__velocity": ["sqrt(-1-y)", 0, 0]}),
            (4, "the body force is not finite at (", {"fluid__body_force": ["1/x", 0, 0]}),
            (1, "the initial velocity is not finite at (", {"fluid__initial_velocity": ["1/y", 0, 0]})):
            for ranks in (1, 2):
                with self.subTest(where, ranks=ranks):
                    self.new_folder()
                    self.generate(reed(**changes))
                    self.expect_error(code, self.run_program("fbi-run", "reed.h5", ranks=ranks), where)
                    self.assertEqual(self.outputs(), [])

    def test_fiber_that_leaves_the_channel(self):
        case = reed()
        fiber = case["fibers"][0]
        fiber["curve"]["to"] = [1, 0.97, 0.12]
        fiber["material"]["young"] = 1e4
        fiber["loads"] = [{"type": "force", "at": "end", "value": [0, "t > 0.0068 ? 1 : 0", 0]}]
        case["time"]["end"] = 0.1
        self.generate(case)
        outcome = self.run_program("fbi-run", "reed.h5", "--quiet")
        self.expect_error(2, outcome, "fiber 'reed' lies", "outside the fluid mesh", "the state after step ",
                          "--restart last goes on from it")
        good = self.checkpoints()[-1]
        self.assertGreater(good, 6)
        self.assertIn(f"step {good + 1} (t = ", outcome.err)
        self.assertEqual(self.outputs()[-1], good)
        self.check_readable()
        case["coupling"] = {"outside": "allow"}
        case["time"]["end"] = 1e-3 * (good + 3)
        self.new_folder()
        self.generate(case)
        outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertEqual(outcome.err.count("warning: "), 1, outcome)
        self.assertIn("fiber 'reed' lies", outcome.err)

    def test_fiber_that_begins_outside(self):
        case = reed()
        case["fibers"][0]["curve"]["to"] = [1, 1.4, 0.12]
        (self.folder / "reed.json").write_text(json.dumps(case))
        outcome = self.expect_code(2, self.run_program("fbi-gen", "reed.json"))
        self.assertIn("reed", outcome.err)
        self.assertIn("outside", outcome.err)


if __name__ == "__main__":
    main()
