#!/usr/bin/env python3
"""Restart: bitwise on equal ranks, to solver tolerance on others; which checkpoints there are and which are refused."""
import itertools
import json

from programs import ProgramTest, fiber_alone, main, reed, without_fibers

TIGHT = {"newton_tolerance": 1e-11}


class Bitwise(ProgramTest):

    def in_two_parts(self, case, ranks=(1, 1, 1), tolerance=None):
        """The whole run on ranks[0]; half on ranks[1], the rest on ranks[2]. The half is no whole number of outputs."""
        self.new_folder()
        reference = self.complete_run(case, "reference", ranks[0])
        self.generate(case)
        half = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--steps", 10, ranks=ranks[1]))
        self.assertIn("--restart last", half.out)
        self.assertFalse(self.is_complete())
        rest = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--restart", "last", ranks=ranks[2]))
        self.assertIn("restarted from step 10", rest.out)
        self.assertTrue(self.is_complete())
        self.expect_same_results(reference, self.folder, tolerance)

    def test_schemes(self):
        for scheme, update, theta in itertools.product(("monolithic", "aitken"), ("lagged", "iterated"), (0.5, 1)):
            with self.subTest(scheme=scheme, update=update, theta=theta):
                self.in_two_parts(reed(coupling={"scheme": scheme, "geometry_update": update}, time__fluid={"theta": theta}))

    def test_iterative_solver(self):
        for scheme in ("monolithic", "aitken"):
            with self.subTest(scheme=scheme):
                self.in_two_parts(reed(coupling__scheme=scheme, solver__linear="iterative", time__fluid={"theta": 0.5}))

    def test_parts_alone(self):
        case = reed()
        case["fibers"][0]["formulation"] = "fixed"
        for name, case in {"fluid": without_fibers(time__fluid={"theta": 0.5}), "fiber": fiber_alone(),
                           "fixed": case}.items():
            with self.subTest(name):
                self.in_two_parts(case)

    def test_two_ranks(self):
        for scheme, linear in itertools.product(("monolithic", "aitken"), ("direct", "iterative")):
            with self.subTest(scheme=scheme, linear=linear):
                self.in_two_parts(reed(coupling__scheme=scheme, solver__linear=linear, time__fluid={"theta": 0.5}), (2, 2, 2))

    def test_graph_partition(self):
        case = reed(channel__elements=None, solver__linear="iterative")
        case["channel"]["cylinder"] = {"center": [1.5, 0.5], "radius": 0.1, "around": 16, "partition": "graph"}
        case["channel"]["boundaries"]["cylinder"] = {"type": "no_slip"}
        self.in_two_parts(case, (3, 3, 3))

    def test_other_ranks(self):
        # Accelerations of fibers, where a solver's rounding is largest, differ by some 2e-7 with the iteration.
        for linear, tolerance in (("direct", 1e-7), ("iterative", 1e-6)):
            for ranks in ((1, 1, 2), (1, 2, 1), (2, 2, 3)):
                with self.subTest(linear=linear, ranks=ranks):
                    self.in_two_parts(reed(solver={**TIGHT, "linear": linear}, time__fluid={"theta": 0.5}), ranks, tolerance)

    def test_runs_on_two_ranks_are_repeatable(self):
        runs = [self.complete_run(reed(), f"run{k}", 2) for k in range(3)]
        for other in runs[1:]:
            self.expect_same_results(runs[0], other)


class Checkpoints(ProgramTest):

    def test_the_last_two_are_kept(self):
        self.generate(fiber_alone())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 12))
        self.assertEqual(self.checkpoints(), [10, 12])

    def test_from_a_step(self):
        case = fiber_alone()
        reference = self.complete_run(case, "reference")
        self.generate(case)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertEqual(self.checkpoints(), [15, 20])
        self.expect_error(6, self.run_program("fbi-run", "reed.h5", "--restart", "17"),
                          "there is no checkpoint of step 17", "there are: 15, 20")
        self.expect_error(1, self.run_program("fbi-run", "reed.h5", "--restart", "first"), '"last" or a step number')
        self.expect_same_results(reference, self.folder)
        # Going on from an older one takes back what came after it.
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--restart", "15", "--steps", 1))
        self.assertEqual(self.outputs(), [0, 5, 10, 15, 16])
        self.assertEqual(self.checkpoints(), [15, 16])
        self.assertEqual(self.rows_written(), 16)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--restart", "15"))
        self.expect_same_results(reference, self.folder)

    def test_of_a_complete_run(self):
        case = fiber_alone()
        reference = self.complete_run(case, "reference")
        self.generate(case)
        for arguments in ([], ["--restart", "last"], ["--restart", "last", "--steps", 3]):
            outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", *arguments))
            self.assertTrue(self.is_complete())
            self.expect_same_results(reference, self.folder)
        self.assertIn("the run is complete already", outcome.out)

    def test_without_any(self):
        self.generate(fiber_alone())
        self.expect_error(6, self.run_program("fbi-run", "reed.h5", "--restart", "last"), "there is no checkpoint in",
                          "without --restart")
        self.assertEqual(self.outputs(), [])

    def test_of_another_case(self):
        self.generate(fiber_alone())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 10))
        before = {path: path.read_bytes() for path in self.folder.glob("reed.run*/*")}
        other = fiber_alone()
        other["fibers"][0]["material"]["young"] = 2e6
        self.generate(other)
        for ranks in (1, 2):
            self.expect_error(6, self.run_program("fbi-run", "reed.h5", "--restart", "last", ranks=ranks),
                              "belongs to another case", "the input has changed since", "without --restart")
        self.assertEqual(before, {path: path.read_bytes() for path in self.folder.glob("reed.run*/*")})
        # The same text again: it fits.
        (self.folder / "reed.json").write_text(json.dumps(fiber_alone(), indent=1))
        self.expect_code(0, self.run_program("fbi-gen", "reed.json", "--quiet"))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"))

    def test_goes_on_past_the_old_end(self):
        short = fiber_alone()
        short["time"]["end"] = 10 * short["time"]["step"]
        self.generate(short)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        longer = fiber_alone()
        longer["title"] = "The same fiber, longer"
        longer["time"]["end"] = 20 * longer["time"]["step"]
        self.generate(longer)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last"))
        rows = [line for line in (self.folder / "reed.run.csv").read_text().splitlines() if line[0].isdigit()]
        self.assertEqual([int(row.split(",")[0]) for row in rows], list(range(1, 21)))

    def test_that_is_cut(self):
        self.generate(fiber_alone())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 10))
        file = self.folder / "reed.run/restart-000010.h5"
        whole = file.read_bytes()
        for ranks in (1, 2):
            file.write_bytes(whole[:len(whole) // 2])
            self.expect_error(6, self.run_program("fbi-run", "reed.h5", "--restart", "last", ranks=ranks),
                              "restart-000010.h5", "truncated", "restart from another step")
            self.assertEqual(self.outputs(), [0, 5, 10])
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "5"))
        self.assertTrue(self.is_complete())


if __name__ == "__main__":
    main()
