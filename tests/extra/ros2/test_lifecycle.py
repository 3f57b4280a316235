"""The state machine of a managed node."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.ros2.lifecycle import LifecycleStateMachine
from pytest_hricdv.runtime import Kernel
from tests.extra.ros2.system import node, run


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
