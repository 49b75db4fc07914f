#!/usr/bin/env python3
"""Runs the examples of a Markdown page: run_examples.py PAGE --root REPOSITORY --bin FOLDER

Fenced blocks are read in order; the words after the language say what to do with them (a viewer does not show these):

  ```json file=NAME          a whole case: written to NAME, given to fbi-gen --check
  ```json part-of=NAME       some keys of a case: they replace those of NAME, the result is given to fbi-gen --check
  ```sh                      run by bash -e in a scratch folder that all blocks of the page share, programs in PATH
  ```sh exit=CODE            the same, and the last command must end with CODE
  ```sh not-run=REASON       too long or in need of a network; still its scripts, make targets and programs must exist

Every block marked json or sh must be one of these. A page without such blocks fails: the test would say nothing.
"""
import argparse
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

FENCE = re.compile(r"^```(\S*)\s*(.*)$")


def blocks_of(text):
    """[(line, language, {word: value}, content)] of the fenced blocks."""
    blocks, start = [], None
    for number, line in enumerate(text.splitlines(), 1):
        match = FENCE.match(line)
        if not match:
            if start:
                content.append(line)
        elif start:
            blocks.append((start, language, words, "\n".join(content) + "\n"))
            start = None
        else:
            start, language, content = number, match[1], []
            words = dict((word.split("=", 1) + [""])[:2] for word in match[2].split())
    if start:
        raise SystemExit(f"line {start}: block without end")
    return blocks


def without_comments(text):
    """JSON text without // comments (outside of strings)."""
    return re.sub(r'("(?:[^"\\]|\\.)*")|//[^\n]*', lambda m: m[1] or "", text)


class Page:
    def __init__(self, root, programs, scratch):
        self.root, self.scratch = root, scratch
        self.env = dict(os.environ, PATH=f"{programs}{os.pathsep}{os.environ['PATH']}")

    def run(self, command, folder=None):
        done = subprocess.run(command, cwd=folder or self.scratch, env=self.env, stdin=subprocess.DEVNULL, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        return done.returncode, done.stdout

    def check_case(self, name):
        code, output = self.run(["fbi-gen", "--check", name])
        return "" if code == 0 else f"fbi-gen --check ended with {code}\n{output}"

    def json(self, words, content):
        if "file" in words:
            (self.scratch / words["file"]).write_text(content)
            return self.check_case(words["file"])
        if "part-of" not in words:
            return "a json block needs file=NAME or part-of=NAME"
        whole = json.loads(without_comments((self.scratch / words["part-of"]).read_text()))
        whole.update(json.loads("{" + without_comments(content) + "}"))
        (self.scratch / "part.json").write_text(json.dumps(whole))
        return self.check_case("part.json")

    def sh(self, words, content):
        if "not-run" in words:
            if not words["not-run"]:
                return "not-run needs a reason"
            problems = [self.exists(line) for line in content.replace("\\\n", " ").splitlines()]
            return "\n".join(problem for problem in problems if problem)
        wanted = int(words.get("exit", "0"))
        code, output = self.run(["bash", "-e", "-o", "pipefail", "-c", content])
        return "" if code == wanted else f"ended with {code} instead of {wanted}\n{output}"

    def exists(self, line):
        """Why a command that is not run would not even start; empty if it would."""
        words = shlex.split(line, comments=True)
        while words and re.fullmatch(r"\w+=.*", words[0]):
            words = words[1:]
        if not words or words[0] in ("git", "cd", "apt-get", "export"):
            return ""
        if words[0] == "mpirun":
            words = [word for word in words if word.startswith("fbi-")] or words
        if words[0] == "make":
            programs = self.env["PATH"].split(os.pathsep)[0]
            code, output = self.run(["make", "-n", "BIN=" + programs] + words[1:], self.root)
            return "" if code == 0 else f"{line}: {output}"
        if "/" in words[0]:
            found = os.access(self.root / words[0], os.X_OK)
            return "" if found else f"{line}: {words[0]} is not an executable of the repository"
        code, _ = self.run(["bash", "-c", f"command -v {shlex.quote(words[0])}"])
        return "" if code == 0 else f"{line}: {words[0]} is not a known command"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("page", type=pathlib.Path)
    parser.add_argument("--root", type=pathlib.Path, required=True)
    parser.add_argument("--bin", type=pathlib.Path, required=True)
    arguments = parser.parse_args()
    count = failed = 0
    with tempfile.TemporaryDirectory() as scratch:
        page = Page(arguments.root.resolve(), arguments.bin.resolve(), pathlib.Path(scratch))
        for line, language, words, content in blocks_of(arguments.page.read_text(encoding="utf-8")):
            if language not in ("json", "sh"):
                continue
            count += 1
            problem = page.json(words, content) if language == "json" else page.sh(words, content)
            print(f"{arguments.page}:{line}: {'failed: ' + problem if problem else 'ok'}", flush=True)
            failed += bool(problem)
    print(f"{count} examples, {failed} failed")
    return 1 if failed or not count else 0


if __name__ == "__main__":
    sys.exit(main())
