"""Merging reports: of shards of a suite, of other suites, of repeated runs.

The merge is a union, and all that follows from the tests is worked out anew by `closing.close`. So it is commutative,
associative and idempotent: the same reports give the same bytes, in whatever order and however often they are given.

A test that several reports have counts once. Where they disagree (the same node id and seed, another run), the worst
run stands for the test, and the others are kept in its `repeats`; what any of them covered is covered.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pytest_hricdv.closure.closing import Entry, close
from pytest_hricdv.cover.source import CoverError
from pytest_hricdv.report.contract import faults
from pytest_hricdv.results.codec import canonical

_OF_SUITE = ("name", "seed", "size", "generation", "plans")
_NEEDED: dict[str, Any] = {
    "required": [
        "version",
        "testbench",
        "wall_s",
        "workers",
        "requirements",
        "code_under_test",
        "models",
        "cross_products",
    ],
    "properties": {
        "code_under_test": {"required": ["sha256", "packages", "waivers", "map"]},
        "suites": {"items": {"required": [*_OF_SUITE]}},
        "tests": {"items": {"required": ["plans", "fidelity"]}},
    },
}
"""What a merge needs beyond what every report has."""
_EQUAL = ("version", "testbench", "requirements", "known_violations", "known_until", "strict", "state")
_WORST_FIRST = ("failed", "error", "known-violation", "passed", "not-run")
_ASIDE = ("wall_s", "code", "film", "failure", "replay", "replayed", "shrunk", "unmeasured", "repeats")
"""What may differ between two reports of one run, and is settled key by key."""


class MergeError(Exception):
    """Reports that do not belong together; the text says which, in what they differ, and what to do."""


def merge(reports: Sequence[tuple[str, Entry]]) -> Entry:
    """One report of several.

    Args:
        reports: each with what to call it in errors; every one keeps the contract of report.json.

    Raises:
        MergeError: there is none, or they are of different code, testbenches, requirements, models or suites.
    """
    if not reports:
        raise MergeError("nothing to merge: expected at least one report")
    for name, report in reports:
        lacking = faults(report, _NEEDED)
        if lacking:
            raise MergeError(f"{name}: {lacking[0]}: another version of the plugin wrote it; run the suite anew")
    first_name, first = reports[0]
    for name, report in reports[1:]:
        _refuse_others(first_name, first, name, report)
    plain = [report for _, report in reports]
    sessions = _united(plain)
    code = {key: first["code_under_test"][key] for key in ("packages", "sha256", "waivers", "map")}
    merged = {key: first[key] for key in ("schema", "cross_products", *_EQUAL) if key in first} | {
        "code_under_test": code,
        "wall_s": round(math.fsum(each["wall_s"] for each in sessions), 3),
        "workers": max(each["workers"] for each in sessions),
        "rerun": _rerun(plain),
        "sessions": sessions,
        "exploration": max((report.get("exploration", {}) for report in plain), key=canonical),
        "models": max((report["models"] for report in plain), key=canonical),
        "suites": _suites(reports),
        "tests": _tests(plain),
    }
    searched = _searched(plain)
    reasons = sorted({report["code_under_test"].get("reason", "") for report in plain} - {""})
    try:
        return close(merged | ({"search": searched} if searched else {}), reasons[0] if reasons else "")
    except CoverError as error:
        raise MergeError(f"the merged report is wrong: {error}") from None


def expected(report: Mapping[str, Any]) -> int:
    """How many tests a merged report should have: of shards all tests of their suites, else those that it lists."""
    if any(each["shard"] for each in report.get("sessions", ())):
        return max(int(report["selected"]), sum(int(suite["size"]) for suite in report["suites"]))
    return int(report["selected"])


def missing_shards(report: Mapping[str, Any]) -> tuple[str, ...]:
    """The shards that no session was of, as `2/3`; of sessions with different numbers of shards, of the most."""
    shards = [tuple(map(int, each["shard"].split("/"))) for each in report.get("sessions", ()) if each["shard"]]
    if not shards or any(not each["shard"] for each in report["sessions"]):
        return ()
    of = max(shard[1] for shard in shards)
    have = {shard[0] for shard in shards if shard[1] == of}
    return tuple(f"{index}/{of}" for index in range(1, of + 1) if index not in have)


def _refuse_others(first_name: str, first: Entry, name: str, report: Entry) -> None:
    for key in _EQUAL:
        if first.get(key) != report.get(key):
            raise MergeError(
                f"{first_name} and {name}: different {key.replace('_', ' ')}: {_unlike(first, report, key)}"
            )
    if first["code_under_test"]["sha256"] != report["code_under_test"]["sha256"]:
        raise MergeError(
            f"{first_name} and {name}: different code under test: {_changed(first, report)}; run both anew"
        )
    if first["cross_products"] != report["cross_products"]:
        raise MergeError(f"{first_name} and {name}: the testbench declared different cross products; run both anew")
    if first["models"] and report["models"] and first["models"] != report["models"]:
        raise MergeError(f"{first_name} and {name}: different BDI models; run both anew")


def _unlike(first: Entry, report: Entry, key: str) -> str:
    one, other = first.get(key), report.get(key)
    if isinstance(one, dict) and isinstance(other, dict):
        names = sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))
        return ", ".join(names)
    return f"{one!r} and {other!r}"


def _changed(first: Entry, report: Entry) -> str:
    one, other = ({file["file"]: file for file in each["code_under_test"].get("map", ())} for each in (first, report))
    names = sorted(name for name in one.keys() | other.keys() if one.get(name) != other.get(name))
    return ", ".join(names) or "one of them does not say which"


def sessions_of(report: Entry) -> list[Entry]:
    """The runs that a report is of: itself, or, of a merged one, those that it was merged from."""
    return report.get("sessions") or [_session(report)]


def _united(reports: Iterable[Entry]) -> list[Entry]:
    found = {each["sha256"]: each for report in reports for each in sessions_of(report)}
    return [found[key] for key in sorted(found)]


def _session(report: Entry) -> Entry:
    """What a merged report keeps of a run. Two reports with the same content are one session."""
    keys = ("wall_s", "workers", "selected", "reported")
    digest = hashlib.sha256(canonical(report).encode("ascii")).hexdigest()
    return {"sha256": digest, **{key: report[key] for key in keys}, "shard": report.get("shard", "")}


def _rerun(reports: Iterable[Entry]) -> Entry:
    given = [report.get("rerun", {}) for report in reports]
    suites = {name for each in given for name in each.get("suite", "").split(",")} - {""}
    return {
        "suite": ",".join(sorted(suites)),
        "options": sorted({o for each in given for o in each.get("options", ())}),
    }


def _suites(reports: Sequence[tuple[str, Entry]]) -> list[Entry]:
    found: dict[str, tuple[str, Entry]] = {}
    for where, report in reports:
        for suite in report["suites"]:
            raw = {key: suite[key] for key in _OF_SUITE}
            raw["plans"] = {agent: {"declared": plans["declared"]} for agent, plans in suite["plans"].items()}
            before = found.get(suite["name"])
            found[suite["name"]] = (where, raw if before is None else _same_suite(before, (where, raw)))
    return [found[name][1] for name in sorted(found)]


def _same_suite(before: tuple[str, Entry], after: tuple[str, Entry]) -> Entry:
    (where, one), (there, other) = before, after
    timeless = [each | {"generation": _timeless(each["generation"])} for each in (one, other)]
    if timeless[0] != timeless[1]:
        what = "another seed" if one["seed"] != other["seed"] else "other tests or options"
        raise MergeError(
            f"{where} and {there}: two suites have the name {one['name']!r} but {what}; merge runs of one and "
            "the same suite, or rename one"
        )
    return min(one, other, key=lambda each: (-each["generation"]["wall_s"], canonical(each)))


def _timeless(generation: Entry) -> Entry:
    return {key: value for key, value in generation.items() if key not in ("wall_s", "cached")}


def _tests(reports: Iterable[Entry]) -> list[Entry]:
    runs: dict[str, dict[str, Entry]] = {}
    for report in reports:
        for test in report["tests"]:
            for run in [test, *test.get("repeats", ())]:
                mine = runs.setdefault(run["nodeid"], {})
                key = _content(run)
                mine[key] = _settled(mine[key], run) if key in mine else _alone(run)
    return [_stood_for(list(mine.values())) for mine in runs.values()]


def _alone(run: Entry) -> Entry:
    return {key: value for key, value in run.items() if key != "repeats"}


def _content(run: Entry) -> str:
    """Equal of two runs exactly where everything is that a run gives by itself: verdicts, record, what it covered."""
    return canonical({key: value for key, value in run.items() if key not in _ASIDE})


def _settled(one: Entry, other: Entry) -> Entry:
    """One run, reported twice: the shorter time, what either measured, and of texts and files the first by name."""
    aside = {}
    for key in _ASIDE:
        said = [run[key] for run in (one, other) if key in run]
        if said and key not in ("wall_s", "code", "repeats"):
            aside[key] = min(filter(None, said), key=canonical_value, default=said[0])
    times = [run["wall_s"] for run in (one, other) if run["wall_s"] is not None]
    return _alone(one) | aside | {"wall_s": min(times, default=None), "code": _code(one["code"], other["code"])}


def canonical_value(value: object) -> str:
    """Any value of a report as text that depends on its content only."""
    return canonical({"value": value})


def _code(one: Entry | None, other: Entry | None) -> Entry | None:
    """What the run covered, by whoever measured most of it."""
    measured = [each for each in (one, other) if each is not None]
    return max(
        measured, key=lambda each: (each["bits"][1] is not None, each["statements"], canonical(each)), default=None
    )


def _stood_for(runs: list[Entry]) -> Entry:
    """The worst run, with the others; one that was not run stands for a test only where no other is there."""
    done = [run for run in runs if run["outcome"] != "not-run"] or runs[:]
    done.sort(key=lambda run: (_WORST_FIRST.index(run["outcome"]), canonical_value(run)))
    if done[0]["outcome"] == "not-run":
        done = done[:1]
    return done[0] | {"repeats": done[1:]} if len(done) > 1 else done[0]


def _searched(reports: Iterable[Entry]) -> Entry:
    """Of each requirement the search that came nearest to violating it."""
    found: dict[str, list[Entry]] = {}
    for report in reports:
        for name, searched in report.get("search", {}).items():
            found.setdefault(name, []).append(searched)
    return {name: min(searches, key=_nearness) for name, searches in found.items()}


def _nearness(searched: Mapping[str, Any]) -> tuple[float, str]:
    margin = searched["margin"]
    return (math.inf if margin is None else margin, canonical(searched))
