"""What the page tells of closure: gaps with what may close them, the smallest suite, and what tests add."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.report import totals
from pytest_hricdv.report.curves import Point, thinned
from pytest_hricdv.report.rows import anchor

SHOWN_ITEMS = 40
_WAIVED = "waived as unreachable"


@dataclass(frozen=True)
class Hole:
    """Something that no test covers; `test` is a link's anchor and an id, of the test that came nearest, or None."""

    place: str
    kind: str
    items: tuple[str, ...]
    reason: str = ""
    suggestion: str = ""
    test: tuple[str, str] | None = None


def holes(report: Mapping[str, Any]) -> tuple[Hole, ...]:
    """Every gap: with reasons and suggestions where the report has them; gaps that share these are one.

    What is waived is listed elsewhere.
    """
    listed = report.get("closure", {}).get("gaps")
    if listed is None:
        return tuple(Hole(gap.place, gap.kind, gap.items) for gap in totals.gaps(report))
    anchors = {test["id"]: anchor(test["nodeid"]) for test in report["tests"]}
    grouped: dict[tuple[str, ...], list[str]] = {}
    for gap in listed:
        if not gap["reason"].startswith(_WAIVED):
            key = gap["place"], gap["kind"], gap["reason"], gap["suggestion"], gap["test"]
            grouped.setdefault(key, []).extend(gap["items"])
    return tuple(
        Hole(place, kind, tuple(items), reason, suggestion, (anchors[test], test) if test in anchors else None)
        for (place, kind, reason, suggestion, test), items in grouped.items()
    )


def smallest(report: Mapping[str, Any]) -> dict[str, Any] | None:
    """The smallest suite, for the page's scripts; None where the report does not know it.

    Returns:
        `curve`: (simulated s, points covered), `growth`: the same of all tests as they are listed, `points` and `sim_s`
        of all tests, `gains`: the number of a test in the report -> the points that it adds, of the tests that are
        enough, `unique`: the same of what it alone covers.
    """
    found = report.get("closure")
    if not found:
        return None
    numbers = {test["nodeid"]: number for number, test in enumerate(report["tests"])}
    curve: list[Point] = [(0.0, 0.0)]
    growth: list[Point] = [(0.0, 0.0), *((round(step[0], 2), step[1]) for step in found.get("growth", ()))]
    growth.append((round(found["sim_s"], 2), found["points"]))
    curve += [(round(step["sim_s"], 2), step["points"]) for step in found["minimal"]]
    return {
        "curve": thinned(curve),
        "growth": thinned(growth),
        "points": found["points"],
        "sim_s": found["sim_s"],
        "gains": {numbers[step["nodeid"]]: step["gain"] for step in found["minimal"] if step["nodeid"] in numbers},
        "unique": {numbers[name]: count for name, count in found["unique"].items() if name in numbers},
    }
