"""Open points: the run that came closest to each, what it lacked, and how to declare a point impossible."""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import CodeMap
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.archive import Archive, ArchivedRun


@dataclass(frozen=True)
class Surroundings:
    """The parts of the system under test that explain open points.

    Args:
        code: under test; None if it is not measured.
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
        case ("verdict", requirement, "Passed") if entry is not None:
            return " & ".join(entry.observation.missing.get(requirement, ()))
        case ("condition", *names, "false") if ("condition", *names, "true") in archive.best:
            return "it was always true: the antecedent may do without it"
        case ("statement", file, line):
            return _before(file, line, archive, surroundings)
        case ("branch", file, begin, end) if entry is not None:
            goes = "the exit" if int(end) < 0 else f"line {end}"
            return f"line {begin}{surroundings.text(file, begin)} has to go on to {goes}"
        case ("plan", agent, label):
            beliefs = surroundings.plans.get(agent, {}).get(label, ())
            return f"the beliefs {' '.join(beliefs)} reach it" if beliefs else ""
    return ""


def _before(file: str, line: str, archive: Archive, surroundings: Surroundings) -> str:
    """The statement at which the code has to go on to a line that was not executed, as far as that is known."""
    for point in archive.open:
        if point[:2] == ("branch", file) and point[3] == line and ("statement", file, point[2]) in archive.best:
            return f"line {point[2]}{surroundings.text(file, point[2])} has to go on to it"
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
