"""Schedules as part of concrete tests."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.schedule import ScheduleDecision, schedule_from_data

DECISIONS = st.builds(
    ScheduleDecision,
    st.sampled_from(["hold", "delay", "order", "delivery"]),
    st.sampled_from(["", "robot.py:7", "robot.py:7="]),
    st.integers(1, 99),
    st.floats(0.0, 1.0),
)
TEST = ConcreteTest("t", "suite", 0, (ConcreteAction("stop", {"pause_s": 0.25}),), {"patience_s": 2.0})


@given(st.lists(DECISIONS, max_size=3))
def test_a_test_with_a_schedule_is_read_as_it_was_written(decisions: list[ScheduleDecision]) -> None:
    test = ConcreteTest(TEST.id, TEST.suite, TEST.seed, TEST.actions, TEST.run, schedule=tuple(decisions))
    assert ConcreteTest.from_json(test.to_json()) == test


def test_without_decisions_it_is_written_as_ever() -> None:
    assert "schedule" not in TEST.to_json()


@pytest.mark.parametrize("entry", [["wait", "a.py:1", 1, 0.1], ["hold", "a.py:1"], ["hold", 3, 1, 0.1]])
def test_what_is_no_decision_is_refused(entry: list[object]) -> None:
    with pytest.raises(GenerateError, match=r"no decision of a schedule: .*expected \[kind, place, number, value\]"):
        schedule_from_data([entry])
