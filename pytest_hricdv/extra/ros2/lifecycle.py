"""`LifecycleStateMachine` of a managed node (ROS 2 design article "Managed nodes"), numbered as in `lifecycle_msgs`.

`extension` gives it to `rclpy`, for lifecycle nodes under test; `ManagedNode` of the kit, a fake, has one, too.
"""

from __future__ import annotations

from enum import IntEnum

from pytest_hricdv.extra.ros2.contexts import GraphNode
from pytest_hricdv.extra.ros2.handles import Destroyable, RCLError
from pytest_hricdv.extra.ros2.qos import Profile
from pytest_hricdv.extra.ros2.services import ServiceServer
from pytest_hricdv.extra.ros2.topics import Publisher

Transition = tuple[int, str, int, str, int, str]
"""Number and label of a transition, of its start state, and of its end state."""

_STATES = {
    0: "unknown",
    1: "unconfigured",
    2: "inactive",
    3: "active",
    4: "finalized",
    10: "configuring",
    11: "cleaningup",
    12: "shuttingdown",
    13: "activating",
    14: "deactivating",
    15: "errorprocessing",
}
_NUMBERS = {label: number for number, label in _STATES.items()}

_COMMANDS = (
    (1, "configure", "unconfigured", "configuring"),
    (2, "cleanup", "inactive", "cleaningup"),
    (3, "activate", "inactive", "activating"),
    (4, "deactivate", "active", "deactivating"),
    (5, "shutdown", "unconfigured", "shuttingdown"),
    (6, "shutdown", "inactive", "shuttingdown"),
    (7, "shutdown", "active", "shuttingdown"),
)
"""The transitions of a node: number, label, start states, and the state in which its callback is called."""

_OUTCOMES = (
    (10, "configuring", ("inactive", "unconfigured", "errorprocessing")),
    (20, "cleaningup", ("unconfigured", "inactive", "errorprocessing")),
    (30, "activating", ("active", "inactive", "errorprocessing")),
    (40, "deactivating", ("inactive", "active", "errorprocessing")),
    (50, "shuttingdown", ("finalized", "finalized", "errorprocessing")),
    (60, "errorprocessing", ("unconfigured", "finalized", "finalized")),
)
"""Number of the first of three transitions, state of the callback, and states after success, failure and an error."""


class CallbackReturn(IntEnum):
    """Like `TransitionCallbackReturnType`: the numbers of `lifecycle_msgs/msg/Transition`."""

    SUCCESS = 97
    FAILURE = 98
    ERROR = 99

    def to_label(self) -> str:
        """The label of the transition that this outcome of a callback triggers."""
        return f"transition_{self.name.lower()}"


def _graph() -> tuple[Transition, ...]:
    def transition(number: int, label: str, start: str, goal: str) -> Transition:
        return number, label, _NUMBERS[start], start, _NUMBERS[goal], goal

    # In the order of rcl: the transitions to a state, then those from it.
    return tuple(
        row
        for first, state, goals in _OUTCOMES
        for row in (
            *(transition(*command) for command in _COMMANDS if command[3] == state),
            *(
                transition(first + offset, outcome.to_label(), state, goals[offset])
                for offset, outcome in enumerate(CallbackReturn)
            ),
        )
    )


_GRAPH = _graph()
_SERVICES = {
    "change_state": "ChangeState",
    "get_state": "GetState",
    "get_available_states": "GetAvailableStates",
    "get_available_transitions": "GetAvailableTransitions",
    "get_transition_graph": "GetAvailableTransitions",
}
"""Name of a service of a managed node -> its type in `lifecycle_msgs`."""


class LifecycleStateMachine(Destroyable):
    """Like `rcl_lifecycle_state_machine_t`, with its services if it is to have them. It begins as "unconfigured".

    Raises:
        TypeError: `enable_com_interface` is not a bool.
    """

    def __init__(self, node: GraphNode, enable_com_interface: bool) -> None:
        if not isinstance(enable_com_interface, bool):
            raise TypeError(f"enable_com_interface: expected a bool, got {enable_com_interface!r}")
        super().__init__(node.kernel)
        self._state = _NUMBERS["unconfigured"]
        self.initialized = True
        self._publisher: Publisher | None = None
        self._services: list[ServiceServer] = []
        if enable_com_interface:
            self._serve(node)

    def _serve(self, node: GraphNode) -> None:
        from lifecycle_msgs import msg, srv  # type: ignore[import-not-found, unused-ignore]

        self._messages = msg
        self._publisher = Publisher(node, msg.TransitionEvent, "~/transition_event", Profile())
        for name, kind in _SERVICES.items():
            service = ServiceServer(node, getattr(srv, kind), f"~/{name}", Profile())
            setattr(self, f"service_{name}", service)
            self._services.append(service)

    def destroy(self) -> None:
        self.initialized = False
        for service in self._services:
            service.destroy_when_not_in_use()
        if self._publisher is not None:
            self._publisher.destroy_when_not_in_use()

    @property
    def current_state(self) -> tuple[int, str]:
        """Number and label of the state."""
        return self._state, _STATES[self._state]

    @property
    def available_states(self) -> list[tuple[int, str]]:
        return list(_STATES.items())

    @property
    def transition_graph(self) -> list[Transition]:
        return list(_GRAPH)

    @property
    def available_transitions(self) -> list[Transition]:
        """The transitions from the present state."""
        return [transition for transition in _GRAPH if transition[2] == self._state]

    def get_transition_by_label(self, label: str) -> int:
        """The number of the transition with this label, from the present state. Raises RCLError if there is none."""
        return self._transition_with(1, label)[0]

    def trigger_transition_by_id(self, transition_id: int, publish_update: bool) -> None:
        """Go through a transition. Raises RCLError for one that does not begin in the present state."""
        self._go(self._transition_with(0, transition_id), publish_update)

    def trigger_transition_by_label(self, label: str, publish_update: bool) -> None:
        self._go(self._transition_with(1, label), publish_update)

    def _transition_with(self, column: int, value: int | str) -> Transition:
        transition = next((possible for possible in self.available_transitions if possible[column] == value), None)
        if transition is None:
            raise RCLError(f"Failed to trigger lifecycle transition: {_STATES[self._state]} has no {value!r}")
        return transition

    def _go(self, transition: Transition, publish_update: bool) -> None:
        _, _, start, start_label, goal, goal_label = transition
        self._state = goal
        if publish_update and self._publisher is not None:
            event = self._messages.TransitionEvent()  # rcl tells neither its time nor the transition
            event.start_state.id, event.start_state.label = start, start_label
            event.goal_state.id, event.goal_state.label = goal, goal_label
            self._publisher.publish(event)


for _name in _SERVICES:
    setattr(LifecycleStateMachine, f"service_{_name}", None)  # of a machine without services
