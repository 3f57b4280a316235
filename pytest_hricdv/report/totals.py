"""What the views add up from a report, in one place so that terminal and page cannot disagree."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.report.figure import branches, natural, plural, ranges, share

OUTCOMES = ("passed", "failed", "known-violation", "error", "not-run")


@dataclass(frozen=True)
class Tally:
    """One requirement over one suite: tests by verdict, triggers over all tests, and the least margin.

    `known` is the reason why its violation is known, empty where it is not or where the run is strict.
    `margin` is the least over the suite's tests, in the requirement's own unit; `margin_test` had it.
    """

    name: str
    title: str
    passed: int
    failed: int
    nc: int
    triggers: int
    known: str
    margin: float | None
    margin_test: str


@dataclass(frozen=True)
class Gap:
    """What no test covered of one thing (a source file, an agent's plans, a cross product)."""

    place: str
    kind: str
    items: tuple[str, ...]


@dataclass(frozen=True)
class Time:
    """Seconds of wall clock of the session, and simulated seconds over all its tests."""

    wall_s: float
    simulated_s: float
    workers: int

    @property
    def speed(self) -> float | None:
        """How many times real time; None where no time was taken."""
        return self.simulated_s / self.wall_s if self.wall_s > 0 else None


def outcomes(report: Mapping[str, Any]) -> dict[str, int]:
    """Tests by outcome, every outcome named.

    A test without a result is a `not-run` one whether or not the report lists it as a test.
    """
    counts = Counter(test["outcome"] for test in report["tests"])
    counts["not-run"] = max(counts["not-run"], report["not_run"])
    return {name: counts[name] for name in OUTCOMES}


def loss(report: Mapping[str, Any]) -> str:
    """What became of the tests that have no result; empty when every selected test reported."""
    missing = report["selected"] - report["reported"]
    if missing < 0:
        return f"{plural(-missing, 'result')} more than tests: counted twice?"
    missing = max(missing, report["not_run"])
    return f"{plural(missing, 'test')} not run or lost, totals are lower bounds" if missing else ""


def tallies(report: Mapping[str, Any], suite: Mapping[str, Any]) -> tuple[Tally, ...]:
    """A suite's requirements, R2 before R10."""
    titles = report.get("requirements", {})
    reasons = {} if report.get("strict") else report.get("known_violations", {})
    rows = []
    for name in sorted(suite["requirements"], key=natural):
        counts = suite["requirements"][name]
        margin, test = _least_margin(report, suite["name"], name)
        rows.append(
            Tally(
                name=name,
                title=titles.get(name, {}).get("title", ""),
                known=(reasons[name] or "known") if name in reasons else "",
                margin=margin,
                margin_test=test,
                **{key: counts[key] for key in ("passed", "failed", "nc", "triggers")},
            )
        )
    return tuple(rows)


def gaps(report: Mapping[str, Any]) -> tuple[Gap, ...]:
    """Everything not covered: lines and branches of each file, then each suite's plans and cross bins.

    Waived lines, and branches from or to them, are left out: they are no gap to close, and are listed as waivers.
    """
    waived = {(waiver["file"], waiver["line"]) for waiver in waivers(report)}
    found = []
    for file in sorted(report.get("code_under_test", {}).get("files", ()), key=lambda file: str(file["file"])):
        name = file["file"]
        lines = [line for line in file.get("missing_lines", ()) if (name, line) not in waived]
        arcs = [arc for arc in file.get("missing_branches", ()) if not any((name, line) in waived for line in arc)]
        found.append(Gap(name, "lines", ranges(lines)))
        found.append(Gap(name, "branches", branches(arcs)))
    several = len(report["suites"]) > 1
    for suite in report["suites"]:
        where = f" ({suite['name']})" if several else ""
        for agent in sorted(suite["plans"]):
            missing = suite["plans"][agent].get("missing", ())
            found.append(Gap(f"{agent}{where}", "plans", tuple(sorted(missing, key=natural))))
        found.append(Gap(f"cross product{where}", "bins", tuple(suite["cross"].get("missing", ()))))
    return tuple(gap for gap in found if gap.items)


def time(report: Mapping[str, Any]) -> Time:
    """The session's wall clock, and the simulated seconds it was worth."""
    simulated_s = sum(test["sim_s"] or 0.0 for test in report["tests"])
    return Time(report.get("wall_s") or 0.0, simulated_s, report.get("workers") or 1)


def times(speed: float) -> str:
    """`331 times`, `0.52 times`: how many times real time."""
    return f"{speed:.0f} times" if speed >= 10 else f"{speed:.2g} times"


def unmeasured(report: Mapping[str, Any]) -> str:
    """Why the code was not measured, for where a suite has no figures of it."""
    return report.get("code_under_test", {}).get("reason") or "no reason given"


def waivers(report: Mapping[str, Any]) -> tuple[Mapping[str, Any], ...]:
    """Lines of the code under test declared unreachable, by file and line."""
    listed = report.get("code_under_test", {}).get("waivers", ())
    return tuple(sorted(listed, key=lambda waiver: (waiver["file"], waiver["line"])))


def percent_reachable(figures: Mapping[str, Any]) -> float | None:
    """Covered of reachable, per cent: as reported, or worked out."""
    given: float | None = figures.get("percent_reachable")
    return share(figures["covered"], figures["reachable"]) if given is None else given


def plans_covered(suite: Mapping[str, Any]) -> float | None:
    """Of all agents' plans, per cent; None where no model made the suite."""
    plans = suite["plans"].values()
    return share(sum(len(each["covered"]) for each in plans), sum(each["total"] for each in plans))


def bins_covered(cross: Mapping[str, Any]) -> float | None:
    """Of the bins that are neither impossible nor illegal, per cent; None where there is none."""
    return share(cross["hit"], cross["bins"] - cross["impossible"] - cross.get("illegal", 0))


def _least_margin(report: Mapping[str, Any], suite: str, requirement: str) -> tuple[float | None, str]:
    margins = [
        (verdict["margin"], test["id"])
        for test in report["tests"]
        if test["suite"] == suite and (verdict := test["requirements"].get(requirement)) is not None
        if verdict["margin"] is not None
    ]
    return min(margins) if margins else (None, "")
