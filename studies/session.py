"""Run pytest in a subprocess, as a user does: the report it writes, its wall time and its CPU time."""

from __future__ import annotations

import argparse
import json
import os
import platform
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
    """A session did not run its tests; the message holds the command and its output."""


@dataclass(frozen=True)
class Session:
    """A finished session.

    Args:
        report: the content of `report.json`.
        wall_s: wall time.
        cpu_s: CPU time of pytest and its workers.
    """

    report: dict[str, Any]
    wall_s: float
    cpu_s: float


def run(folder: Path, arguments: Sequence[str], root: Path = ROOT) -> Session:
    """Run generated tests.

    Args:
        folder: of the report.
        arguments: of pytest.
        root: folder of the project to be tested.

    Raises:
        SessionError: pytest wrote no report, or a selected test has no result.
    """
    report_path = folder / "report.json"
    report_path.unlink(missing_ok=True)
    began_s, before_s = time.perf_counter(), _children_s()
    output = start([*arguments, f"--hri-report={folder}"], root)
    wall_s, cpu_s = time.perf_counter() - began_s, _children_s() - before_s
    if not report_path.is_file():
        raise SessionError(f"pytest wrote no {report_path}:\n{output}")
    report = json.loads(report_path.read_text(encoding="utf-8"))
    if report["not_run"] or report["reported"] != report["selected"]:
        raise SessionError(f"{report['selected']} tests selected, {report['reported']} reported:\n{output}")
    return Session(report, wall_s, cpu_s)


def start(arguments: Sequence[str], root: Path = ROOT) -> str:
    """Run pytest and return its output. Raises SessionError if it ended before it could run tests."""
    # Options and plugins of the session that a study may itself run in are not meant for this one.
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_"))}
    # Without the cache no session depends on an earlier one; generated tests do not use Hypothesis.
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


def arguments(doc: str | None, report: str) -> argparse.ArgumentParser:
    """The command line of a study that writes a page from a report.

    Args:
        doc: help text.
        report: default folder of the report.
    """
    parser = argparse.ArgumentParser(description=doc, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--report", type=Path, default=Path(report), metavar="DIR", help="folder of the report")
    parser.add_argument("--docs", type=Path, default=ROOT / "docs", metavar="DIR", help="folder of the page")
    parser.add_argument("--again", action="store_true", help="run no tests: use the report that is there")
    return parser


def report(options: argparse.Namespace, pytest_arguments: Sequence[str]) -> dict[str, Any]:
    """The report of a study: of a new run, or with `--again` the one that is there. Raises SessionError."""
    folder = options.report.resolve()
    if options.again:
        return read(folder)
    print(f"pytest {' '.join(pytest_arguments)} ...", flush=True)
    done = run(folder, pytest_arguments)
    print(f"{done.report['reported']} tests in {done.wall_s:.0f} s", flush=True)
    return done.report


def read(folder: Path) -> dict[str, Any]:
    """The report in a folder. Raises SessionError where there is none."""
    path = folder / "report.json"
    try:
        report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise SessionError(f"{path}: no report ({error}); leave out --again to run the tests") from None
    return report


def machine() -> str:
    """Processor, number of cores and Python version: figures are only comparable on the same machine."""
    model = platform.processor() or platform.machine()
    cpuinfo = Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [
            line.partition(":")[2].strip()
            for line in cpuinfo.read_text(encoding="utf-8").splitlines()
            if "model name" in line
        ]
        model = names[0] if names else model
    return f"{model}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
