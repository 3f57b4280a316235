"""pytest as a user runs it in this repository: in a subprocess, with report and cache in the folder of a test."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from tests.hri.bench import ROOT

HOST = "tests/hri/test_table_assembly.py"
TIMEOUT_S = 300


@dataclass(frozen=True)
class Session:
    """A finished session: exit code, output, and report."""

    code: int
    output: str
    report: dict[str, Any]

    @property
    def tests(self) -> dict[str, dict[str, Any]]:
        """Node id -> entry of the report, without the wall time, which is the only value that may differ."""
        return {test["nodeid"]: {k: v for k, v in test.items() if k != "wall_s"} for test in self.report["tests"]}


def pytest_run(folder: Path, *arguments: str) -> Session:
    """Run pytest, without an audit; learned suites are kept in `folder` for the next call."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_"))}
    done = subprocess.run(
        [
            *(sys.executable, "-m", "pytest", "-q", "-o", f"cache_dir={folder / 'cache'}"),
            *("-p", "no:hypothesispytest", "--hri-audit=off", f"--hri-report={folder / 'report'}", *arguments),
        ],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        timeout=TIMEOUT_S,
        check=False,
    )
    path = folder / "report" / "report.json"
    report = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return Session(done.returncode, done.stdout + done.stderr, report)
