"""Run a package's suites, and say what came: coverage, violations with cause and replay, what went wrong."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from studies import session
from studies.wild import Package

REPORT = "hri-report"
ALONE = "closure alone"
OPTIONS = (
    "--hri-seed=0",
    "--hri-audit=off",
    "-p",
    "no:randomly",
)


def measure(package: Package, clones: Path) -> dict[str, Any]:
    """A row of the results. Raises FetchError and SessionError."""
    row: dict[str, Any] = {
        "commit": package.sources[0].commit,
        "input": package.fingerprint(),
        "lines": package.lines(),
    }
    if package.reason:
        return {**row, "not_run": package.reason}
    folder = package.lay(clones)
    suite = ("--hri-suite=rl", f"--hri-tests={package.tests}")
    done = session.run(folder / REPORT, [*suite, *OPTIONS, *_searches(package)], folder)
    row["cpu_s"] = round(done.cpu_s)
    row["suites"] = {suite["name"]: _summary(suite, done.report) for suite in done.report["suites"]}
    row["violations"] = [*_violations(done.report)]
    if package.schedules:
        searched = done.report["schedules"]
        row["schedules"] = {"runs": searched["runs"], "ended": searched.get("end_reason", "done")}
    return row


def add_closure_alone(row: dict[str, Any], package: Package, clones: Path) -> None:
    """Add to the row of `measure` what `closure` finds without `rl`, in as many runs. Raises SessionError."""
    folder = clones / package.key
    options = ("--hri-suite=closure", f"--hri-close-runs={package.close_runs}", "--hri-diagnose=0")
    done = session.run(folder / f"{REPORT}-closure", [*OPTIONS, *options], folder)
    row["cpu_s"] += round(done.cpu_s)
    row["suites"][ALONE] = _summary(done.report["suites"][0], done.report)


def _searches(package: Package) -> Iterator[str]:
    yield f"--hri-diagnose={package.cause_runs}"
    if package.close_runs:
        yield from ("--hri-close", f"--hri-close-runs={package.close_runs}")
    if package.schedules:
        yield f"--hri-schedules={package.schedules}"


def _summary(suite: dict[str, Any], report: dict[str, Any]) -> dict[str, Any]:
    outcomes = [test["outcome"] for test in report["tests"] if test["suite"] == suite["name"]]
    return {
        "tests": len(outcomes),
        "failed": sum(outcome != "passed" for outcome in outcomes),
        "statements": suite["code"]["statements"],
        "branches": suite["code"]["branches"],
        "requirements": {
            name: {key: counts[key] for key in ("passed", "failed", "nc")}
            for name, counts in suite["requirements"].items()
        },
    }


def _violations(report: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """One for each cause; then one for each race that counts."""
    tests = {test["id"]: test for test in report["tests"]}
    for cause in report.get("causes", ()):
        failing = tests.get(cause["tests"][0], {})
        yield {
            "requirements": cause["requirements"],
            "tests": len(cause["tests"]),
            "minimal": cause.get("minimal") or failing.get("abstract", []),
            "seen": (failing.get("failure") or "").partition("\n")[0],
            "decides": cause.get("deciding_change", ""),
            "at": [f"{each['file']}:{each['line']}" for each in cause.get("locations", [])[:2]]
            or cause.get("stood", []),
            "replay": f"pytest --hri-replay={cause['replay']}" if cause.get("replay") else "",
        }
    for race in (report.get("schedules") or {}).get("races", ()):
        yield {"requirements": ["race"], "tests": 1, "seen": race["words"], "counts": race["is_counted"],
               "of": race["requirement"]}  # fmt: skip
