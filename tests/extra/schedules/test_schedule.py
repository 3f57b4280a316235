"""Schedules as part of concrete tests."""

from __future__ import annotations

import json
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.schedule import ScheduleDecision

OCCURRENCES, DELAYS = st.integers(0, 99), st.floats(0.0, 1.0)
DECISIONS = st.one_of(
    st.builds(
        ScheduleDecision,
        st.sampled_from(["preemption", "delay"]),
        st.sampled_from(["robot.py:7", "robot.py:7=", "a:b/robot.py:7"]),
        OCCURRENCES,
        DELAYS,
        node=st.sampled_from(["", "arm"]),
    ),
    st.builds(ScheduleDecision, st.just("order"), st.just(""), OCCURRENCES, choice=st.integers(1, 3)),
    st.builds(ScheduleDecision, st.just("delivery"), st.sampled_from(["stop", "stop:1"]), OCCURRENCES, DELAYS),
)
TEST = ConcreteTest("t", "suite", 0, (ConcreteAction("stop", {"pause_s": 0.25}),), {"patience_s": 2.0})


@given(st.lists(DECISIONS, max_size=3))
def test_a_test_with_a_schedule_is_read_as_it_was_written(decisions: list[ScheduleDecision]) -> None:
    test = ConcreteTest(TEST.id, TEST.suite, TEST.seed, TEST.actions, TEST.run, schedule=tuple(decisions))
    again = ConcreteTest.from_json(test.to_json())
    assert again == test
    assert [decision.node for decision in again.schedule] == [decision.node for decision in decisions]


def test_without_decisions_it_is_written_as_ever() -> None:
    assert "schedule" not in TEST.to_json()


@pytest.mark.parametrize(
    ("decision", "said"),
    [
        ({"kind": "wait", "occurrence": 1}, "Invalid enum value 'wait'"),
        ({"kind": "delay", "file": "a.py", "line": 1}, "missing required field `occurrence`"),
        ({"kind": "delay", "file": "a.py", "line": 1, "occurrence": 1, "delay_s": -1.0}, ">= 0"),
        (
            {"kind": "preemption", "file": "a.py", "occurrence": 1},
            "a decision of a schedule, preemption, lacks its file",
        ),
        ({"kind": "order", "occurrence": 1}, "a decision of a schedule, order, lacks its choice"),
        ({"kind": "delivery", "occurrence": 1}, "a decision of a schedule, delivery, lacks its topic"),
    ],
)
def test_what_is_no_decision_is_refused(decision: dict[str, object], said: str) -> None:
    test = {**json.loads(TEST.to_json()), "schedule": {"decisions": [decision]}}
    with pytest.raises(GenerateError, match=re.escape(said)):
        ConcreteTest.from_json(json.dumps(test))
