"""Cobertura XML and LCOV: valid, and with the numbers of the report."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.report.coverage_formats import cobertura, hits, lcov
from pytest_hricdv.results.model import Report
from tests.report import sample
from tests.report.dtd import faults


def _report(
    tests: list[tuple[int, int]], waived: tuple[int, ...] = (), *, branches: bool = True, measured: bool = True
) -> Report:
    """Two files: lines 1 to 4 and 10 to 12; branches 2->3, 2->4 and 11->-10, 11->12. `tests` have bits of both."""
    data = sample.data(tests=len(tests))
    data["code_under_test"] |= {
        "measured": measured,
        "waivers": [{"file": "b/c/two.py", "line": line, "reason": "why"} for line in waived],
        "map": [
            {"file": "a/one.py", "statements": [1, 2, 3, 4], "branches": [[2, 3], [2, 4]], "source": ""},
            {"file": "b/c/two.py", "statements": [10, 11, 12], "branches": [[11, -10], [11, 12]], "source": ""},
        ],
    }
    for test, (statements, arcs) in zip(data["tests"], tests, strict=True):
        test["code"] = {"statements": 0, "percent": 0.0, "bits": [hex(statements), hex(arcs) if branches else None]}
    return sample.typed(data)


BITS = st.lists(st.tuples(st.integers(0, 127), st.integers(0, 15)), max_size=8)


@given(BITS)
def test_each_line_and_branch_counts_the_tests_that_reach_it(tests: list[tuple[int, int]]) -> None:
    first, second = hits(_report(tests))
    assert (first.name, second.name) == ("a/one.py", "b/c/two.py")
    lines = [*first.lines.values(), *second.lines.values()]
    assert [*first.lines, *second.lines] == [1, 2, 3, 4, 10, 11, 12]
    assert lines == [sum(statements >> place & 1 for statements, _ in tests) for place in range(7)]
    assert first.branches is not None
    assert second.branches is not None
    branches = [*first.branches.values(), *second.branches.values()]
    assert [*first.branches, *second.branches] == [(2, 3), (2, 4), (11, -10), (11, 12)]
    assert branches == [sum(bits >> place & 1 for _, bits in tests) for place in range(4)]


@given(BITS)
def test_cobertura_is_valid_and_adds_up(tests: list[tuple[int, int]]) -> None:
    root = ET.fromstring(cobertura(_report(tests), "/the/root"))
    assert faults(root) == []
    covered = [line for line in root.iter("line") if int(line.attrib["hits"])]
    assert root.attrib["lines-valid"] == "7"
    assert root.attrib["lines-covered"] == str(len(covered))
    assert float(root.attrib["line-rate"]) == pytest.approx(len(covered) / 7, abs=1e-4)
    ways = [line.attrib["condition-coverage"] for line in root.iter("line") if line.get("branch") == "true"]
    assert sum(int(way.split("(")[1].split("/")[0]) for way in ways) == int(root.attrib["branches-covered"])
    assert [element.attrib["filename"] for element in root.iter("class")] == ["a/one.py", "b/c/two.py"]
    assert [element.attrib["name"] for element in root.iter("package")] == ["a", "b.c"]
    assert root.findtext("sources/source") == "/the/root"


def test_what_is_waived_is_left_out_of_both() -> None:
    report = _report([(0b0000011, 0b01)], waived=(12,))
    root = ET.fromstring(cobertura(report, "."))
    assert (root.attrib["lines-valid"], root.attrib["branches-valid"]) == ("6", "3")
    assert "DA:12," not in lcov(report)
    assert "BRF:1\n" in lcov(report)


def test_lcov_has_its_records() -> None:
    _, _, second = lcov(_report([(0b0100011, 0b0101), (0b0000011, 0b0001)])).partition("end_of_record\n")
    assert lcov(_report([(0b0100011, 0b0101), (0b0000011, 0b0001)])).splitlines()[:12] == [
        "TN:",
        "SF:a/one.py",
        "BRDA:2,0,0,2",
        "BRDA:2,0,1,0",
        "BRF:2",
        "BRH:1",
        "DA:1,2",
        "DA:2,2",
        "DA:3,0",
        "DA:4,0",
        "LF:4",
        "LH:2",
    ]
    assert "BRDA:11,0,0,1\nBRDA:11,0,1,0\n" in second
