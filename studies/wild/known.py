"""Known bugs of public packages, each at the commit before its fix and at the fix, and how one is measured."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from studies.wild import BENCHES, FOLDER, Package, Source
from studies.wild.running import add_closure_alone, measure

OWN_LIMIT_S = 600


@dataclass(frozen=True)
class KnownBug:
    """A bug that was reported and fixed.

    Args:
        before: the package at the commit before the fix.
        fix: the package at the fix, with the same testbench.
        report: address of the report.
        text: its words, from which the requirement was written.
        asked: the requirement.
        own: arguments of pytest that run the package's own tests; empty where it has none.
        own_needs: repository, commit and folder of what they need beside the package; empty where that is nothing.
        note: what has to be said of the result.
    """

    before: Package
    fix: Package
    report: str
    text: str
    asked: str
    own: tuple[str, ...]
    own_needs: tuple[str, ...]
    note: str

    @property
    def key(self) -> str:
        """Its name in `known.toml`."""
        return self.before.key

    def fingerprint(self) -> str:
        """Of all that decides a result but the plugin."""
        return f"{self.before.fingerprint()}-{self.fix.fingerprint()}-{self.asked}"


def known_bugs(path: Path = FOLDER / "known.toml") -> Iterator[KnownBug]:
    """All of them, in the order of the file."""
    for key, row in tomllib.loads(path.read_text(encoding="utf-8")).items():
        close_runs = row.get("close_runs", (0, 0))
        before = _package(key, row, row["before"], close_runs[0], 2)
        fix = _package(f"{key}_fix", row, row["fix"], close_runs[1], 0)
        own, needs = tuple(row.get("own", ())), tuple(row.get("own_needs", ()))
        yield KnownBug(before, fix, row["report"], row["text"], row["asked"], own, needs, row.get("note", ""))


def _package(key: str, row: dict[str, Any], commit: str, close_runs: int, cause_runs: int) -> Package:
    further = [Source(name, at, tuple(paths)) for name, at, *paths in row.get("needs", ())]
    return Package(
        key=key,
        title=row["title"],
        kind=row["kind"],
        sources=(Source(row["repository"], commit, tuple(row.get("paths", ()))), *further),
        benches=tuple(BENCHES / folder for folder in row["benches"]),
        python_path=tuple(row["python_path"]),
        reason="",
        tests=row.get("tests", 8),
        close_runs=close_runs,
        cause_runs=cause_runs,
        schedules=row.get("schedules", 0),
        verdicts={},
    )


def measure_known(bug: KnownBug, clones: Path) -> dict[str, Any]:
    """A row of the results. Raises FetchError and SessionError."""
    before, fix = (measure(package, clones) for package in (bug.before, bug.fix))
    for row, package in ((before, bug.before), (fix, bug.fix)):
        if package.close_runs:
            add_closure_alone(row, package, clones)
    own = own_result(*(_own(bug, clones, clones / package.key) for package in (bug.before, bug.fix)))
    return {
        "input": bug.fingerprint(),
        "lines": bug.before.lines(),
        "cpu_s": before["cpu_s"] + fix["cpu_s"],
        "found_by": violated_by(before, bug.asked),
        "schedules": before.get("schedules", {}),
        "fix_violated_by": violated_by(fix, bug.asked),
        "fix_checks": sum(
            suite["requirements"].get(bug.asked, {}).get("passed", 0) for suite in fix["suites"].values()
        ),
        "violations": [each for each in before["violations"] if bug.asked in (*each["requirements"], each.get("of"))],
        "others": sorted({name for each in before["violations"] for name in each["requirements"]} - {bug.asked}),
        "own": own,
    }


def violated_by(row: dict[str, Any], asked: str) -> list[str]:
    """Names of the suites that violate a requirement, and `schedules` where a race does."""
    suites = [name for name, suite in row["suites"].items() if suite["requirements"].get(asked, {}).get("failed")]
    races = any(each.get("of") == asked and each["counts"] for each in row["violations"])
    return [*suites, *(["schedules"] if races else [])]


def own_result(before: dict[str, str], fix: dict[str, str]) -> dict[str, Any]:
    """How many of a package's own tests passed before the fix, and which find the bug.

    Args:
        before: test -> "passed", "failed" or "error" at the commit before.
        fix: the same at the fix.
    """
    outcomes = [*before.values()]
    return {
        **{kind: outcomes.count(kind) for kind in ("passed", "failed", "error")},
        "find": sorted(test for test, outcome in before.items()
                       if outcome != "passed" and fix.get(test) == "passed"),
    }  # fmt: skip


def _own(bug: KnownBug, clones: Path, folder: Path) -> dict[str, str]:
    if not bug.own:
        return {}
    if bug.own_needs:
        repository, commit, place = bug.own_needs
        source = Source(repository, commit)
        source.copy(clones, folder / "own")
        shutil.copytree(folder / "own" / source.name, folder / place, dirs_exist_ok=True)
        for path in (folder / place).rglob("*"):
            path.chmod(path.stat().st_mode | 0o060)  # as its README asks for
    paths = [str(folder / each) for each in bug.before.python_path]
    for each in paths:
        if (Path(each) / "setup.py").exists():  # some ask for the version or the entry points of what is installed
            subprocess.run([sys.executable, "setup.py", "-q", "egg_info"], cwd=each, capture_output=True, check=False)
    (folder / "own.ini").write_text("[pytest]\n", encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:hricdv", "-p", "no:randomly", "-p", "no:cacheprovider",
               "-c", "own.ini", "--rootdir=.", "--confcutdir=src", "--junit-xml=own.xml", *bug.own]  # fmt: skip
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_"))}
    (folder / "own.xml").unlink(missing_ok=True)
    try:
        subprocess.run(command, cwd=folder, env={**environment, "PYTHONPATH": os.pathsep.join(paths)},
                       capture_output=True, check=False, timeout=OWN_LIMIT_S)  # fmt: skip
    except subprocess.TimeoutExpired:
        return {"all": "error"}
    return dict(_outcomes(folder / "own.xml"))


def _outcomes(path: Path) -> Iterator[tuple[str, str]]:
    if not path.exists():
        yield "all", "error"
        return
    for case in ElementTree.parse(path).iter("testcase"):
        kinds = {child.tag for child in case}
        outcome = "error" if "error" in kinds else "failed" if "failure" in kinds else "passed"
        if "skipped" not in kinds:
            yield f"{case.get('classname')}.{case.get('name')}", outcome
