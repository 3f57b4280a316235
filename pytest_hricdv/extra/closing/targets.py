"""Targets: the points to hit, of the code, the model, the cross products and the requirements.

`ClosureGenerator` calls `target_points` and `impossible_points` before the loop. For each point left open, `evidence`
finds the run that came closest (`nearest`), what this run lacked (`explain_gap`), and how to declare the point
impossible (`waiver`).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import Bits, CodeMap
from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.coverage.reachability import Reachability
from pytest_hricdv.extra.closing.observation import code_points
from pytest_hricdv.extra.closing.records import ImpossiblePoint
from pytest_hricdv.extra.closing.strategy import Archive, ArchivedRun
from pytest_hricdv.generate.abstract import Plans
from pytest_hricdv.monitor import Criterion, Requirement
from pytest_hricdv.monitor.analysis import conjuncts
from pytest_hricdv.report.explanation import near_miss
from pytest_hricdv.report.formatting import plural


def target_points(
    code: CodeMap | None,
    plans: Plans,
    cross: Mapping[str, CrossProduct],
    reachability: Reachability,
    requirements: Iterable[Criterion],
    transitions: Iterable[tuple[str, str]] = (),
) -> tuple[Point, ...]:
    """All points that are to be hit, without those that are waived, forbidden, or proved impossible by the model.

    Args:
        code: the code under test; None if it is not measured.
        plans: the coverage plans, by agent.
        cross: the cross products.
        reachability: what exploring the model has shown.
        requirements: each is to be checked at least once with the result Passed, and each conjunct of its antecedent
            is to be true and false.
        transitions: the transitions of the state of the code under test.
    """
    return (
        *(_code_points(code) if code is not None else ()),
        *_plan_points(plans, reachability),
        *_requirement_points(tuple(requirements)),
        *(("transition", *transition) for transition in transitions),
        *_cross_points(cross, reachability),
    )


def impossible_points(
    code: CodeMap | None, plans: Plans, cross: Mapping[str, CrossProduct], reachability: Reachability
) -> tuple[ImpossiblePoint, ...]:
    """The points that are waived, declared impossible, or proved impossible by the model. Arguments as above."""
    return (
        *(_waivers(code) if code is not None else ()),
        *_unreachable_plans(plans, reachability),
        *_impossible_bins(cross, reachability),
    )


def by_kind(points: Iterable[Point]) -> Counter[str]:
    """The number of points of each kind."""
    return Counter(point[0] for point in points)


def _code_points(code: CodeMap) -> Iterator[Point]:
    waived = code.waiver_bits()
    statements, branches = (1 << code.statements) - 1, (1 << code.branches) - 1
    return code_points(code, Bits(statements & ~waived.statements, branches & ~(waived.branches or 0)))


def _requirement_points(requirements: Sequence[Criterion]) -> Iterator[Point]:
    yield from (("verdict", requirement.id, "Passed") for requirement in requirements)
    for requirement in requirements:
        if isinstance(requirement, Requirement):
            for conjunct in dict.fromkeys(map(str, conjuncts(requirement.formula.antecedent))):
                yield from (("condition", requirement.id, conjunct, outcome) for outcome in ("true", "false"))


def _plan_points(plans: Plans, reachability: Reachability) -> Iterator[Point]:
    explored = reachability.exploration
    for agent, labels in plans.items():
        for label in labels:
            if explored.status != "proven" or label in (explored.plans or {}).get(agent, {}):
                yield "plan", agent, label


def _waivers(code: CodeMap) -> Iterator[ImpossiblePoint]:
    reasons = {(waiver.file, str(waiver.line)): waiver.reason for waiver in code.waivers}
    for point in code_points(code, code.waiver_bits()):
        lines = [(point[1], line) for line in point[2:] if (point[1], line) in reasons]
        yield ImpossiblePoint(point=point, reason=reasons[lines[0]], by="waived")


def _unreachable_plans(plans: Plans, reachability: Reachability) -> Iterator[ImpossiblePoint]:
    explored = reachability.exploration
    reason = f"none of the model's {explored.runs} runs executes it"
    for agent, labels in plans.items():
        for label in labels:
            if explored.status == "proven" and label not in (explored.plans or {}).get(agent, {}):
                yield ImpossiblePoint(point=("plan", agent, label), reason=reason, by="model")


def _impossible_bins(cross: Mapping[str, CrossProduct], reachability: Reachability) -> Iterator[ImpossiblePoint]:
    for name, product in cross.items():
        for excluded in reachability.products[name].impossible:
            if excluded.bin not in product.forbidden:
                yield ImpossiblePoint(point=("bin", name, *excluded.bin), reason=excluded.reason, by=excluded.by)


def _cross_points(cross: Mapping[str, CrossProduct], reachability: Reachability) -> Iterator[Point]:
    for name, product in cross.items():
        impossible = {excluded.bin for excluded in reachability.products[name].impossible}
        for bin_ in product.bins():
            if bin_ not in impossible and bin_ not in product.forbidden:
                yield ("bin", name, *bin_)


@dataclass(frozen=True)
class Surroundings:
    """The parts of the system under test that explain open points.

    Args:
        code: the code under test; None if it is not measured.
        coordinates: cross product -> the names of its coordinates.
        plans: agent -> plan -> beliefs that, by the model, lead to it.
    """

    code: CodeMap | None = None
    coordinates: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    plans: Mapping[str, Mapping[str, tuple[str, ...]]] = field(default_factory=dict)

    def text(self, file: str, line: str) -> str:
        """The text of a line of the code, as ` (`...`)`; empty if it is not known."""
        for source in self.code.files if self.code is not None else ():
            lines = source.text.splitlines()
            if source.name == file and 0 < int(line) <= len(lines):
                return f" (`{lines[int(line) - 1].strip()}`)"
        return ""


def nearest(point: Point, archive: Archive, preferred: Container[int]) -> ArchivedRun | None:
    """The run that came nearest to a point; None where nothing is known.

    Args:
        preferred: numbers of runs: of equally near ones, the first of these is taken.
    """
    if point[0] == "bin":
        return _nearest_bin(point, archive, preferred)
    near = closest_runs(point, archive)
    same = [entry for distance, entry in near if distance == near[0][0]]
    return next((entry for entry in same if entry.number in preferred), same[0] if same else None)


def closest_runs(point: Point, archive: Archive) -> list[tuple[float, ArchivedRun]]:
    """The runs that came near to an open point, the nearest first, each with its distance.

    The distance is the run's own where it has one. To a branch it is 1 for runs that executed the statement it leads
    away from; to a statement, the number of lines between it and the last statement before it that a run executed.
    From other points no distance is known.
    """
    measured = [
        (distance, entry)
        for entry in archive.entries
        for other, distance in entry.observation.distances
        if other == point
    ]
    return sorted(measured or _by_code(point, archive), key=lambda run: (run[0], run[1].number))


def _by_code(point: Point, archive: Archive) -> Iterator[tuple[float, ArchivedRun]]:
    if point[0] == "branch":
        before: list[Point] = [("statement", point[1], point[2])]
    elif point[0] == "statement":
        lines = [target for target in archive.targets if target[:2] == point[:2]]
        before = [line for line in reversed(lines) if int(line[2]) < int(point[2]) and line in archive.best][:1]
    else:
        return
    for line in before:
        runs = archive.hit_by.get(line, [])
        distance = 1.0 if point[0] == "branch" else float(abs(int(point[2]) - int(line[2])))
        yield from ((distance, archive.entries[number]) for number in runs)


def _nearest_bin(point: Point, archive: Archive, preferred: Container[int]) -> ArchivedRun | None:
    """The run that hit a bin which is nearest to this one; of equally near ones, a run that was aimed at it."""
    candidates = [
        (_distance(point[2:], hit), point not in entry.targets, entry.number not in preferred, entry.number)
        for entry in archive.entries
        for hit in entry.observation.hits.get(point[1], ())
    ]
    return archive.entries[min(candidates)[3]] if candidates else None


def _distance(bin_: Bin, other: Bin) -> tuple[int, tuple[bool, ...]]:
    """The number of coordinates in which bins differ, and which: late ones are closer than planned ones."""
    differing = tuple(a != b for a, b in zip(bin_, other, strict=True))
    return sum(differing), differing


def explain_gap(point: Point, entry: ArchivedRun | None, archive: Archive, surroundings: Surroundings) -> str:
    """The condition that a run lacked to hit a point, or another note on the point; may be empty."""
    match point:
        case ("bin", product, *wanted) if entry is not None:
            hit = min(entry.observation.hits[product], key=lambda seen: _distance(tuple(wanted), seen))
            names = surroundings.coordinates[product]
            parts = zip(names, wanted, hit, strict=True)
            return ", ".join(f"{name} {there} instead of {mine}" for name, mine, there in parts if mine != there)
        case ("verdict", requirement, "Passed") if ("verdict", requirement, "Failed") in archive.hit_by:
            failed = len(archive.hit_by["verdict", requirement, "Failed"])
            return f"no run passed it, {plural(failed, 'run')} failed it"
        case ("verdict", requirement, "Passed") | ("condition", requirement, _, "true") if entry is not None:
            miss = entry.observation.near_misses.get(requirement)
            return near_miss(miss) if miss is not None else ""
        case ("condition", *names, "false") if ("condition", *names, "true") in archive.best:
            return "it was always true: the antecedent may do without it"
        case ("statement", file, line):
            return _before(file, line, archive, surroundings)
        case ("branch", file, begin, end) if entry is not None:
            goes = "the exit" if int(end) < 0 else f"line {end}"
            return f"line {begin}{surroundings.text(file, begin)} has to continue to {goes}"
        case ("transition", state, _):
            seen = ", ".join(sorted(hit[2] for hit in archive.best if hit[:2] == ("transition", state)))
            return f"after {state} came {seen}" if seen else f"nothing came after {state}"
        case ("plan", agent, label):
            beliefs = surroundings.plans.get(agent, {}).get(label, ())
            return f"the beliefs {' '.join(beliefs)} reach it" if beliefs else ""
    return ""


def _before(file: str, line: str, archive: Archive, surroundings: Surroundings) -> str:
    """The statement at which the code has to continue to a line that was not executed, as far as that is known."""
    for point in archive.open:
        if point[:2] == ("branch", file) and point[3] == line and ("statement", file, point[2]) in archive.best:
            return f"line {point[2]}{surroundings.text(file, point[2])} has to continue to it"
    statements = (int(hit[2]) for hit in archive.best if hit[:2] == ("statement", file))
    last = str(max((executed for executed in statements if executed < int(line)), default=0))
    return f"executed up to line {last}{surroundings.text(file, last)}" if int(last) else ""


def waiver(point: Point, archive: Archive) -> str:
    """The line by which a person declares a point impossible; empty if there is none."""
    match point:
        case ("bin", product, *parts):
            return f'cross product {product}: impossible={{{tuple(parts)}: "why"}}'
        case ("statement", file, line):
            return f"{file}:{line}: # unreachable: why"
        case ("branch", file, begin, end):
            ends = [line for line in (begin, end) if ("statement", file, line) in archive.open]
            return f"{file}:{ends[0]}: # unreachable: why" if ends else ""
        case ("verdict", requirement, "Passed"):
            violated = ("verdict", requirement, "Failed") in archive.best
            return f"{'hri_known_violations' if violated else 'hri_allow_nc'} = {requirement}: why"
    return ""
