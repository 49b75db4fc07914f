#!/usr/bin/env python3
"""Files that fbi-run cannot use, or must not replace: message, exit code, nothing harmed, no rank left waiting."""
import os
import resource
import signal
import struct
import subprocess
import time

from programs import BIN, ProgramTest, fiber_alone, main, reed


class UnusableFiles(ProgramTest):

    def refuse(self, code, path, *words, ranks=(1, 2)):
        for ranks in ranks:
            with self.subTest(path=path, ranks=ranks):
                before = {file: file.read_bytes() for file in self.folder.rglob("*") if file.is_file()}
                self.expect_error(code, self.run_program("fbi-run", path, ranks=ranks), *words)
                after = {file: file.read_bytes() for file in self.folder.rglob("*") if file.is_file()}
                self.assertEqual(before, after, "files have changed")

    def test_no_such_file(self):
        self.refuse(6, "nothing.h5", "nothing.h5", "there is no such file", "fbi-gen")

    def test_folder(self):
        (self.folder / "folder.h5").mkdir()
        self.refuse(6, "folder.h5", "it is a directory", ranks=(1,))

    def test_text_with_the_name_of_a_case(self):
        (self.folder / "text.h5").write_text("not HDF5\n")
        self.refuse(6, "text.h5", "it is not an HDF5 file", "fbi-gen")

    def test_cut_at_any_place(self):
        case = self.generate(reed())
        whole = case.read_bytes()
        for size in (0, 4, 96, len(whole) // 4, len(whole) // 2, len(whole) - 1):
            (self.folder / "cut.h5").write_bytes(whole[:size])
            self.refuse(6, "cut.h5", "cut.h5", "truncated" if size > 8 else "not an HDF5 file", "fbi-gen",
                        ranks=(1, 2) if size == len(whole) // 2 else (1,))

    def test_another_version(self):
        case = self.generate(reed())
        data = bytearray(case.read_bytes())
        name = data.index(b"version\0")
        # The value follows the name: 8 bytes, the type: 16 bytes, and the space: 8 bytes.
        self.assertEqual(data[name + 32:name + 40], struct.pack("<q", 1))
        data[name + 32:name + 40] = struct.pack("<q", 7)
        (self.folder / "new.h5").write_bytes(data)
        self.refuse(6, "new.h5", "layout version 7", "reads version 1", "make it again")

    def test_results_instead_of_a_case(self):
        self.generate(fiber_alone())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 5))
        self.refuse(6, "reed.run.h5", "is a result index, not a case file", "fbi-post")
        self.refuse(6, "reed.run/000005.h5", "is a result step, not a case file", ranks=(1,))
        self.refuse(6, "reed.run/restart-000005.h5", "is a checkpoint, not a case file", "--restart", ranks=(1,))

    def test_input_that_is_refused(self):
        case = self.generate(reed())
        data = case.read_bytes()
        self.assertEqual(data.count(b'"viscosity"'), 1)
        (self.folder / "wrong.h5").write_bytes(data.replace(b'"viscosity"', b'"viskosity"'))
        self.refuse(1, "wrong.h5", "wrong.h5", "reed.json:5:3: fluid: unknown key \"viskosity\"", "did you mean",
                    "run fbi-gen again")
        (self.folder / "broken.h5").write_bytes(data.replace(b'"viscosity":', b'"viscosity"!'))
        self.refuse(1, "broken.h5", "broken.h5", "reed.json:5:", "run fbi-gen again", ranks=(1,))

    def test_damaged_inside(self):
        case = self.generate(reed())
        data = case.read_bytes()
        self.assertIn(b"element_length", data)
        (self.folder / "damaged.h5").write_bytes(data.replace(b"element_length", b"element_lengst"))
        self.refuse(6, "damaged.h5", "damaged.h5", "/fibers/element_length", "missing or damaged", "fbi-gen")

    def test_another_ending(self):
        self.refuse(1, "reed.txt", "does not end in .h5", "fbi-gen")


class FirstMinutes(ProgramTest):

    def test_forgotten_fbi_gen(self):
        (self.folder / "reed.json").write_text("{}")
        self.expect_error(1, self.run_program("fbi-run", "reed.json"), "fbi-gen reed.json", "fbi-run reed.h5")
        self.expect_error(6, self.run_program("fbi-run", "reed.h5"), "there is no such file", "fbi-gen reed.json")

    def test_typing_error(self):
        (self.folder / "reed.json").write_text('{ "fluid": { "density": 1, "viscosity": 1 },\n  "chanel": {} }')
        outcome = self.expect_code(1, self.run_program("fbi-gen", "reed.json"))
        self.assertIn('reed.json:2:3: unknown key "chanel"; did you mean "channel"?', outcome.err)
        self.assertFalse((self.folder / "reed.h5").exists())

    def test_text_changed_since(self):
        self.generate(fiber_alone())
        text = self.folder / "reed.json"
        text.write_text(text.read_text() + "\n// a thought\n")
        for arguments in (["--dry-run"], ["--quiet"]):
            outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", *arguments))
            self.assertIn("has changed since", outcome.err)
            self.assertIn("fbi-gen reed.json again", outcome.err)

    def test_output_folder(self):
        self.generate(fiber_alone())
        run = self.run_program
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "nowhere/reed.run.h5"), 'no folder "nowhere"', "create it")
        self.assertFalse((self.folder / "nowhere").exists())
        # Nobody may write there, root neither.
        for ranks in (1, 2):
            self.expect_error(6, run("fbi-run", "reed.h5", "-o", "/proc/reed.run.h5", ranks=ranks), "/proc/reed.run")
        self.expect_error(1, run("fbi-run", "reed.h5", "-o", "results"), "does not end in .h5")

    def test_nothing_of_others_is_replaced(self):
        case = self.generate(fiber_alone())
        run = self.run_program
        mine = case.read_bytes()
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "reed.h5"), "would replace the case file", "-o")
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "./reed.h5", "--quiet"), "would replace the case file")
        self.assertEqual(case.read_bytes(), mine)
        (self.folder / "other.h5").write_bytes(mine)
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "other.h5"), "is not a result of fbi-run")
        self.assertEqual((self.folder / "other.h5").read_bytes(), mine)
        (self.folder / "data.csv").write_text("measured,by,hand\n1,2,x\n")
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "data.h5"), "data.csv", "is not a history of fbi-run")
        self.assertEqual((self.folder / "data.csv").read_text(), "measured,by,hand\n1,2,x\n")
        (self.folder / "notes").write_text("text")
        self.expect_error(6, run("fbi-run", "reed.h5", "-o", "notes.h5"), '"notes" is there and is not a folder')

    def test_unfinished_run_is_not_replaced_without_a_word(self):
        self.generate(fiber_alone())
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--steps", 6))
        outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertIn("an unfinished run in \"reed.run.h5\" is replaced (its last checkpoint: step 6", outcome.err)
        outcome = self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        self.assertEqual(outcome.err, "")


class FullDisk(ProgramTest):
    """By the file-size limit, set after the first checkpoint; two ranks write other files than one does."""

    def limit_file_sizes(self, pids, limit):
        """Between two files: room for the one at work is reserved already, which a full disk cannot take back."""
        between = False
        while not between:
            for pid in pids:
                os.kill(pid, signal.SIGSTOP)
            between = not list(self.folder.rglob("*.tmp.*"))
            if between:
                for pid in pids:
                    resource.prlimit(pid, resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
            for pid in pids:
                os.kill(pid, signal.SIGCONT)
            time.sleep(0.001)

    def fill(self, ranks, limit, case, *words):
        self.new_folder()
        reference = self.complete_run(case, "reference", ranks)
        self.generate(case)
        process = self.start("fbi-run", "reed.h5", ranks=ranks)
        self.assertTrue(self.wait_for(lambda: self.checkpoints(), process))
        self.limit_file_sizes(self.processes_of(process), limit)
        self.expect_error(6, self.finish(process), "cannot write", "ulimit -f", "--restart last goes on from step", *words)
        self.check_readable()
        self.assertFalse(self.is_complete())
        self.assertEqual(list(self.folder.rglob("*.tmp.*")), [])
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", "--restart", "last", ranks=ranks))
        self.expect_same_results(reference, self.folder)

    def sizes(self):
        """Bytes of an output and of a checkpoint."""
        folder = self.complete_run(reed(), f"sizes{time.monotonic_ns()}", 1, "--steps", 5)
        return [(folder / "reed.run" / name).stat().st_size for name in ("000005.h5", "restart-000005.h5")]

    # Long enough that the limit arrives before the end.
    STEPS = {"time": {"step": 1e-3, "end": 0.12}}

    def test_output(self):
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                # The index of the outputs does not fit either, where it comes first.
                self.fill(ranks, self.sizes()[0] - 1024, reed(**self.STEPS), "reed.run")

    def test_checkpoint(self):
        checkpoint = self.sizes()[1]
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.fill(ranks, checkpoint - 1024, reed(**self.STEPS, output__every=0), "reed.run/restart-0000")

    def test_history(self):
        probes = [{"point": [0.04 * k, 0.5, 0.1]} for k in range(1, 46)]
        case = reed(**self.STEPS, output__every=0, output__probes=probes)
        limit = self.sizes()[1] + 65536  # checkpoints still fit, with the room they reserve
        for ranks in (1, 2):
            with self.subTest(ranks=ranks):
                self.fill(ranks, limit, case, "reed.run.csv")

    def test_from_the_start(self):
        self.generate(reed())
        outcome = self.run_program("fbi-run", "reed.h5", file_size=65536)
        self.expect_error(6, outcome, "cannot write", "reed.run/mesh.h5", "ulimit -f")
        # An older run stays when there is no room for the new one.
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet"))
        before = {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()}
        self.expect_error(6, self.run_program("fbi-run", "reed.h5", file_size=65536), "mesh.h5")
        self.assertEqual(before, {path: path.read_bytes() for path in self.folder.rglob("*") if path.is_file()})

    def test_closed_standard_output(self):
        """A full disk behind standard output does not end a run."""
        self.generate(fiber_alone())
        with open("/dev/full", "w", encoding="ascii") as full:
            process = subprocess.run([str(BIN / "fbi-run"), "reed.h5"], cwd=self.folder, stdout=full, stderr=full)
        self.assertEqual(process.returncode, 0)
        self.assertTrue(self.is_complete())


if __name__ == "__main__":
    main()
