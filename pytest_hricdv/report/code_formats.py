"""Coverage of the code as Cobertura and LCOV.

coverage.py's own writers are not used: they know whether a line ran, not how many tests ran it; they analyse files on
disk again, where a report is written from its own map and waivers, on any machine; and their XML has the time of day,
although equal reports have to give equal files.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import add
from pathlib import PurePosixPath

from pytest_hricdv._base.message import visible
from pytest_hricdv.results.model import Report

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
_DOCTYPE = '<!DOCTYPE coverage SYSTEM "http://cobertura.sourceforge.net/xml/coverage-04.dtd">\n'

Arc = tuple[int, int]


@dataclass(frozen=True)
class FileHits:
    """One file of the code under test: tests by line, and by branch (from line, to line; negative for an exit).

    Waived lines, and branches from or to them, are left out, as tools leave out what is excluded from coverage; tests
    by waived line are in `waived`. `branches` is None if only lines were measured.
    """

    name: str
    lines: Mapping[int, int]
    branches: Mapping[Arc, int] | None
    waived: Mapping[int, int]

    def branches_by_line(self) -> dict[int, dict[int, int]]:
        """Line that branches -> line to which a branch leads -> tests, all in order."""
        lines: dict[int, dict[int, int]] = {}
        for (line, target), tests in sorted((self.branches or {}).items()):
            lines.setdefault(line, {})[target] = tests
        return lines


def cobertura(report: Report, root: str) -> str:
    """The coverage as Cobertura XML.

    Args:
        report: of a run that measured the code.
        root: the folder that the report's file names are relative to: the XML's only source folder.
    """
    files = hits(report)
    coverage = ET.Element("coverage", _totals(files) | {"complexity": "0", "version": report.version})
    coverage.set("timestamp", "0")  # equal runs give equal files
    ET.SubElement(ET.SubElement(coverage, "sources"), "source").text = root
    packages = ET.SubElement(coverage, "packages")
    for folder in sorted({_folder(file) for file in files}):
        inside = [file for file in files if _folder(file) == folder]
        name = ".".join(PurePosixPath(folder).parts) or "."
        package = ET.SubElement(packages, "package", {"name": name, **_rates(inside), "complexity": "0"})
        classes = ET.SubElement(package, "classes")
        for file in inside:
            _class(classes, file)
    return xml_text(coverage, _DOCTYPE)


def xml_text(root: ET.Element, doctype: str = "") -> str:
    """A document with a line for each element, without invisible characters."""
    ET.indent(root, " ")
    return f"{_HEAD}{doctype}{visible(ET.tostring(root, encoding='unicode'), keep=chr(10))}\n"


def lcov(report: Report) -> str:
    """The coverage as an LCOV tracefile; file names are the report's, relative to the project's root folder."""
    return "".join(f"{line}\n" for file in hits(report) for line in _record(file))


def hits(report: Report) -> tuple[FileHits, ...]:
    """Tests per line and branch of each file, by name; empty if the code was not measured."""
    return tuple(sorted(count_hits(report), key=lambda file: file.name)) if report.code_under_test.measured else ()


def count_hits(report: Report) -> Iterator[FileHits]:
    """Tests per line and branch of each file, in the order of the report's map."""
    code = report.code_under_test
    bits = [test.code.bits for test in report.tests if test.code]
    statements = iter(count_bits([lines for lines, _ in bits], sum(len(file.statements) for file in code.map)))
    measured_arcs = [arcs for _, arcs in bits if arcs is not None]
    arcs = iter(count_bits(measured_arcs, sum(len(file.branches) for file in code.map)))
    waivers = {(waiver.file, waiver.line) for waiver in code.waivers}
    for file in code.map:
        counts = {line: next(statements) for line in file.statements}
        branches = {branch: next(arcs) for branch in file.branches}
        waived = {line: counts.pop(line) for line in file.statements if (file.file, line) in waivers}
        needed = {branch: count for branch, count in branches.items() if waived.keys().isdisjoint(branch)}
        yield FileHits(file.file, counts, needed if len(measured_arcs) == len(bits) else None, waived)


def _class(classes: ET.Element, file: FileHits) -> None:
    names = {"name": PurePosixPath(file.name).name, "filename": file.name}
    element = ET.SubElement(classes, "class", {**names, **_rates([file]), "complexity": "0"})
    ET.SubElement(element, "methods")
    lines = ET.SubElement(element, "lines")
    by_line = file.branches_by_line()
    for number, count in sorted(file.lines.items()):
        line = ET.SubElement(lines, "line", {"number": str(number), "hits": str(count)})
        if number in by_line:
            _conditions(line, by_line[number].values())


def _conditions(line: ET.Element, ways: Collection[int]) -> None:
    taken = sum(count > 0 for count in ways)
    share = 100 * taken // len(ways)
    line.set("branch", "true")
    line.set("condition-coverage", f"{share}% ({taken}/{len(ways)})")
    conditions = ET.SubElement(line, "conditions")
    ET.SubElement(conditions, "condition", {"number": "0", "type": "jump", "coverage": f"{share}%"})


def _folder(file: FileHits) -> str:
    return str(PurePosixPath(file.name).parent)


def _counts(files: Sequence[FileHits]) -> tuple[int, int, int, int]:
    lines = [count for file in files for count in file.lines.values()]
    ways = [count for file in files for count in (file.branches or {}).values()]
    return sum(count > 0 for count in lines), len(lines), sum(count > 0 for count in ways), len(ways)


def _totals(files: Sequence[FileHits]) -> dict[str, str]:
    names = ("lines-covered", "lines-valid", "branches-covered", "branches-valid")
    return _rates(files) | dict(zip(names, map(str, _counts(files)), strict=True))


def _rates(files: Sequence[FileHits]) -> dict[str, str]:
    lines, of_lines, ways, of_ways = _counts(files)
    return {"line-rate": _rate(lines, of_lines), "branch-rate": _rate(ways, of_ways)}


def _rate(part: int, whole: int) -> str:
    return f"{part / whole:.4g}" if whole else "1"


def _record(file: FileHits) -> Iterator[str]:
    yield "TN:"
    yield f"SF:{visible(file.name)}"
    if file.branches is not None:
        yield from _branches(file)
    for line, count in sorted(file.lines.items()):
        yield f"DA:{line},{count}"
    yield f"LF:{len(file.lines)}"
    yield f"LH:{sum(count > 0 for count in file.lines.values())}"
    yield "end_of_record"


def _branches(file: FileHits) -> Iterator[str]:
    for line, targets in file.branches_by_line().items():
        for number, count in enumerate(targets.values()):
            # A line that was never reached has no count for its branches.
            yield f"BRDA:{line},0,{number},{count if file.lines.get(line) else '-'}"
    counts = (file.branches or {}).values()
    yield f"BRF:{len(counts)}"
    yield f"BRH:{sum(count > 0 for count in counts)}"


def count_bits(numbers: Sequence[str], size: int) -> list[int]:
    """How many of the hexadecimal numbers have each of the first `size` bits set."""
    counts = [0] * size
    for number in numbers:
        counts = list(map(add, counts, f"{int(number, 16):0{size}b}"[::-1].encode()))
    return [count - len(numbers) * ord("0") for count in counts]
