#!/usr/bin/env python3
"""tools/schemes: one row a scheme and density, failed runs included; what it says about mistakes."""
import json
import pathlib
import subprocess
import sys

from programs import BIN, ProgramTest, environment, main, reed

TOOL = pathlib.Path(__file__).resolve().parents[2] / "tools" / "schemes"


class Schemes(ProgramTest):

    def tool(self, *arguments):
        return subprocess.run([sys.executable, TOOL, "--bin", BIN, *map(str, arguments)], cwd=self.folder, text=True,
                              capture_output=True, env=environment())

    def test_table_of_schemes_and_densities(self):
        case = reed(coupling={"scheme": "aitken", "max_iterations": 7, "geometry_update": "iterated"})
        (self.folder / "reed.json").write_text("// a comment\n" + json.dumps(case))
        outcome = self.tool("reed.json", "--steps", 3, "--density", 100, 0.01, "--scheme", "aitken", "monolithic",
                            "--set", "coupling.max_iterations=30", "-o", "out")
        self.assertEqual(outcome.returncode, 0, outcome)
        lines = [[cell.strip() for cell in line.split("|")[1:-1]] for line in outcome.stdout.splitlines()]
        self.assertEqual(lines[0][:3], ["scheme", "density", "steps"])
        self.assertEqual(lines[0][-1], "failed at")
        rows = lines[2:]
        self.assertEqual([row[:3] for row in rows], [["aitken", "100", "3"], ["monolithic", "100", "3"],
                                                     ["aitken", "0.01", "0"], ["monolithic", "0.01", "3"]])
        self.assertEqual([row[-1] for row in rows], ["-", "-", "1", "-"])  # much lighter than the water it moves
        self.assertGreater(float(rows[0][3]), 1.0)
        self.assertEqual(float(rows[1][3]), 1.0)
        self.assertEqual((self.folder / "out" / "reed.schemes.md").read_text(), outcome.stdout)
        self.assertTrue((self.folder / "out" / "density-100" / "compare.iterations.svg").exists())
        written = (self.folder / "out" / "density-100" / "monolithic.json").read_text()
        self.assertIn('"geometry_update": "iterated"', written)
        self.assertNotIn("max_iterations", written)

    def test_mistakes(self):
        self.assertIn("nothing.json", self.tool("nothing.json").stderr)
        (self.folder / "reed.json").write_text(json.dumps(reed()))
        outcome = self.tool("reed.json", "--steps", 1, "--set", "coupling.tolerence=1", "--scheme", "aitken")
        self.assertEqual(outcome.returncode, 1)
        self.assertIn("did you mean", outcome.stderr)
        self.assertEqual(self.tool("reed.json", "--scheme", "aitkin").returncode, 2)


if __name__ == "__main__":
    main()
