#!/usr/bin/env python3
"""Running means of a run: against means of its outputs taken here, and the same when a restart lies between."""
from programs import ProgramTest, dataset, main, reed

TIGHT = {"newton_tolerance": 1e-11, "linear": "direct"}  # fibers' accelerations to 1e-7, on any ranks
# Steps of 1e-3 that begin at 0.004 or later, that is from step 5 on, and every third: step 6 stands for two steps,
# 9, 12, 15 and 18 for three. A cut after step 10 leaves one step waiting for its sample.
WEIGHTS = {6: 2, 9: 3, 12: 3, 15: 3, 18: 3}
MEANS = ("mean_velocity", "mean_pressure", "reynolds_stress")


def case(**changes):
    return reed(output__averages={"every": 3, "from": 0.004}, output__every=1, **changes)


def mean_of(folder, field, weights):
    fields = {step: dataset(folder / f"reed.run/{step:06d}.h5", f"/fluid/{field}") for step in weights}
    return [sum(weight * fields[step][k] for step, weight in weights.items()) / sum(weights.values())
            for k in range(len(fields[min(weights)]))]


def largest_difference(a, b):
    return max(abs(x - y) for x, y in zip(a, b, strict=True))


class Averages(ProgramTest):

    def cut_run(self, case, ranks, later_ranks):
        """Ten steps on `ranks`, the rest on `later_ranks`."""
        self.new_folder()
        self.generate(case)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 10, ranks=ranks))
        self.assertFalse(self.is_complete())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", ranks=later_ranks))
        self.assertTrue(self.is_complete())
        return self.folder

    def means(self, folder):
        return {field: dataset(folder / "reed.run/000020.h5", f"/fluid/{field}") for field in MEANS}

    def check_means(self, folder):
        """The means of the last output are those of the outputs."""
        means = self.means(folder)
        velocity, pressure = (mean_of(folder, field, WEIGHTS) for field in ("velocity", "pressure"))
        self.assertLess(largest_difference(means["mean_velocity"], velocity), 1e-13)
        self.assertLess(largest_difference(means["mean_pressure"], pressure), 1e-12 * max(map(abs, pressure)) + 1e-13)
        expected = [0.0] * len(means["reynolds_stress"])
        for step, weight in WEIGHTS.items():
            v = dataset(folder / f"reed.run/{step:06d}.h5", "/fluid/velocity")
            for k in range(0, len(v), 3):
                d = [v[k + i] - velocity[k + i] for i in range(3)]
                for c, (i, j) in enumerate(((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))):
                    expected[2 * k + c] += weight * d[i] * d[j] / sum(WEIGHTS.values())
        self.assertLess(largest_difference(means["reynolds_stress"], expected), 1e-13)
        self.assertGreater(max(expected), 1e-5)
        # The steps before the cut matter: without them the means would be others.
        later = {step: weight for step, weight in WEIGHTS.items() if step > 10}
        self.assertGreater(largest_difference(velocity, mean_of(folder, "velocity", later)), 1e-3)

    def test_uncut_run(self):
        self.check_means(self.complete_run(case(), "run"))

    def test_restart_on_equal_ranks(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.new_folder()
                whole = self.complete_run(case(), "whole", ranks)
                cut = self.cut_run(case(), ranks, ranks)
                self.assertEqual(self.means(whole), self.means(cut))  # to the last bit
                self.expect_same_results(whole, cut)
                self.check_means(cut)

    def test_restart_on_other_ranks(self):
        whole = self.complete_run(case(solver=TIGHT), "whole")
        for ranks in ((1, 2), (2, 1), (2, 3)):
            with self.subTest(ranks=ranks):
                cut = self.cut_run(case(solver=TIGHT), *ranks)
                self.expect_same_results(whole, cut, 1e-7)
                self.check_means(cut)


if __name__ == "__main__":
    main()
