"""Coverage of the code under test as Cobertura XML, which GitLab, Jenkins, Azure and others show beside the source.

Format: Cobertura's `coverage-04.dtd`. `hits` of a line is the number of tests that reach it. Waived lines are left out.
"""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

from pytest_hricdv.report.hits import FileHits, hits

_HEAD = '<?xml version="1.0" encoding="UTF-8"?>\n'
_DOCTYPE = '<!DOCTYPE coverage SYSTEM "http://cobertura.sourceforge.net/xml/coverage-04.dtd">\n'


def cobertura(report: Mapping[str, Any], root: str) -> str:
    """The XML text.

    Args:
        report: whose code was measured.
        root: the folder that the report's file names are relative to: the XML's only source folder.
    """
    files = hits(report)
    coverage = ET.Element("coverage", _totals(files) | {"complexity": "0", "version": report["version"]})
    coverage.set("timestamp", "0")  # equal runs give equal files, whatever the day
    ET.SubElement(ET.SubElement(coverage, "sources"), "source").text = root
    packages = ET.SubElement(coverage, "packages")
    for folder in sorted({_folder(file) for file in files}):
        inside = [file for file in files if _folder(file) == folder]
        name = ".".join(PurePosixPath(folder).parts) or "."
        package = ET.SubElement(packages, "package", {"name": name, **_rates(inside), "complexity": "0"})
        classes = ET.SubElement(package, "classes")
        for file in inside:
            _class(classes, file)
    ET.indent(coverage, " ")
    return f"{_HEAD}{_DOCTYPE}{ET.tostring(coverage, encoding='unicode')}\n"


def _class(classes: ET.Element, file: FileHits) -> None:
    names = {"name": PurePosixPath(file.name).name, "filename": file.name}
    element = ET.SubElement(classes, "class", {**names, **_rates([file]), "complexity": "0"})
    ET.SubElement(element, "methods")
    lines = ET.SubElement(element, "lines")
    for number, count in sorted(file.lines.items()):
        line = ET.SubElement(lines, "line", {"number": str(number), "hits": str(count)})
        ways = file.conditions(number)
        if ways:
            _conditions(line, ways)


def _conditions(line: ET.Element, ways: Sequence[int]) -> None:
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
    counts = dict(
        zip(
            ("lines-covered", "lines-valid", "branches-covered", "branches-valid"),
            map(str, _counts(files)),
            strict=True,
        )
    )
    return _rates(files) | counts


def _rates(files: Sequence[FileHits]) -> dict[str, str]:
    lines, of_lines, ways, of_ways = _counts(files)
    return {"line-rate": _rate(lines, of_lines), "branch-rate": _rate(ways, of_ways)}


def _rate(part: int, whole: int) -> str:
    return f"{part / whole:.4g}" if whole else "1"
