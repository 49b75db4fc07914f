#!/usr/bin/env python3
"""Tests of run_examples.py: wrong examples are noticed."""
import pathlib
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).parent
# Stands for fbi-gen: fails when the case does not hold the word "good".
GENERATOR = '#!/bin/sh\n[ "$1" = --check ] && grep -q good "$2"\n'


def run(page):
    """(exit code, output) for the text of a page."""
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        (folder / "page.md").write_text(page)
        (folder / "fbi-gen").write_text(GENERATOR)
        (folder / "fbi-gen").chmod(0o755)
        (folder / "cases").mkdir()
        (folder / "cases" / "Makefile").write_text("known:\n\ttrue\n")
        command = [sys.executable, HERE / "run_examples.py", "page.md", "--root", ".", "--bin", "."]
        done = subprocess.run(command, cwd=folder, text=True, capture_output=True)
        return done.returncode, done.stdout + done.stderr


def block(head, content):
    return f"Text.\n\n```{head}\n{content}\n```\n\nMore text.\n"


class RunExamples(unittest.TestCase):
    def expect(self, code, page, text=""):
        result, output = run(page)
        self.assertEqual(result, code, output)
        self.assertIn(text, output)

    def test_good_page(self):
        self.expect(0, block("json file=a.json", '{"good": 1} // a comment') + block("sh", "fbi-gen --check a.json") +
                    block("json part-of=a.json", '"other": "http://x" // replaced') + block("sh exit=3", "exit 3") +
                    block("sh not-run=long", "A=1 make -C cases \\\n  known  # a comment") + block("text", "anything"),
                    "5 examples, 0 failed")

    def test_failures(self):
        self.expect(1, block("sh", "false\ntrue"), "ended with 1 instead of 0")
        self.expect(1, block("sh exit=3", "exit 1"), "ended with 1 instead of 3")
        self.expect(1, block("json file=a.json", '{"bad": 1}'), "fbi-gen --check ended with 1")
        self.expect(1, block("json file=a.json", '{"good": 1}') + block("json part-of=a.json", '"good": 2, "x'))
        self.expect(1, block("json", '{"good": 1}'), "needs file=NAME or part-of=NAME")

    def test_commands_that_are_not_run_must_exist(self):
        self.expect(1, block("sh not-run=long", "make -C cases unknown"), "unknown")
        self.expect(1, block("sh not-run=long", "tools/none"), "not an executable")
        self.expect(1, block("sh not-run=long", "fbi-nothing a.h5"), "not a known command")
        self.expect(1, block("sh not-run", "true"), "needs a reason")

    def test_page_without_examples(self):
        self.expect(1, "Text.\n", "0 examples")

    def test_block_without_end(self):
        self.expect(1, "```sh\ntrue\n", "without end")


if __name__ == "__main__":
    unittest.main()
