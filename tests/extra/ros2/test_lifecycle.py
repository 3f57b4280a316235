"""The state machine of a managed node."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.lifecycle import CallbackReturn, LifecycleStateMachine
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import node, run


def test_a_node_is_configured_activated_and_shut_down() -> None:
    states = []

    def robot(kernel: Kernel) -> None:
        machine = LifecycleStateMachine(node("robot"), False)
        for label in ("configure", "activate", "deactivate", "cleanup", "shutdown"):
            machine.trigger_transition_by_id(machine.get_transition_by_label(label), True)
            states.append(machine.current_state[1])
            machine.trigger_transition_by_label(CallbackReturn.SUCCESS.to_label(), True)
            states.append(machine.current_state[1])
        assert machine.available_transitions == []

    run(robot)
    assert states == [
        *("configuring", "inactive", "activating", "active", "deactivating", "inactive"),
        *("cleaningup", "unconfigured", "shuttingdown", "finalized"),
    ]


def test_a_transition_that_begins_elsewhere_is_refused() -> None:
    def robot(kernel: Kernel) -> None:
        machine = LifecycleStateMachine(node("robot"), False)
        with pytest.raises(RCLError, match="unconfigured has no 'activate'"):
            machine.get_transition_by_label("activate")
        with pytest.raises(RCLError, match="unconfigured has no 3"):
            machine.trigger_transition_by_id(3, False)
        assert machine.current_state == (1, "unconfigured")

    run(robot)


@given(choices=st.lists(st.integers(0, 3), max_size=30))
def test_whatever_happens_a_callback_is_never_skipped(choices: list[int]) -> None:
    """Between two states in which a node rests there is always one in which its callback is called."""

    def robot(kernel: Kernel) -> None:
        machine = LifecycleStateMachine(node("robot"), False)
        for choice in choices:
            possible = machine.available_transitions
            if not possible:
                assert machine.current_state[1] == "finalized"
                return
            rests = machine.current_state[0] < 10
            machine.trigger_transition_by_id(possible[choice % len(possible)][0], False)
            left_for_error = machine.current_state[1] == "errorprocessing"
            assert (machine.current_state[0] >= 10) == rests or left_for_error

    run(robot)
