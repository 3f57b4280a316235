"""A report's coverage as text in formats of other tools: `cobertura`, `lcov`, and `ucis` for verification managers.

`exports` writes the files; `sources_view` counts hits with `count_hits`. coverage.py's own writers are not used: they
know whether a line ran, but not how many tests ran it; they need the files on disk, while a report has its own map and
waivers; and their XML has the time of day, although equal reports have to give equal files.

In UCIS (Accellera UCIS 1.0, chapter 9), each suite is an instance with its assertions (the requirements), a covergroup
with a coverpoint for each agent's plans, and a covergroup for each cross product, in which impossible bins are ignored
and those that must not be hit are illegal. The code under test is an instance of its own. Tests are history nodes.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from operator import add
from pathlib import PurePosixPath

from pytest_hricdv._base.message import visible
from pytest_hricdv.coverage.cross_product import ProductCoverage, ProductDeclaration
from pytest_hricdv.coverage.records import PlanCoverage
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

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
        report: the report of a run that measured the code.
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


_VERSION = "1.0"
_NO_TIME = "1970-01-01T00:00:00"  # equal runs give equal files
_NAME = "pytest-hricdv"


def ucis(report: Report) -> str:
    """The coverage as UCIS XML."""
    root = ET.Element("UCIS", ucisVersion=_VERSION, writtenBy=_NAME, writtenTime=_NO_TIME)
    files = hits(report)
    # The format wants a source file even where no code was measured.
    for number, name in enumerate([file.name for file in files] or [report.testbench], 1):
        ET.SubElement(root, "sourceFiles", fileName=name, id=str(number))
    for number, test in enumerate(report.tests):
        _history_node(root, number, test, report)
    if not report.tests:
        _history_node(root, 0, None, report)
    if files:
        _code(_instance(root, "code under test", "code"), files)
    for suite in report.suites:
        _suite(_instance(root, suite.name, report.testbench), suite, report)
    if not (files or report.suites):
        _instance(root, report.testbench, report.testbench)
    return xml_text(root)


def _history_node(root: ET.Element, number: int, test: TestResult | None, report: Report) -> None:
    node = ET.SubElement(root, "historyNodes", historyNodeId=str(number))
    node.set("logicalName", test.id if test is not None else "no test")
    node.set("kind", "1")  # a test
    node.set("testStatus", "true" if test is not None and test.outcome in AS_DECLARED else "false")
    if test is not None:
        node.attrib.update(simtime=repr(test.sim_s), timeunit="s", seed=str(test.seed), cmd=test.nodeid)
    node.attrib.update(date=_NO_TIME, toolCategory="UCIS:simulator", ucisVersion=_VERSION)
    node.attrib.update(vendorId=_NAME, vendorTool=_NAME, vendorToolVersion=report.version)


def _instance(root: ET.Element, name: str, module: str) -> ET.Element:
    instance = ET.SubElement(root, "instanceCoverages", name=name, key=name, moduleName=module)
    _place(instance, "id")
    return instance


def _place(parent: ET.Element, tag: str, file: int = 1, line: int = 1, item: int = 1) -> None:
    ET.SubElement(parent, tag, file=str(file), line=str(line), inlineCount=str(item))


def _bin(parent: ET.Element, tag: str, count: int, alias: str = "") -> None:
    element = ET.SubElement(parent, tag, {"alias": alias} if alias else {})
    ET.SubElement(element, "contents", coverageCount=str(count))


def _code(instance: ET.Element, files: Iterable[FileHits]) -> None:
    numbered = list(enumerate(files, 1))
    if any(file.lines for _, file in numbered):
        blocks = ET.SubElement(instance, "blockCoverage")
        for number, file in numbered:
            for line, count in sorted(file.lines.items()):
                statement = ET.SubElement(blocks, "statement", alias=f"{file.name}:{line}")
                _place(statement, "id", number, line)
                _bin(statement, "bin", count)
    branches = ET.SubElement(instance, "branchCoverage")
    for number, file in numbered:
        _ucis_branches(branches, number, file)


def _ucis_branches(parent: ET.Element, number: int, file: FileHits) -> None:
    for line, targets in file.branches_by_line().items():
        statement = ET.SubElement(parent, "statement", branchExpr=f"{file.name}:{line}", statementType="if")
        _place(statement, "id", number, line)
        for target, count in targets.items():
            branch = ET.SubElement(statement, "branch")
            _place(branch, "id", number, target if target > 0 else line)
            _bin(branch, "branchBin", count, f"to line {target}" if target > 0 else "to the exit")


def _suite(instance: ET.Element, suite: SuiteResult, report: Report) -> None:
    tests = [test for test in report.tests if test.suite == suite.name]
    assertions = ET.SubElement(instance, "assertionCoverage")
    for name in suite.requirements:
        _assertion(assertions, name, [test.requirements[name] for test in tests if name in test.requirements])
    groups = ET.SubElement(instance, "covergroupCoverage")
    if any(plans.declared for plans in suite.plans.values()):
        _plans(groups, suite.plans)
    for name, coverage in suite.cross.products.items():
        _cross(groups, name, report.cross_products[name], coverage)


def _assertion(parent: ET.Element, name: str, results: Iterable[RequirementResult]) -> None:
    """A requirement; a trigger is what UCIS calls an attempt."""
    of_tests = list(results)
    element = ET.SubElement(parent, "assertion", name=name, assertionKind="assert")
    _bin(element, "passBin", sum(result.passes for result in of_tests))
    _bin(element, "failBin", sum(result.failures for result in of_tests))
    _bin(element, "vacuousBin", sum(result.untriggered for result in of_tests))
    _bin(element, "attemptBin", sum(result.triggers for result in of_tests))


def _group(parent: ET.Element, name: str) -> ET.Element:
    group = ET.SubElement(parent, "cgInstance", name=name, key=name)
    ET.SubElement(group, "options")
    named = ET.SubElement(group, "cgId", cgName=name, moduleName=_NAME)
    _place(named, "cginstSourceId")
    _place(named, "cgSourceId")
    return group


def _coverpoint(group: ET.Element, name: str, counts: Mapping[str, int]) -> None:
    point = ET.SubElement(group, "coverpoint", name=name, key=name)
    ET.SubElement(point, "options")
    for number, (value, count) in enumerate(counts.items()):
        element = ET.SubElement(point, "coverpointBin", {"name": value, "key": value, "type": "bins"})
        place = ET.SubElement(element, "range", {"from": str(number), "to": str(number)})
        ET.SubElement(place, "contents", coverageCount=str(count))


def _plans(groups: ET.Element, plans: Mapping[str, PlanCoverage]) -> None:
    group = _group(groups, "plans")
    for agent, covered in plans.items():
        if covered.declared:
            reached = {label: reach.tests for label, reach in covered.reached.items()}
            _coverpoint(group, agent, {label: reached.get(label, 0) for label in covered.declared})


def _cross(groups: ET.Element, name: str, declared: ProductDeclaration, coverage: ProductCoverage) -> None:
    group = _group(groups, name)
    hit = {record.bin: record.hits for record in coverage.hits}
    for place, coordinate in enumerate(declared.coordinates):
        counts: Counter[str] = Counter()
        for bin_, times in hit.items():
            counts[bin_[place]] += times
        _coverpoint(group, coordinate.name, {value: counts[value] for value in coordinate.bins})
    cross = ET.SubElement(group, "cross", name=name, key=name)
    ET.SubElement(cross, "options")
    for coordinate in declared.coordinates:
        ET.SubElement(cross, "crossExpr").text = coordinate.name
    kinds = dict.fromkeys((record.bin for record in declared.impossible), "ignore")
    kinds |= dict.fromkeys((record.bin for record in declared.illegal), "illegal")
    for indexed in product(*(enumerate(coordinate.bins) for coordinate in declared.coordinates)):
        values = tuple(value for _, value in indexed)
        text = " x ".join(values)
        element = ET.SubElement(cross, "crossBin", {"name": text, "key": text, "type": kinds.get(values, "default")})
        for index, _ in indexed:
            ET.SubElement(element, "index").text = str(index)
        ET.SubElement(element, "contents", coverageCount=str(hit.get(values, 0)))
