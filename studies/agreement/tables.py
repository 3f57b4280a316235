"""Tables and chart of docs/studies/agreement.md."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import TYPE_CHECKING, Any

from pytest_hricdv.results.proportion import share
from studies.agreement.pair import LATE_S, SAME, UNEXPLAINED, Pair
from studies.estimates import spearman
from studies.original.published import METHODS
from studies.original.requests import first_request_s
from studies.original.runs import REQUIREMENTS, method_of
from studies.page import interval, table
from studies.plots import STYLES, figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Group = tuple[str, Sequence[Pair]]


def context(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Tables and figures by name."""
    groups: list[Group] = [
        (published.title, [pair for pair in pairs if method_of(pair.original.suite) == name])
        for name, published in METHODS.items()
    ]
    heard = [(first_request_s(pair.original.lines), pair.original.legs) for pair in groups[-1][1]]
    return {
        "count": len(pairs),
        "agreement": agreement([*groups, ("all", pairs)]),
        "causes": causes(pairs),
        "poses": poses(pairs),
        "closings": closings([*groups, ("all", pairs)]),
        "unexplained": sum(UNEXPLAINED in _reasons(pair) for pair in pairs),
        "repeats": repeats(pairs),
        "gains": gains(pairs),
        "errors": errors(pairs),
        "late_s": LATE_S,
        "heard_s": max((s for s, legs in heard if s is not None and s < LATE_S and legs), default=0.0),
        "late": sum(s is not None and s >= LATE_S for s, _ in heard),
        "late_heard": sum(s is not None and s >= LATE_S and bool(legs) for s, legs in heard),
        "early": sum(s is not None and s < LATE_S for s, _ in heard),
        "early_heard": sum(s is not None and s < LATE_S and bool(legs) for s, legs in heard),
    }


def repeats(pairs: Sequence[Pair]) -> dict[str, Any]:
    """How coverage differs between tests with the same commands: an upper bound for any agreement in order."""
    equal: dict[tuple[str, ...], list[Pair]] = {}
    for pair in pairs:
        equal.setdefault(pair.original.lines, []).append(pair)
    several = [group for group in equal.values() if len(group) > 1]
    original = [[pair.original.coverage for pair in group] for group in several]
    ours = [[pair.ours.coverage for pair in group] for group in several]
    return {"texts": len(several), "original": _repeated(original), "ours": _repeated(ours)}


def gains(pairs: Sequence[Pair]) -> dict[str, dict[str, float | None]]:
    """Percentage points of coverage that a release, or a person who does not answer, adds to tests that discard.

    Tests of BDI RL only: their records fit the tests, and all were measured in the same way.
    """
    mine = [pair for pair in pairs if pair.original.suite == "rl" and not pair.record_fault]
    then = [(set(pair.original.legs or ()), pair.original.coverage) for pair in mine]
    now = [(set(pair.ours.legs), pair.ours.coverage) for pair in mine]
    return {"original": _gains(then), "ours": _gains(now)}


def _gains(tests: Sequence[tuple[set[str], float]]) -> dict[str, float | None]:
    def average(legs: set[str]) -> float | None:
        values = [coverage for ended, coverage in tests if ended == legs]
        return fmean(values) if values else None

    plain = average({"discarded"})
    points = {}
    for event, leg in (("release", "released"), ("timeout", "no-human-ready")):
        more = average({"discarded", leg})
        points[event] = None if plain is None or more is None else more - plain
    return points


def _repeated(values: Sequence[Sequence[float]]) -> dict[str, float | None]:
    return {
        "order": spearman([group[0] for group in values], [group[1] for group in values]),
        "widest": max((max(group) - min(group) for group in values), default=0.0),
    }


def _reasons(pair: Pair) -> list[str]:
    return [*pair.turn_causes(), *(pair.verdict_cause(name) for name in REQUIREMENTS)]


def errors(pairs: Sequence[Pair]) -> str:
    """How often a sensor here read something other than the person's pose, in tests that wait after each request."""
    rows = []
    for place, (name, error) in enumerate((("gaze", "10"), ("pressure", "01"), ("location", "10"))):
        seen: Counter[str] = Counter()
        for pair in pairs:
            if pair.waits_for_each:
                for turn, reading in zip(pair.requests, pair.ours.readings, strict=False):
                    if turn.answered and reading != "none":
                        seen[turn.pose[place] + reading[place]] += 1
        was = "not ready" if error[0] == "0" else "ready"
        trials = seen[error] + seen[error[0] * 2]
        other = seen[error[::-1]]
        rows.append([name, was, f"{seen[error]} of {trials}", f"{interval(share(seen[error], trials))} %", other])
    return table(["sensor", "the person is", "read otherwise", "share (95 % interval)", "errors the other way"], rows)


def agreement(groups: Iterable[Group]) -> str:
    """By method: agreement on turns, verdicts and the order of coverage."""
    rows = []
    for title, pairs in groups:
        turns = [why for pair in pairs for why in pair.turn_causes()]
        in_order = [why for pair in pairs if not pair.record_fault for why in pair.turn_causes()]
        order = spearman([pair.original.coverage for pair in pairs], [pair.ours.coverage for pair in pairs])
        verdicts = [_agreed(pair.verdict_cause(name) for pair in pairs) for name in REQUIREMENTS]
        rows.append(
            [title, len(pairs), _agreed(turns), _agreed(in_order), *verdicts, "-" if order is None else f"{order:.2f}"]
        )
    head = ["", "tests", "turns", "turns where the record is the test's", *REQUIREMENTS, "order of coverage"]
    return table(head, rows)


def _agreed(reasons: Iterable[str]) -> str:
    all_of = list(reasons)
    same = all_of.count(SAME)
    return f"{100 * same / len(all_of):.0f} % ({same} of {len(all_of)})" if all_of else "not given"


def causes(pairs: Sequence[Pair]) -> str:
    """Number of disagreements by cause."""
    counts = {
        "turns": Counter(why for pair in pairs for why in pair.turn_causes()),
        **{name: Counter(pair.verdict_cause(name) for pair in pairs) for name in REQUIREMENTS},
    }
    total: Counter[str] = sum(counts.values(), Counter())
    ordered = sorted((why for why in total if why != SAME), key=lambda why: (-total[why], why))
    rows = [[why, *(count[why] or "" for count in counts.values())] for why in ordered]
    sums = [sum(count.values()) - count[SAME] for count in counts.values()]
    return table(["cause", *counts], [*rows, ["all", *sums]])


def poses(pairs: Sequence[Pair]) -> str:
    """How often a leg was released, by the person's pose, where the record fits the test."""
    kinds = {"gaze, pressure and location ready": True, "not all of them ready": False}
    rows = []
    for pose, all_ready in kinds.items():
        then: list[bool] = []
        now: list[bool] = []
        for pair in pairs:
            if pair.original.legs is None or pair.record_fault:
                continue
            for turn, their, our in zip(pair.requests, pair.original.legs, pair.ours.legs, strict=False):
                if turn.answered and turn.all_ready == all_ready and {their, our} <= {"released", "discarded"}:
                    then.append(their == "released")
                    now.append(our == "released")
        rows.append([pose, len(then), *(f"{interval(share(sum(x), len(x)))} %" for x in (then, now))])
    return table(["the person's", "turns", "released in the original", "released here"], rows)


def closings(groups: Iterable[Group]) -> str:
    """Share of tests that failed R3, of those that checked it."""
    rows = []
    for title, pairs in groups:
        row: list[object] = [title]
        for verdicts in ([p.original.verdicts for p in pairs], [p.ours.verdicts for p in pairs]):
            checked = [judged["R3"] for judged in verdicts if judged["R3"] != "NC"]
            failed = checked.count("Failed")
            row += [f"{failed} of {len(checked)}", f"{interval(share(failed, len(checked)))} %"]
        rows.append(row)
    return table(["", "original", "share (95 % interval)", "here", "share (95 % interval)"], rows)


def coverage_chart(pairs: Sequence[Pair]) -> Figure:
    """Scatter plot of coverage, original against here; the area of a marker is the number of tests."""
    made, (axes,) = figure()
    for (name, published), (colour, _, marker) in zip(METHODS.items(), STYLES, strict=False):
        mine = [pair for pair in pairs if method_of(pair.original.suite) == name]
        points = Counter((pair.original.coverage, pair.ours.coverage) for pair in mine)
        axes.scatter(
            [then for then, _ in points],
            [now for _, now in points],
            s=[18.0 * count for count in points.values()],
            marker=marker,
            facecolors="none",
            edgecolors=colour,
            linewidths=1.2,
            label=f"{published.title} ({len(mine)})",
        )
    axes.set_xlabel("statements covered in the original (% of 264)")
    axes.set_ylabel("statements covered here (%)")
    legend = axes.legend(loc="lower right", title="area: number of tests")
    for handle in legend.legend_handles:
        handle.set_sizes([30.0])  # type: ignore[union-attr]
    return made
