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


def executing(*lines: int, branches: int = 0) -> Bits:
    return Bits(sum(1 << line - 1 for line in lines), branches)


def suspects(code: CodeMap, failing: list[Bits], passing: list[Bits]) -> tuple[Suspect, ...]:
    failed = {f"failing{number}": bits for number, bits in enumerate(failing)}
    passed = {f"passing{number}": bits for number, bits in enumerate(passing)}
    return Spectra(code, failed | passed).suspects(failed)


def test_what_only_failing_tests_execute_is_the_most_suspicious() -> None:
    ranked = suspects(code(3), [executing(1, 2), executing(1, 2)], [executing(1, 3), executing(1)])
    assert [suspect.line for suspect in ranked] == [2, 1]
    assert ranked[0].score == 1.0
    assert ranked[1].score == pytest.approx(math.sqrt(0.5))


def test_a_branch_speaks_for_the_statement_that_it_leaves() -> None:
    ranked = suspects(
        code(2, ((1, 2), (1, -1))), [executing(1, 2, branches=0b01)], [executing(1, 2, branches=0b10)] * 3
    )
    assert (ranked[0].line, ranked[0].score) == (1, 1.0)


def test_of_equal_statements_the_last_comes_first() -> None:
    assert [suspect.line for suspect in suspects(code(3), [executing(1, 2, 3)], [])] == [3, 2, 1]


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
