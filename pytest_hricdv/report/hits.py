"""How many tests reach each statement and branch of the code under test, for the files that other tools read."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

Arc = tuple[int, int]


@dataclass(frozen=True)
class FileHits:
    """One file of the code under test: tests by line, and by branch (from line, to line; negative for an exit).

    Waived lines, and branches from or to them, are left out, as tools leave out what is excluded from coverage.
    `branches` is None where only lines were measured.
    """

    name: str
    lines: Mapping[int, int]
    branches: Mapping[Arc, int] | None

    def conditions(self, line: int) -> list[int]:
        """The tests by branch that leaves this line, in order; empty where it has one way out only."""
        return [hits for arc, hits in sorted((self.branches or {}).items()) if arc[0] == line]


def hits(report: Mapping[str, Any]) -> tuple[FileHits, ...]:
    """Per file, by name; empty where the code was not measured."""
    code = report.get("code_under_test", {})
    files: Sequence[Mapping[str, Any]] = code.get("map", ())
    if not code.get("measured") or not files:
        return ()
    measured = [test["code"]["bits"] for test in report["tests"] if test["code"] and "bits" in test["code"]]
    statements = _counted([each[0] for each in measured])
    arcs = None if any(each[1] is None for each in measured) else _counted([each[1] for each in measured])
    waived = {(waiver["file"], waiver["line"]) for waiver in code.get("waivers", ())}
    return tuple(sorted(_files(files, statements, arcs, waived), key=lambda file: file.name))


def _files(
    files: Sequence[Mapping[str, Any]],
    statements: Mapping[int, int],
    arcs: Mapping[int, int] | None,
    waived: set[tuple[str, int]],
) -> Iterator[FileHits]:
    statement = arc = 0  # a bit is a statement's or a branch's place among those of all files
    for file in files:
        name, listed, ways = file["file"], file["statements"], [(way[0], way[1]) for way in file["branches"]]
        lines = {line: statements.get(place, 0) for place, line in enumerate(listed, statement)}
        branches = None if arcs is None else {way: arcs.get(place, 0) for place, way in enumerate(ways, arc)}
        statement, arc = statement + len(listed), arc + len(ways)
        out = {line for line in lines if (name, line) in waived}
        kept = None if branches is None else {way: n for way, n in branches.items() if not out & set(way)}
        yield FileHits(name, {line: n for line, n in lines.items() if line not in out}, kept)


def _counted(numbers: Sequence[str]) -> dict[int, int]:
    """How many of the hexadecimal numbers have each bit set; suites have many tests with equal coverage."""
    counts: dict[int, int] = {}
    times: dict[str, int] = {}
    for number in numbers:
        times[number] = times.get(number, 0) + 1
    for number, count in times.items():
        for place, digit in enumerate(reversed(bin(int(number, 16)))):
            if digit == "1":
                counts[place] = counts.get(place, 0) + count
    return counts
