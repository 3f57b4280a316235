"""Managed nodes: transitions, errors in them, what is published of them, publishers that are switched."""

from __future__ import annotations

from typing import Any

import rclpy
from lifecycle_msgs.msg import State, Transition, TransitionEvent
from lifecycle_msgs.srv import ChangeState, GetAvailableStates, GetAvailableTransitions, GetState
from rclpy.lifecycle import LifecycleNode, TransitionCallbackReturn
from rclpy.node import Node
from std_msgs.msg import Int32

from tests.extra.ros2.differential.common import (
    PATIENCE_S,
    Log,
    System,
    alone,
    answered,
    raised,
    serving,
    together,
    until,
)


class Managed(LifecycleNode):
    """Logs its transitions; it cannot be activated the first time."""

    def __init__(self, log: Log) -> None:
        super().__init__("managed")
        self._log, self._tries = log, 0

    def on_configure(self, state: Any) -> Any:
        self._log("transition", ["configure", state.label])
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> Any:
        self._tries += 1
        self._log("transition", ["activate", state.label])
        return TransitionCallbackReturn.SUCCESS if self._tries > 1 else TransitionCallbackReturn.FAILURE


def managing(log: Log) -> None:
    rclpy.init()
    node = Node("manager")
    change, state = (
        node.create_client(ChangeState, "managed/change_state"),
        node.create_client(GetState, "managed/get_state"),
    )
    change.wait_for_service(timeout_sec=PATIENCE_S)
    state.wait_for_service(timeout_sec=PATIENCE_S)
    first, second = Transition.TRANSITION_CONFIGURE, Transition.TRANSITION_ACTIVATE
    # None that its state does not have: with jazzy the node fails, later ones refuse.
    for transition in (first, second, second, Transition.TRANSITION_DEACTIVATE):
        request = ChangeState.Request(transition=Transition(id=transition))
        log("done", answered(node, change.call_async(request)).success)
        log("state", answered(node, state.call_async(GetState.Request())).current_state.label)


class Failing(LifecycleNode):
    """Fails in its transitions, in all ways, and may recover."""

    def __init__(self, log: Log, recovery: TransitionCallbackReturn) -> None:
        super().__init__("failing")
        self._log, self._recovery = log, recovery

    def on_configure(self, state: Any) -> Any:
        return TransitionCallbackReturn.SUCCESS

    def on_activate(self, state: Any) -> Any:
        raise ValueError("cannot")

    def on_cleanup(self, state: Any) -> Any:
        return TransitionCallbackReturn.ERROR

    def on_error(self, state: Any) -> Any:
        self._log("error", state.label)
        return self._recovery


def _label(node: Any) -> str:
    return str(node._state_machine.current_state[1])


def failing(log: Log) -> None:
    """Errors in callbacks, with and without a recovery, by the methods of the node."""
    rclpy.init()
    for recovery in (TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE):
        for second in ("trigger_activate", "trigger_cleanup"):
            node = Failing(log, recovery)
            log("result", [second, recovery.name, node.trigger_configure().name, getattr(node, second)().name])
            log("state", _label(node))
            node.destroy_node()


def published(log: Log) -> None:
    """The topic of transitions, and the services that tell states and transitions."""
    rclpy.init()
    node = LifecycleNode("managed")
    watcher = Node("watcher")
    heard: list[Any] = []
    watcher.create_subscription(TransitionEvent, "managed/transition_event", heard.append, 100)
    spun = together(node, watcher)
    until(spun, lambda: watcher.count_publishers("managed/transition_event") == 1)
    states = watcher.create_client(GetAvailableStates, "managed/get_available_states")
    transitions = watcher.create_client(GetAvailableTransitions, "managed/get_available_transitions")
    graph = watcher.create_client(GetAvailableTransitions, "managed/get_transition_graph")
    change = watcher.create_client(ChangeState, "managed/change_state")
    for client in (states, transitions, graph, change):
        client.wait_for_service(timeout_sec=PATIENCE_S)
    log(
        "states",
        [each.label for each in answered(spun, states.call_async(GetAvailableStates.Request())).available_states],
    )
    every = answered(spun, graph.call_async(GetAvailableTransitions.Request())).available_transitions
    log("graph", [[each.transition.label, each.start_state.label, each.goal_state.label] for each in every])
    for label in ("configure", "activate", "deactivate", "cleanup", "shutdown"):
        possible = answered(spun, transitions.call_async(GetAvailableTransitions.Request())).available_transitions
        log("possible", [each.transition.label for each in possible])
        request = ChangeState.Request(transition=Transition(label=label))
        log("changed", [label, answered(spun, change.call_async(request)).success])
    until(spun, lambda: len(heard) >= 10)
    for event in heard:
        log("events", [event.transition.label, event.start_state.label, event.goal_state.label])
    log("finalized", _label(node) == "finalized" and State.PRIMARY_STATE_FINALIZED == 4)


def switched(log: Log) -> None:
    """A lifecycle publisher is silent while its node is not active; subscriptions and timers go on."""
    rclpy.init()
    node, listener, heard, ticks = LifecycleNode("managed"), Node("listener"), [], []
    publisher = node.create_lifecycle_publisher(Int32, "numbers", 10)
    listener.create_subscription(Int32, "numbers", lambda each: heard.append(each.data), 10)
    node.create_timer(0.02, lambda: ticks.append(1))
    spun = together(node, listener)
    until(spun, lambda: publisher.get_subscription_count() == 1)
    for number, transition in enumerate(("configure", "activate", "deactivate", "activate", "deactivate", "cleanup")):
        publisher.publish(Int32(data=number))
        log("result", [transition, getattr(node, f"trigger_{transition}")().name, publisher.is_activated])
    until(spun, lambda: len(heard) == 2 and bool(ticks))
    log("numbers", heard)
    log("wrong", raised(node.trigger_deactivate))
    log("state", _label(node))


SYSTEMS = {
    "managed node": System({"manager": managing}, {"managed": serving(Managed)}),
    "errors of a managed node": alone(failing),
    "transitions": alone(published),
    "lifecycle publisher": alone(switched),
}
