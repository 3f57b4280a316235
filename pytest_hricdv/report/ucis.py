"""Coverage as UCIS XML, which verification managers read and merge (Accellera UCIS 1.0, chapter 9).

Each suite is an instance with its assertions (the requirements), a covergroup with a coverpoint for each agent's plans,
and a covergroup for each cross product, in which impossible bins are ignored and those that must not be hit are
illegal. The code under test is an instance of its own. Tests are history nodes.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import product

from pytest_hricdv.coverage.cross_product import ProductCoverage, ProductDeclaration
from pytest_hricdv.coverage.records import PlanCoverage
from pytest_hricdv.execution.outcome import AS_DECLARED
from pytest_hricdv.monitor import RequirementResult
from pytest_hricdv.report.code_formats import FileHits, hits, xml_text
from pytest_hricdv.results.model import Report, SuiteResult, TestResult

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
        _branches(branches, number, file)


def _branches(parent: ET.Element, number: int, file: FileHits) -> None:
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
