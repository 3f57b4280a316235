"""Pages with examples that tests run: files to write, and commands with their output."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
from pathlib import Path

from studies.examples import Block, blocks_of, write_files

__all__ = ["DOCS", "Block", "blocks", "commands", "differences", "follow", "run", "write_files"]

DOCS = Path(__file__).parents[2] / "docs"
_EXIT = re.compile(r"\[exit (\d+)\]")
_ENVIRONMENT = ("PYTEST_ADDOPTS", "PYTEST_XDIST_WORKER", "FORCE_COLOR", "GITHUB_ACTIONS", "GITHUB_STEP_SUMMARY")


def blocks(page: str) -> list[Block]:
    """The blocks of a page in docs/, in order."""
    return blocks_of(DOCS / page)


def commands(console: str) -> list[tuple[str, list[str]]]:
    """The commands of a console block, each with the lines shown below it."""
    found: list[tuple[str, list[str]]] = []
    for line in console.splitlines():
        if line.startswith("$ "):
            found.append((line[2:], []))
        else:
            found[-1][1].append(line)
    return found


def run(command: str, folder: Path) -> tuple[int, str]:
    """Run a command of a page as its reader would; returns its exit status and its output."""
    program, *arguments = shlex.split(command)
    module = {"python": [], "pytest": ["-m", "pytest"], "hricdv": ["-m", "pytest_hricdv"]}[program]
    environment = {name: value for name, value in os.environ.items() if name not in _ENVIRONMENT} | {"COLUMNS": "80"}
    done = subprocess.run(
        [sys.executable, *module, *arguments],
        cwd=folder,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=120,
    )
    return done.returncode, done.stdout


def differences(shown: list[str], status: int, printed: str) -> str:
    """The first difference between the output and the page; empty if there is none.

    On a page, a line `...` stands for any lines, `...` within a line for any text, and a last line `[exit 1]` for the
    exit status, which is 0 by default.
    """
    *lines, last = shown or [""]
    said = _EXIT.fullmatch(last)
    expected = int(said[1]) if said else 0
    if status != expected:
        return f"exit status {status}, and the page says {expected}:\n{printed}"
    output = printed.splitlines()
    # A long line is wrapped where the page shows it as one.
    rest = iter([" ".join([line, *map(str.strip, output[n : n + 2])]) for n, line in enumerate(output, 1)])
    for line in lines if said else shown:
        if line == "...":
            continue
        pattern = ".*".join(map(re.escape, line.split("...")))
        if not any(re.search(pattern, each) for each in rest):
            return f"no line like {line!r} where the page shows it:\n{printed}"
    return ""


def follow(page: str, folder: Path) -> int:
    """Do what a page in docs/ says, in a folder; returns the number of commands, whose output has to be that shown."""
    ran = 0
    for block in blocks(page):
        if block.kind == "console":
            for command, shown in commands(block.text):
                if command.startswith("cd "):
                    folder /= command.removeprefix("cd ")
                    continue
                status, printed = run(command, folder)
                assert not (found := differences(shown, status, printed)), f"$ {command}\n{found}"
                ran += 1
        write_files([block], folder)
    return ran
