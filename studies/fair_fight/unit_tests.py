"""Pynguin, which makes unit tests of modules, without a world; they are run on the code, and on that with faults."""

from __future__ import annotations

import json
import os
import re
import resource
import shutil
import subprocess
import sys
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from studies.fair_fight import CodeBase, faults
from studies.fair_fight.meter import plain
from studies.fair_fight.running import PATIENCE, children_s, environment, machine

START_S = 5.0
"""What a start of Pynguin takes of its share of the budget, by trial."""
LEAST_SEARCH_S = 2

_STAND_IN = "import sys\nfrom unittest.mock import MagicMock\n\nsys.modules[__name__] = MagicMock()\n"
"""Of a package that the testbench replaces, too, see studies/wild."""


def measure(base: CodeBase, work: Path, pynguin: str, python: str, budget_s: float) -> dict[str, Any]:
    """A row of the results."""
    folder = _filled(base, work, "pynguin")
    code = base.map(folder)
    modules = [_module(file.path.relative_to(folder.resolve()), base) for file in code.files if file.statements]
    began_s = children_s()
    reasons = [_generate(base, folder, module, pynguin, budget_s / len(modules)) for module in modules]
    used_s = children_s() - began_s
    tests = sorted((folder / "generated").glob("test_*.py"))
    row = {"budget_s": budget_s, "used_s": round(used_s, 1), "machine": machine(pynguin)}
    if not tests:
        return {**row, "runs": 0, "not_run": next(filter(None, reasons), "no test")}
    passed, covered = _run(base, folder, python, tests, measured=True)
    texts = "".join(path.read_text(encoding="utf-8") for path in tests)
    return {
        **row,
        "runs": len(re.findall(r"^def test_", texts, re.MULTILINE)),
        "expected_failures": texts.count("xfail(strict=True)"),
        "statements": [covered["covered_lines"], code.statements],
        "branches": [covered["covered_branches"], code.branches],
        "kinds": {},
        "first_s": None,
        "shortest": None,
        "control": sorted({*passed} - {*_run(base, folder, python, tests)[0]}),
        "noticed": {
            fault["id"]: _notice(base, work, python, tests, passed, fault) for fault in faults.sealed(base.name)
        },
    }


def _filled(base: CodeBase, work: Path, name: str) -> Path:
    folder = work / f"{base.name}-{name}"
    base.fill(folder, work / "clones")
    (folder / "generated").mkdir()
    (folder / "generated" / "av.py").write_text(_STAND_IN, encoding="utf-8")
    return folder


def _module(path: Path, base: CodeBase) -> str:
    """The importable name of a file of a code base."""
    for place in base.python_path:
        path = path.relative_to(place) if path.is_relative_to(place) else path
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")


def _environment(base: CodeBase, folder: Path) -> dict[str, str]:
    variables = environment(base, folder)
    path = os.pathsep.join((variables["PYTHONPATH"], str(folder / "generated")))
    return variables | {"PYTHONPATH": path, "PYNGUIN_DANGER_AWARE": "1"}


def _generate(base: CodeBase, folder: Path, module: str, pynguin: str, share_s: float) -> str:
    """Make tests of a module. Returns why there are none, or nothing."""
    seconds = max(LEAST_SEARCH_S, int(share_s - START_S))
    place = next((folder / each for each in base.python_path), folder)
    limits = (int(share_s + START_S) + 5,) * 2
    command = [
        *(pynguin, "-m", "pynguin", "--project-path", str(place), "--module-name", module, "--seed", "0"),
        *("--output-path", str(folder / "generated"), "--maximum-search-time", str(seconds)),
    ]
    try:
        done = subprocess.run(
            command,
            cwd=folder,
            env=_environment(base, folder),
            capture_output=True,
            text=True,
            check=False,
            timeout=PATIENCE * share_s,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, limits),
        )
    except subprocess.TimeoutExpired:
        return "waits in real time, and made no test"
    lines = (done.stderr or done.stdout).strip().splitlines()
    return plain(lines[-1]) if done.returncode and lines else ""


def _run(
    base: CodeBase, folder: Path, python: str, tests: Sequence[Path], *, measured: bool = False
) -> tuple[list[str], dict[str, int]]:
    """The tests that pass, or fail as they expect; and the totals of coverage."""
    report = folder / "coverage.json"
    cover = [f"--cov={name}" for name in base.code] + ["--cov-branch", f"--cov-report=json:{report}"]
    done = subprocess.run(
        [python or sys.executable, "-m", "pytest", "-rA", "-q", "--tb=no", "--noconftest", "-p", "no:cacheprovider",
         "-c", os.devnull, "--rootdir", str(folder / "generated"), *(cover if measured else ()), *map(str, tests)],
        cwd=folder,
        env=_environment(base, folder),
        capture_output=True,
        text=True,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (60, 60)),
    )  # fmt: skip
    passed = re.findall(r"^(?:PASSED|XFAIL) \S*?(test_\w+\.py::\w+)", done.stdout, re.MULTILINE)
    return passed, json.loads(report.read_text(encoding="utf-8"))["totals"] if measured else {}


def _notice(
    base: CodeBase, work: Path, python: str, tests: Sequence[Path], passed: Collection[str], fault: dict[str, str]
) -> list[str]:
    folder = _filled(base, work, "pynguin-faulty")
    faults.plant(fault, folder)
    copies = [Path(shutil.copy(path, folder / "generated")) for path in tests]
    return sorted({*passed} - {*_run(base, folder, python, copies)[0]})[:3]
