"""pytest in a process of its own, as a user runs it, with the report it leaves and the processor time it took."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]

FINISHED = (0, 1)
"""Exit codes of a session that ran its tests: all passed, or some failed."""


class SessionError(Exception):
    """A session did not run its tests; the text says what was run and ends with what it printed."""


@dataclass(frozen=True)
class Session:
    """A finished session.

    Args:
        report: what `report.json` holds.
        wall_s: how long it took.
        cpu_s: processor time of pytest and its workers.
    """

    report: dict[str, Any]
    wall_s: float
    cpu_s: float


def run(folder: Path, arguments: Sequence[str], root: Path = ROOT) -> Session:
    """Run generated tests.

    Args:
        folder: the report goes into.
        arguments: of pytest.
        root: the project whose tests they are.

    Raises:
        SessionError: pytest ended without a report, or a selected test left no result.
    """
    report_path = folder / "report.json"
    report_path.unlink(missing_ok=True)
    began_s, before_s = time.perf_counter(), _children_s()
    output = start([*arguments, f"--hri-report={folder}"], root)
    wall_s, cpu_s = time.perf_counter() - began_s, _children_s() - before_s
    if not report_path.is_file():
        raise SessionError(f"pytest left no {report_path}:\n{output}")
    report = json.loads(report_path.read_text(encoding="utf-8"))
    if report["not_run"] or report["reported"] != report["selected"]:
        raise SessionError(f"{report['selected']} tests selected, {report['reported']} reported:\n{output}")
    return Session(report, wall_s, cpu_s)


def start(arguments: Sequence[str], root: Path = ROOT) -> str:
    """Run pytest and return what it printed. Raises SessionError when it did not come to run tests."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_"))}
    # A cache would let one session's suites depend on another's; Hypothesis has no part in generated tests.
    quiet = ["-q", "--tb=no", "-p", "no:cacheprovider", "-p", "no:hypothesispytest"]
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *quiet, *arguments],
        cwd=root,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    output = done.stdout + done.stderr
    if done.returncode not in FINISHED:
        raise SessionError(f"pytest {' '.join(arguments)} ended with {done.returncode}:\n{output}")
    return output


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
