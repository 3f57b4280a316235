"""What the page tells of a requirement, and of each cross product, over all suites."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

SHOWN = 25
"""So many failures, tight passes and nearest misses are listed; the table of tests has the others."""

Pair = tuple[Mapping[str, Any], Mapping[str, Any]]


@dataclass(frozen=True)
class Judged:
    """A requirement; `failures`, `tight` and `misses` hold (test, verdict), the worst first, at most `SHOWN` of each.

    Attributes:
        texts: its title, source and formula, as far as the report has them.
        known: why its violation is known; empty where it is not.
        until: the last day on which it is; empty where that is not limited.
        counts: verdict -> number of tests.
        triggers: over all tests.
        tight: tests that passed with the least margins.
        misses: tests that did not trigger it, by how near they came.
        searched: what a search for a violation came to; None where none was made.
        unit: of its margin; empty where that is not known.
    """

    name: str
    texts: Mapping[str, str]
    known: str
    until: str
    counts: Mapping[str, int]
    triggers: int
    failures: tuple[Pair, ...]
    tight: tuple[Pair, ...]
    misses: tuple[Pair, ...]
    searched: Mapping[str, Any] | None
    unit: str


def requirement(report: Mapping[str, Any], name: str) -> Judged:
    """One requirement, over all tests of the report."""
    pairs = [(test, test["requirements"][name]) for test in report["tests"] if name in test["requirements"]]
    by_verdict = {word: [pair for pair in pairs if pair[1]["verdict"] == word] for word in ("Passed", "Failed", "NC")}
    tight = [pair for pair in by_verdict["Passed"] if pair[1]["margin"] is not None]
    misses = [pair for pair in by_verdict["NC"] if pair[1].get("nearest_miss")]
    return Judged(
        name=name,
        texts=report.get("requirements", {}).get(name, {}),
        known="" if report.get("strict") else report.get("known_violations", {}).get(name, ""),
        until=report.get("known_until", {}).get(name, ""),
        counts={word: len(found) for word, found in by_verdict.items()},
        triggers=sum(verdict["triggers"] for _, verdict in pairs),
        failures=tuple(sorted(by_verdict["Failed"], key=_margin)[:SHOWN]),
        tight=tuple(sorted(tight, key=_margin)[:SHOWN]),
        misses=tuple(sorted(misses, key=_nearness)[:SHOWN]),
        searched=report.get("search", {}).get(name),
        unit=margin_unit(report, name),
    )


def margin_unit(report: Mapping[str, Any], name: str) -> str:
    """The unit of a requirement's margins: seconds for a deadline, else that of the signals it compares."""
    response = report.get("requirements", {}).get(name, {}).get("text", "").partition("->")[2]
    if "eventually" in response:
        return "s"
    units: Mapping[str, str] = report.get("units", {})
    named = {units[word] for word in re.findall(r"[A-Za-z_]\w*", response) if word in units}
    return named.pop() if len(named) == 1 else ""


def cross(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The cross products, each with what the heat map needs.

    Returns:
        `name`, `coordinates` ([name, bins] each), `closed` (["impossible" or "illegal", reason, bit set of bins as a
        hexadecimal number] each), `suites` (suite -> [bin, tests that hit it] each), `tests` (the bins that each
        test of the report hit), `proof`. Bins are numbered, the last coordinate's fastest.
    """
    found = []
    for name, declared in sorted(report.get("cross_products", {}).items()):
        coordinates = [(each["name"], each["bins"]) for each in declared["coordinates"]]
        places = [{each: number for number, each in enumerate(bins)} for _, bins in coordinates]
        hits = [sorted({_number(each, places) for each in _hits(test, name)}) for test in report["tests"]]
        closed: dict[tuple[str, str], int] = {}
        for kind in ("impossible", "illegal"):
            for each in declared[kind]:
                key = kind, each["reason"]
                closed[key] = closed.get(key, 0) | 1 << _number(each["bin"], places)
        suites = {
            suite["name"]: [
                [_number(hit["bin"], places), hit["tests"]]
                for hit in suite["cross"].get("products", {}).get(name, {}).get("hits", ())
            ]
            for suite in report["suites"]
        }
        bins = [(kind, reason, f"{bits:x}") for (kind, reason), bits in closed.items()]
        proof = declared.get("proof", {}).get("reason", "")
        found.append(
            {"name": name, "coordinates": coordinates, "closed": bins, "suites": suites, "tests": hits, "proof": proof}
        )
    return found


def _hits(test: Mapping[str, Any], name: str) -> list[list[str]]:
    hits: list[list[str]] = (test.get("cross") or {}).get(name, [])
    return hits


def _number(combination: list[str], places: list[dict[str, int]]) -> int:
    number = 0
    for each, numbers in zip(combination, places, strict=True):
        number = number * len(numbers) + numbers[each]
    return number


def _margin(pair: Pair) -> tuple[bool, float, str]:
    test, verdict = pair
    return verdict["margin"] is None, verdict["margin"] or 0.0, test["id"]


def _nearness(pair: Pair) -> tuple[int, bool, float, str]:
    test, verdict = pair
    miss = verdict["nearest_miss"]
    return len(miss["missing"]), miss["distance"] is None, miss["distance"] or 0.0, test["id"]
