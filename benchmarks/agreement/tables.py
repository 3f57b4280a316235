"""What the page on agreement is filled with."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from statistics import fmean
from typing import Any

from benchmarks.agreement import original
from benchmarks.agreement.asked import before_first_request_s
from benchmarks.agreement.pair import HAND, LATE_S, SAME, UNEXPLAINED, Pair
from benchmarks.estimates import share, spearman
from benchmarks.experiment.published import METHODS
from benchmarks.page import interval, table

REQUIREMENTS = original.REQUIREMENTS
Group = tuple[str, Sequence[Pair]]


def context(pairs: Sequence[Pair]) -> dict[str, Any]:
    """Tables and figures by name."""
    groups: list[Group] = [
        (published.title, [each for each in pairs if original.method(each.theirs.suite) == name])
        for name, published in METHODS.items()
    ]
    heard = [(before_first_request_s(each.theirs.lines), each.theirs.legs) for each in groups[-1][1]]
    return {
        "count": len(pairs),
        "agreement": agreement([*groups, ("all", pairs)]),
        "causes": causes(pairs),
        "poses": poses(pairs),
        "closings": closings([*groups, ("all", pairs)]),
        "disagreements": disagreements(pairs),
        "unexplained": sum(UNEXPLAINED in _reasons(each) for each in pairs),
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
    """How coverage differs between tests of the very same commands: what no order can be better than."""
    equal: dict[tuple[str, ...], list[Pair]] = {}
    for each in pairs:
        equal.setdefault(each.theirs.lines, []).append(each)
    several = [group for group in equal.values() if len(group) > 1]
    theirs = [[each.theirs.coverage for each in group] for group in several]
    ours = [[each.ours.coverage for each in group] for group in several]
    return {"texts": len(several), "theirs": _repeated(theirs), "ours": _repeated(ours)}


def gains(pairs: Sequence[Pair]) -> dict[str, dict[str, float | None]]:
    """How many points of coverage a release adds to tests that discard, and how many a person who does not answer.

    In tests of BDI RL only, whose records are the tests' and which were all measured alike.
    """
    mine = [each for each in pairs if each.theirs.suite == "rl" and not each.awry]
    then = [(set(each.theirs.legs or ()), each.theirs.coverage) for each in mine]
    now = [(set(each.ours.legs), each.ours.coverage) for each in mine]
    return {"theirs": _gains(then), "ours": _gains(now)}


def _gains(tests: Sequence[tuple[set[str], float]]) -> dict[str, float | None]:
    def average(legs: set[str]) -> float | None:
        values = [coverage for found, coverage in tests if found == legs]
        return fmean(values) if values else None

    plain = average({"discarded"})
    found = {}
    for what, leg in (("release", "released"), ("timeout", "no-human-ready")):
        more = average({"discarded", leg})
        found[what] = None if plain is None or more is None else more - plain
    return found


def _repeated(values: Sequence[Sequence[float]]) -> dict[str, float | None]:
    return {
        "order": spearman([each[0] for each in values], [each[1] for each in values]),
        "widest": max((max(each) - min(each) for each in values), default=0.0),
    }


def _reasons(pair: Pair) -> list[str]:
    return [*pair.legs(), *(pair.verdict(name) for name in REQUIREMENTS)]


def errors(pairs: Sequence[Pair]) -> str:
    """How often a sensor here read something else than what the person did, where each request is waited for."""
    rows = []
    for place, (name, error) in enumerate((("gaze", "10"), ("pressure", "01"), ("location", "10"))):
        seen: Counter[str] = Counter()
        for each in pairs:
            if each.waits_for_each:
                for turn, reading in zip(each.requests, each.ours.readings, strict=False):
                    if turn.answers and reading != "none":
                        seen[turn.pose[place] + reading[place]] += 1
        was = "not ready" if error[0] == "0" else "ready"
        trials = seen[error] + seen[error[0] * 2]
        other = seen[error[::-1]]
        rows.append([name, was, f"{seen[error]} of {trials}", f"{interval(share(seen[error], trials))} %", other])
    return table(["sensor", "the person is", "read otherwise", "share (95 % interval)", "errors the other way"], rows)


def agreement(groups: Iterable[Group]) -> str:
    """Per method: agreement on turns, on verdicts, and on the order of coverage."""
    rows = []
    for title, pairs in groups:
        turns = [why for each in pairs for why in each.legs()]
        sound = [why for each in pairs if not each.awry for why in each.legs()]
        order = spearman([each.theirs.coverage for each in pairs], [each.ours.coverage for each in pairs])
        verdicts = [_agreed(each.verdict(name) for each in pairs) for name in REQUIREMENTS]
        rows.append(
            [title, len(pairs), _agreed(turns), _agreed(sound), *verdicts, "-" if order is None else f"{order:.2f}"]
        )
    head = ["", "tests", "turns", "turns where the record is the test's", *REQUIREMENTS, "order of coverage"]
    return table(head, rows)


def _agreed(reasons: Iterable[str]) -> str:
    all_of = list(reasons)
    same = all_of.count(SAME)
    return f"{100 * same / len(all_of):.0f} % ({same} of {len(all_of)})" if all_of else "not given"


def causes(pairs: Sequence[Pair]) -> str:
    """How many disagreements have which cause."""
    counts = {
        "turns": Counter(why for each in pairs for why in each.legs()),
        **{name: Counter(each.verdict(name) for each in pairs) for name in REQUIREMENTS},
    }
    total: Counter[str] = sum(counts.values(), Counter())
    found = sorted((why for why in total if why != SAME), key=lambda why: (-total[why], why))
    rows = [[why, *(count[why] or "" for count in counts.values())] for why in found]
    sums = [sum(count.values()) - count[SAME] for count in counts.values()]
    return table(["cause", *counts], [*rows, ["all", *sums]])


def poses(pairs: Sequence[Pair]) -> str:
    """How often a leg was released, by what the person did, where the record is the test's."""
    kinds = {"gaze, pressure and location ready": True, "not all of them ready": False}
    rows = []
    for what, good in kinds.items():
        then: list[bool] = []
        now: list[bool] = []
        for each in pairs:
            if each.theirs.legs is None or each.awry:
                continue
            for turn, their, our in zip(each.requests, each.theirs.legs, each.ours.legs, strict=False):
                if turn.answers and turn.good == good and {their, our} <= {"released", "discarded"}:
                    then.append(their == "released")
                    now.append(our == "released")
        rows.append([what, len(then), *(f"{interval(share(sum(x), len(x)))} %" for x in (then, now))])
    return table(["the person's", "turns", "released in the original", "released here"], rows)


def closings(groups: Iterable[Group]) -> str:
    """How many tests failed R3, of those that checked it."""
    rows = []
    for title, pairs in groups:
        row: list[object] = [title]
        for verdicts in ([p.theirs.verdicts for p in pairs], [p.ours.verdicts for p in pairs]):
            checked = [each["R3"] for each in verdicts if each["R3"] != "NC"]
            failed = checked.count("Failed")
            row += [f"{failed} of {len(checked)}", f"{interval(share(failed, len(checked)))} %"]
        rows.append(row)
    return table(["", "original", "share (95 % interval)", "here", "share (95 % interval)"], rows)


def disagreements(pairs: Sequence[Pair]) -> str:
    """Every test on which the two disagree in more than where the hand happened to be."""
    rows = []
    for each in pairs:
        reasons = [why for why in dict.fromkeys(_reasons(each)) if why not in (SAME, HAND)]
        if not reasons:
            continue
        then = [f"{_short(each.theirs.verdicts)}: {', '.join(_legs(each.theirs.legs))}"]
        now = [f"{_short(each.ours.verdicts)}: {', '.join(_legs(each.ours.legs))}"]
        rows.append([each.theirs.name, *then, *now, "; ".join(reasons)])
    return table(["test", "original (R1 R2 R3: turns)", "here", "cause"], rows)


def _short(verdicts: Any) -> str:
    return " ".join({"Passed": "P", "Failed": "F", "NC": "-"}[verdicts[name]] for name in REQUIREMENTS)


def _legs(legs: tuple[str, ...] | None) -> list[str]:
    return ["not recorded"] if legs is None else list(legs) or ["none"]
