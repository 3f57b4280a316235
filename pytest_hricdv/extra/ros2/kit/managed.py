"""Stands in for a managed node, such as `map_server`: it has a life cycle that others control."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from pytest_hricdv.extra.ros2.clocks import system_ns
from pytest_hricdv.extra.ros2.handles import RCLError
from pytest_hricdv.extra.ros2.lifecycle import LifecycleStateMachine, Transition
from pytest_hricdv.extra.ros2.vocabulary import import_type
from pytest_hricdv.extra.ros2.world import StartedSystem


class ManagedNode:
    """A managed node without content: its services, and the transitions that it goes through.

    Args:
        system: of `run.ros2`.
        name: of the node, in the namespace "/".
        on_transition: called with "configure", "activate", "deactivate", "cleanup" or "shutdown"; whether it
            succeeds. It may block: so long the transition lasts.

    Raises:
        Ros2Error: `lifecycle_msgs` is missing.
    """

    def __init__(
        self, system: StartedSystem, name: str, on_transition: Callable[[str], bool] = lambda label: True
    ) -> None:
        self._system, self._on_transition = system, on_transition
        world = system.node(name)
        self._machine = LifecycleStateMachine(world.graph_node, False)
        self._events = world.publisher(f"/{name}/transition_event", "lifecycle_msgs/msg/TransitionEvent")
        graph = self._machine.transition_graph
        for service, kind, answer in (
            ("change_state", "ChangeState", self._change),
            ("get_state", "GetState", self._tell_state),
            ("get_available_states", "GetAvailableStates", self._tell_states),
            (
                "get_available_transitions",
                "GetAvailableTransitions",
                self._answer_with(lambda: self._machine.available_transitions),
            ),
            ("get_transition_graph", "GetAvailableTransitions", self._answer_with(lambda: graph)),
        ):
            world.serve(f"/{name}/{service}", f"lifecycle_msgs/srv/{kind}", answer)

    @property
    def state(self) -> str:
        """The label of its state, as "active"."""
        return self._machine.current_state[1]

    def _change(self, request: Any, response: Any) -> Any:
        wanted, machine = request.transition, self._machine
        possible = machine.available_transitions
        label = wanted.label or next((label for number, label, *_ in possible if number == wanted.id), "")
        try:
            self._go(label)
        except RCLError:
            response.success = False  # as `rcl_lifecycle` answers
            return response
        response.success = self._on_transition(label)
        self._go("transition_success" if response.success else "transition_failure")
        return response

    def _go(self, label: str) -> None:
        before = self._machine.current_state
        number = self._machine.get_transition_by_label(label)
        self._machine.trigger_transition_by_label(label, False)
        event = import_type("lifecycle_msgs/msg/TransitionEvent", "msg")(timestamp=system_ns(self._system.kernel))
        event.transition.id, event.transition.label = number, label
        event.start_state.id, event.start_state.label = before
        event.goal_state.id, event.goal_state.label = self._machine.current_state
        self._events.publish(event)

    def _tell_state(self, request: Any, response: Any) -> Any:
        response.current_state.id, response.current_state.label = self._machine.current_state
        return response

    def _tell_states(self, request: Any, response: Any) -> Any:
        kind = import_type("lifecycle_msgs/msg/State", "msg")
        response.available_states = [kind(id=number, label=label) for number, label in self._machine.available_states]
        return response

    def _answer_with(self, transitions: Callable[[], Iterable[Transition]]) -> Callable[[Any, Any], Any]:
        def tell(request: Any, response: Any) -> Any:
            response.available_transitions = [_description(transition) for transition in transitions()]
            return response

        return tell


def _description(transition: Transition) -> Any:
    described = import_type("lifecycle_msgs/msg/TransitionDescription", "msg")()
    described.transition.id, described.transition.label = transition[:2]
    described.start_state.id, described.start_state.label = transition[2:4]
    described.goal_state.id, described.goal_state.label = transition[4:]
    return described
