"""The three programs as a user meets them: small cases, how to start and stop runs, and how to compare what they leave.

Needs FBI_BIN (folder of the programs) and FBI_MPIRUN in the environment; h5diff and h5dump read the files independently.
"""
import copy
import json
import os
import pathlib
import re
import resource
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["FBI_BIN"])
MPIRUN = os.environ["FBI_MPIRUN"]
PATIENCE = 120  # seconds until a program counts as hanging

# A reed in a channel: 540 unknowns of the fluid, 24 of the fiber, about 10 ms a step.
REED = {
    "title": "A reed in a channel",
    "fluid": {"density": 1, "viscosity": 0.01},
    "channel": {
        "size": [2, 1, 0.25],
        "elements": [8, 4, 2],
        "boundaries": {
            "xmin": {"type": "inflow", "velocity": ["4*y*(1-y)*sin(20*t)", 0, 0]},
            "xmax": {"type": "outflow"},
            "ymin": {"type": "no_slip"},
            "ymax": {"type": "slip"},
            "zmin": {"type": "slip"},
            "zmax": {"type": "slip"},
        },
    },
    "fibers": [{
        "name": "reed",
        "curve": {"type": "line", "from": [1, 0, 0.12], "to": [1, 0.5, 0.12]},
        "elements": 3,
        "section": {"radius": 0.01},
        "material": {"young": 1e6, "density": 10},
        "clamped": "start",
    }],
    "time": {"step": 1e-3, "end": 0.02},
    "output": {"every": 5, "checkpoint": 5, "probes": [{"fiber": "reed"}, {"fiber": "reed", "forces": True},
                                                       {"point": [0.5, 0.5, 0.1]}]},
}


def reed(**changes):
    """REED with other values: path with __ between the keys = value; None removes the key."""
    case = copy.deepcopy(REED)
    for path, value in changes.items():
        *parents, last = path.split("__")
        table = case
        for key in parents:
            table = table.setdefault(key, {})
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return case


def without_fibers(**changes):
    changes.setdefault("output", {"every": 5, "checkpoint": 5, "probes": [{"point": [0.5, 0.5, 0.1]}]})
    return reed(fibers=None, **changes)


def fiber_alone(**changes):
    """A cantilever under an end force, without fluid."""
    changes.setdefault("output", {"every": 5, "checkpoint": 5, "probes": [{"fiber": "reed"}]})
    case = reed(fluid=None, channel=None, **changes)
    case["fibers"][0]["loads"] = [{"type": "force", "at": "end", "value": ["0.01*sin(50*t)", 0, 0]}]
    return case


class Outcome:
    """How a program ended: exit code and what it wrote, without the remarks of mpirun."""

    def __init__(self, code, out, err):
        self.code, self.out = code, out
        self.err = self.without_mpirun(err)

    @staticmethod
    def without_mpirun(text):
        kept, inside = [], False
        for line in text.splitlines(keepends=True):
            if re.fullmatch(r"-{60,}\n?", line):
                inside = not inside
            elif not inside and not line.startswith("mpirun: "):
                kept.append(line)
        return "".join(kept)

    def __str__(self):
        return f"exit {self.code}\n--- out\n{self.out}--- err\n{self.err}"


def environment():
    settings = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OPENBLAS_NUM_THREADS": "1",
                "OMP_NUM_THREADS": "1", "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
                "OMPI_MCA_hwloc_base_binding_policy": "none", "OMPI_MCA_mpi_yield_when_idle": "1"}
    return {**os.environ, **settings}


def command(program, arguments, ranks):
    launch = [MPIRUN, "--oversubscribe", "-n", str(ranks)] if ranks > 1 else []
    return [*launch, str(BIN / program), *map(str, arguments)]


def limit_file_size(limit):
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))


def table_of(path):
    """Columns and rows (as texts) of a history; an unfinished last row is left out."""
    lines = [line for line in path.read_text().split("\n")[:-1] if line and not line.startswith("#")]
    return lines[0].split(","), [line.split(",") for line in lines[1:]]


def dataset(path, name, code="d"):
    """The numbers of an HDF5 dataset, row after row, as h5dump writes them; code of struct: d double, i 4 bytes."""
    with tempfile.NamedTemporaryFile() as raw:
        subprocess.run(["h5dump", "-d", name, "-b", "LE", "-o", raw.name, str(path)], check=True, capture_output=True)
        data = pathlib.Path(raw.name).read_bytes()
    return list(struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data))


class ProgramTest(unittest.TestCase):
    """One scratch folder a test."""

    def setUp(self):
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="fbi_programs_"))
        self.addCleanup(shutil.rmtree, self.root, ignore_errors=True)
        self.new_folder()

    def new_folder(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(dir=self.root))

    # ------------------------------------------------------------------ running

    def start(self, program, *arguments, ranks=1, file_size=None, folder=None):
        # MPI itself needs larger files, but for these settings.
        settings = {"PMIX_MCA_gds": "hash", "OMPI_MCA_btl": "self"} if file_size else {}
        return subprocess.Popen(command(program, arguments, ranks), cwd=folder or self.folder,
                                env={**environment(), **settings}, text=True,
                                stdin=subprocess.DEVNULL, start_new_session=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                preexec_fn=limit_file_size(file_size) if file_size else None)

    def finish(self, process):
        try:
            out, err = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            for pid in self.processes_of(process):
                os.kill(pid, signal.SIGKILL)
            process.kill()
            out, err = process.communicate()
            self.fail(f"{' '.join(map(str, process.args))} hangs\n{out}\n{err}")
        return Outcome(process.returncode, out, err)

    def finish_killed(self, process):
        """As finish(), but mpirun is ended when it goes on waiting for ranks that are dead: Open MPI's may do so for ever
        after a rank was killed while it started them."""
        deadline = time.monotonic() + PATIENCE
        while process.poll() is None and time.monotonic() < deadline:
            try:
                out, err = process.communicate(timeout=PATIENCE / 10)
                return Outcome(process.returncode, out, err)
            except subprocess.TimeoutExpired:
                if all(self.is_dead(pid) for pid in self.processes_of(process)):
                    process.kill()
        return self.finish(process)

    @staticmethod
    def is_dead(pid):
        try:
            return pathlib.Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0] == "Z"
        except (OSError, IndexError):
            return True

    def run_program(self, program, *arguments, **how):
        return self.finish(self.start(program, *arguments, **how))

    def expect_code(self, code, outcome):
        self.assertEqual(outcome.code, code, str(outcome))
        return outcome

    def expect_error(self, code, outcome, *words):
        """Exit code, and one error text (not one a rank) that holds all the words."""
        self.expect_code(code, outcome)
        self.assertEqual(len(re.findall(r"^error: ", outcome.err, re.MULTILINE)), 1, str(outcome))
        for word in words:
            self.assertIn(word, outcome.err, str(outcome))
        return outcome

    def generate(self, case, name="reed", folder=None):
        folder = folder or self.folder
        folder.mkdir(exist_ok=True)
        (folder / f"{name}.json").write_text(json.dumps(case, indent=1))
        self.expect_code(0, self.run_program("fbi-gen", f"{name}.json", "--quiet", folder=folder))
        return folder / f"{name}.h5"

    def complete_run(self, case, folder, ranks=1, *arguments):
        """The uninterrupted run others are compared with."""
        folder = self.folder / folder
        self.generate(case, folder=folder)
        self.expect_code(0, self.run_program("fbi-run", "reed.h5", "--quiet", *arguments, ranks=ranks, folder=folder))
        return folder

    def processes_of(self, process):
        """The ranks of a run: children of mpirun, or the process itself."""
        if "mpirun" not in str(process.args[0]) and "mpiexec" not in str(process.args[0]):
            return [process.pid]
        pids = []
        for entry in pathlib.Path("/proc").iterdir():
            try:
                if entry.name.isdigit() and int((entry / "stat").read_text().rsplit(")", 1)[1].split()[1]) == process.pid:
                    pids.append(int(entry.name))
            except (OSError, IndexError):
                pass
        return pids

    def wait_for(self, condition, process):
        """Until condition() is true; False when the process ended before."""
        deadline = time.monotonic() + PATIENCE
        while not condition():
            if process.poll() is not None:
                return condition()
            self.assertLess(time.monotonic(), deadline, "nothing happens")
            time.sleep(0.002)
        return True

    def rows_written(self, folder=None):
        path = (folder or self.folder) / "reed.run.csv"
        return len(table_of(path)[1]) if path.exists() and path.read_text().count("\n") > 3 else 0

    # ------------------------------------------------------------------ results

    def checkpoints(self, folder=None):
        return sorted(int(path.stem[8:]) for path in (folder or self.folder).glob("reed.run/restart-*.h5"))

    def outputs(self, folder=None):
        return sorted(int(path.stem) for path in (folder or self.folder).glob("reed.run/[0-9]*.h5"))

    def is_complete(self, folder=None):
        text = subprocess.run(["h5dump", "-a", "/provenance/complete", "reed.run.h5"], cwd=folder or self.folder,
                              check=True, capture_output=True, text=True).stdout
        return "(0): 1" in text

    def check_readable(self, folder=None):
        """Every file under a final name is whole, and holds finite numbers only."""
        folder = folder or self.folder
        files = [*folder.glob("*.h5"), *folder.glob("*.run/*.h5")]
        self.assertGreater(len(files), 2)
        self.expect_code(0, self.run_program("fbi-post", "info", *files, folder=folder))
        for file in files:
            dump = subprocess.run(["h5dump", str(file)], capture_output=True, text=True)
            self.assertEqual(dump.returncode, 0, f"{file}\n{dump.stderr}")
            self.assertIsNone(re.search(r"[ ,]-?(nan|inf)\b", dump.stdout), file)
        for row in table_of(folder / "reed.run.csv")[1] if (folder / "reed.run.csv").exists() else []:
            self.assertNotRegex(",".join(row), r"nan|inf")

    def expect_same_results(self, a, b, tolerance=None, state=True):
        """Step files, newest checkpoint and history of two run folders: bitwise, or to an absolute tolerance."""
        self.assertEqual(self.outputs(a), self.outputs(b))
        names = [f"reed.run/{step:06d}.h5" for step in self.outputs(a)]
        if state:
            self.assertEqual(self.checkpoints(a)[-1], self.checkpoints(b)[-1])
            names.append(f"reed.run/restart-{self.checkpoints(a)[-1]:06d}.h5")
        for name in names:
            difference = subprocess.run(["h5diff", *(["-d", str(tolerance)] if tolerance else []), str(a / name),
                                         str(b / name)], capture_output=True, text=True)
            self.assertEqual(difference.returncode, 0, f"{name}\n{difference.stdout[:2000]}{difference.stderr}")
        columns, rows = table_of(a / "reed.run.csv")
        other_columns, other_rows = table_of(b / "reed.run.csv")
        self.assertEqual(columns, other_columns)
        self.assertEqual(len(rows), len(other_rows))
        for row, other in zip(rows, other_rows):
            for column, x, y in zip(columns, row, other):
                if column == "wall_seconds" or (tolerance and column in ("newton", "krylov", "residual", "evaluations")):
                    continue
                if tolerance:
                    self.assertAlmostEqual(float(x), float(y), delta=tolerance, msg=f"{column} of step {row[0]}")
                else:
                    self.assertEqual(x, y, f"{column} of step {row[0]}")


def main():
    unittest.main(verbosity=2)
