#!/usr/bin/env python3
"""Runs that are stopped or killed: exit codes, what is left, and that going on gives what was never interrupted."""
import os
import random
import signal
import time

from programs import ProgramTest, fiber_alone, main, reed

LONG = {"time": {"step": 1e-3, "end": 0.2}}  # more steps than are done before the signal


class Stopped(ProgramTest):

    def stop_after_rows(self, rows, send, ranks):
        self.new_folder()
        self.generate(reed(**LONG))
        process = self.start("fbi-run", "reed.h5", ranks=ranks)
        self.assertTrue(self.wait_for(lambda: self.rows_written() >= rows, process), "ended too early")
        send(process)
        return self.finish(process)

    def check_stop(self, outcome, name, ranks):
        self.expect_code(3, outcome)
        step = self.rows_written()
        self.assertIn(f"warning: stopped by {name} after step {step}\n", outcome.err)
        self.assertNotIn("error", outcome.err)
        self.assertIn("go on with: fbi-run reed.h5 --restart last", outcome.out)
        self.assertIn("times of rank 0", outcome.out)
        self.assertEqual(self.checkpoints()[-1], step)
        self.assertFalse(self.is_complete())
        self.check_readable()
        # The same as a run that was asked for that many steps, now and 7 steps later.
        reference = self.complete_run(reed(**LONG), "reference", ranks, "--steps", step)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", "--steps", 7, ranks=ranks))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", "--steps", 7, ranks=ranks,
                                             folder=reference))
        last = reference / f"reed.run/{step:06d}.h5"  # --steps ends with an output, a signal does not
        if step % 5 != 0:
            last.unlink()
        self.expect_same_results(reference, self.folder)

    def test_signals(self):
        for name in ("SIGTERM", "SIGINT", "SIGUSR1"):
            with self.subTest(name):
                send = lambda process: process.send_signal(getattr(signal, name))  # noqa: E731
                self.check_stop(self.stop_after_rows(7, send, 1), name, 1)

    def test_control_c(self):
        """A terminal sends SIGINT to the whole process group, with all that MPI has started."""
        send = lambda process: os.killpg(process.pid, signal.SIGINT)  # noqa: E731
        self.check_stop(self.stop_after_rows(7, send, 1), "SIGINT", 1)

    def test_one_rank_of_two(self):
        """Batch systems signal every process, or only some."""
        send = lambda process: os.kill(self.processes_of(process)[-1], signal.SIGTERM)  # noqa: E731
        self.check_stop(self.stop_after_rows(7, send, 2), "SIGTERM", 2)

    def test_through_mpirun(self):
        send = lambda process: process.send_signal(signal.SIGUSR1)  # noqa: E731
        self.check_stop(self.stop_after_rows(7, send, 2), "SIGUSR1", 2)

    def test_mpirun_terminated(self):
        """mpirun passes SIGTERM on and kills soon after: these steps are short enough for a checkpoint."""
        outcome = self.stop_after_rows(7, lambda process: process.send_signal(signal.SIGTERM), 2)
        self.assertNotEqual(outcome.code, 0)
        self.check_readable()
        self.assertGreaterEqual(self.checkpoints()[-1], 5)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", "--steps", 3, ranks=2))

    def test_wall_time(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.new_folder()
                self.generate(reed(**LONG))
                outcome = self.expect_code(3, self.run_program("fbi-run", "reed.h5", "--max-walltime", 0.002, ranks=ranks))
                step = self.rows_written()
                self.assertGreaterEqual(step, 1)
                self.assertIn(f"stopped after step {step}: the wall-time limit of 0.002 min is reached", outcome.err)
                self.assertEqual(self.checkpoints()[-1], step)
                self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", "--steps", 2,
                                                     ranks=ranks))
                self.assertEqual(self.rows_written(), step + 2)

    def test_checkpoint_by_wall_time(self):
        self.generate(fiber_alone(output={"checkpoint": 0, "checkpoint_minutes": 1e-9}, time__end=0.01))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertEqual(self.checkpoints(), [9, 10])

    def test_no_checkpoint_by_wall_time(self):
        self.generate(fiber_alone(output={"checkpoint": 0, "checkpoint_minutes": 0}, time__end=0.01))
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertEqual(self.checkpoints(), [10])


class Killed(ProgramTest):
    """SIGKILL at ten random moments; each run goes on from where the one before was killed."""

    SEED = 20240611

    def kill_often(self, ranks, kills):
        case = reed(output__every=1, time__end=0.03)
        reference = self.complete_run(case, "reference", ranks)
        self.new_folder()
        self.generate(case)
        moments = random.Random(self.SEED + ranks)
        done, arguments = 0, []
        while done < kills:
            process = self.start("fbi-run", "reed.h5", "--quiet", *arguments, ranks=ranks)
            if not arguments:
                self.assertTrue(self.wait_for(self.checkpoints, process))
            time.sleep(moments.uniform(0, 0.6))
            pids = self.processes_of(process)
            for pid in pids if moments.random() < 0.5 else pids[-1:]:
                try:
                    os.kill(pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
            outcome = self.finish_killed(process)
            if outcome.code == 0:  # too late: begin again
                self.expect_same_results(reference, self.folder)
                self.new_folder()
                self.generate(case)
                arguments = []
                continue
            done += 1
            self.check_after_kill(reference)
            arguments = ["--restart", "last"]
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", ranks=ranks))
        self.assertTrue(self.is_complete())
        self.assertEqual(list(self.folder.rglob("*.tmp.*")), [])
        self.check_readable()
        self.expect_same_results(reference, self.folder)

    def check_after_kill(self, reference):
        """Whole files only, at least one checkpoint, and rows that are those of the reference."""
        files = [*self.folder.glob("*.h5"), *self.folder.glob("*.run/*.h5")]
        self.expect_code(0, self.run_program("fbi-post", "info", *files))
        self.expect_code(0, self.run_program("fbi-post", "tip", "reed.run.h5", "--no-plot", "--quiet"))
        self.assertGreaterEqual(len(self.checkpoints()), 1)
        self.assertIn("</Xdmf>", (self.folder / "reed.run.xdmf").read_text())
        # Rows only: a run killed between its last line and its end has the counts of its own work there already.
        lines, whole = ([line for line in (folder / "reed.run.csv").read_text().split("\n")[:-1] if line[0] != "#"]
                        for folder in (self.folder, reference))
        for line, expected in zip(lines, whole):
            self.assertEqual(line.split(",")[:10], expected.split(",")[:10])

    def test_one_rank(self):
        self.kill_often(1, 10)

    def test_two_ranks(self):
        self.kill_often(2, 10)


if __name__ == "__main__":
    main()
