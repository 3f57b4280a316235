"""Which statements are suspicious."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.coverage.code_map import Bits, CodeMap, SourceFile
from pytest_hricdv.extra.diagnosis.spectrum import ExecutionCounts, Spectra, Suspect, ochiai


def code(statements: int, branches: tuple[tuple[int, int], ...] = ()) -> CodeMap:
    return CodeMap(
        ("robot",), (SourceFile("robot.py", Path("robot.py"), tuple(range(1, statements + 1)), branches, ()),), ""
    )


def suspects(code: CodeMap, failing: list[Bits], passing: list[Bits]) -> tuple[Suspect, ...]:
    failed = {f"failing{number}": bits for number, bits in enumerate(failing)}
    passed = {f"passing{number}": bits for number, bits in enumerate(passing)}
    return Spectra(code, failed | passed).suspects(failed)


def test_the_coefficient_is_that_of_the_paper() -> None:
    counts = ExecutionCounts(failing=2, passing=1, all_failing=4)
    assert ochiai(counts) == pytest.approx(2 / math.sqrt(4 * 3))
    assert ochiai(ExecutionCounts(0, 3, 2)) == 0.0


@given(st.lists(st.integers(0, 255), min_size=1, max_size=6), st.lists(st.integers(0, 255), max_size=6))
def test_counting_sets_once_is_counting_tests(failing: list[int], passing: list[int]) -> None:
    ranked = suspects(code(8), [Bits(bits) for bits in failing], [Bits(bits) for bits in passing])
    scores = {suspect.line: suspect.score for suspect in ranked}
    for line in range(1, 9):
        failed, passed = (sum(bits >> line - 1 & 1 for bits in tests) for tests in (failing, passing))
        assert scores.get(line, 0.0) == ochiai(ExecutionCounts(failed, passed, len(failing)))
