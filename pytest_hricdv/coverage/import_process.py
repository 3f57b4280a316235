"""`import_again`: measures what importing modules covers, in a fresh process.

`ImportCoverage` needs it for modules that were loaded before it could follow imports.
"""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pytest_hricdv._base.hash_seed import environment_of_child
from pytest_hricdv.coverage.own_coverage import OwnCoverage, literally

TIMEOUT_S = 120
"""Time limit (s) of all imports together (chosen): a hundred times what the imports of the table example's controller
take, so that only an import that waits for something exceeds it."""


@dataclass(frozen=True)
class ImportAnswer:
    """The coverage of imports, by file; and why modules could not be imported, by name."""

    lines: dict[str, list[int]] = field(default_factory=dict)
    arcs: dict[str, list[tuple[int, int]]] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)


def import_again(names: Sequence[str], files: Sequence[str], before: Sequence[str] = ()) -> ImportAnswer:
    """Import modules in a fresh process. One that cannot be imported there has its reason in the answer.

    Args:
        names: the names of the modules, in the order in which they were imported.
        files: the files that are measured.
        before: functions without arguments, as "package.module:name", that are called before.
    """
    with tempfile.TemporaryDirectory(prefix="hricdv-") as folder:
        answer = Path(folder) / "answer.json"
        task = {"names": names, "files": files, "before": before, "answer": str(answer)}
        try:
            process = subprocess.run(
                [sys.executable, "-m", __name__],
                input=json.dumps(task),
                capture_output=True,
                text=True,
                encoding="utf-8",
                errors="replace",
                env=environment_of_child(),
                timeout=TIMEOUT_S,
            )
            problem = f"was imported in a process that ended with status {process.returncode}"
        except subprocess.TimeoutExpired:
            problem = f"was imported in a process that took more than {TIMEOUT_S} s"
        try:
            read = json.loads(answer.read_text(encoding="utf-8"))
        except (OSError, ValueError):  # it ended before it could write
            return ImportAnswer(problems=dict.fromkeys(names, problem))
    arcs = {file: [(start, end) for start, end in listed] for file, listed in read["arcs"].items()}
    return ImportAnswer(read["lines"], arcs, read["problems"])


def describe_error(error: BaseException) -> str:
    """The raised error in one line."""
    return " ".join(f"{type(error).__name__}: {error}".removesuffix(": ").split())


def main() -> None:
    """Do the task on standard input; the answer is written into the file that it names."""
    task = json.load(sys.stdin)
    for name in task["before"]:
        pkgutil.resolve_name(name)()
    own, problems = OwnCoverage([literally(file) for file in task["files"]]), dict[str, str]()
    for name in task["names"]:
        with own.record(name):
            try:
                importlib.import_module(name)
            except BaseException as error:  # also SystemExit
                problems[name] = f"raised {describe_error(error)}"
    data = own.data()
    answer: dict[str, Any] = {
        "lines": {name: data.lines(name) or [] for name in task["files"]},
        "arcs": {name: data.arcs(name) or [] for name in task["files"]},
        "problems": problems,
    }
    Path(task["answer"]).write_text(json.dumps(answer), encoding="utf-8")
    os._exit(0)  # threads that a module has started would keep the process


if __name__ == "__main__":
    main()
