"""`NodeDriver` of drafted testbenches: starts a ROS 2 node, answers its requests, and lets a person talk to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import signal_name
from pytest_hricdv.extra.draft.stand_ins.visit import Array, Manners, Say, Visit
from pytest_hricdv.testbench import Outcome, Ros2, RosNode, Run

__tracebackhide__ = True  # a failing test shows the frames of the code; pytest's --full-trace shows these, too

FAR = 10.0
"""Signal of an array before a person has sent it; if it has distances, nobody is near."""


@dataclass(frozen=True)
class NodeDriver:
    """Runs a node as the robot of a testbench; give `driver.run`, `driver.signals` and `driver.ros2()` to it.

    Args:
        entry: "package.module:function", or a class of nodes.
        publishers: what the node publishes: topic -> type.
        subscriptions: topics that a person publishes.
        services: services that a person calls. actions: actions that a person starts.
        clients: services that others answer with an empty response. action_clients: actions in which others succeed.
        parameters: the node's parameters.
        says: command -> what a person says by it.
        person: name of the person.
        manners: how the person waits.
        limit_s: no run takes longer (s of simulated time).
    """

    entry: str
    publishers: Mapping[str, str] = field(default_factory=dict)
    subscriptions: Mapping[str, str] = field(default_factory=dict)
    services: Mapping[str, str] = field(default_factory=dict)
    actions: Mapping[str, str] = field(default_factory=dict)
    clients: Mapping[str, str] = field(default_factory=dict)
    action_clients: Mapping[str, str] = field(default_factory=dict)
    parameters: Mapping[str, Any] = field(default_factory=dict)
    says: Mapping[str, Say] = field(default_factory=dict)
    person: str = "person"
    manners: Manners = field(default_factory=Manners)
    limit_s: float = 900.0

    def ros2(self, interfaces: tuple[str | Path, ...] = (), packages: tuple[str, ...] = ()) -> Ros2:
        """The declarations for `Testbench.ros2`, with some of its arguments."""
        topics = {**self.subscriptions, **self.publishers}
        services, actions = {**self.clients, **self.services}, {**self.action_clients, **self.actions}
        return Ros2(topics, services, actions, packages, interfaces=interfaces)

    @property
    def signals(self) -> dict[str, type[bool | float | str]]:
        """The recorded signals, for `Testbench.signals`: who is present, and the numbers in arrays.

        Of an array, the record has the length.
        """
        return {"person_is_there": bool, **{signal: float for say in self.says.values() for signal, _ in _arrays(say)}}

    def run(self, run: Run) -> Outcome:
        """One run of one test, for `Testbench.run`."""
        ros = run.ros2(RosNode(entry=self.entry, parameters=[dict(self.parameters)]))
        others, person = ros.node("others"), ros.node(self.person)
        for name, kind in self.clients.items():
            if name not in self.services:
                others.serve(name, kind, lambda request, response: response)
        for name, kind in self.action_clients.items():
            if name not in self.actions:
                others.serve_action(name, kind, lambda goal: goal.succeed())
        publishers = {name: person.publisher(name, kind) for name, kind in self.subscriptions.items()}
        callers = {name: person.client(name, kind) for name, kind in self.services.items()}
        callers |= {name: person.action(name, kind) for name, kind in self.actions.items()}
        answers = [person.subscribe(name, kind) for name, kind in self.publishers.items()]

        def say(said: Say, numbers: Mapping[str, Any]) -> None:
            values = said.values(numbers)
            for signal, name in _arrays(said):
                run.recorder.signal(run.kernel.now_s, signal, values[name][0])
            if said.kind in publishers:
                publishers[said.kind].publish(_fill(self.subscriptions[said.kind], "", values))
                return
            kind, part = (self.services, "Request") if said.kind in self.services else (self.actions, "Goal")
            message = _fill(kind[said.kind], part, values)
            callers[said.kind].call(self.manners.answer_s, **{name: getattr(message, name) for name in values})

        for signal, sort in self.signals.items():
            run.recorder.signal(0.0, signal, FAR if sort is float else True)
        run.kernel.spawn(self.person, Visit(run, self.says, say, answers, answers, self.manners).act)
        return Outcome(run.go(self.limit_s))


def _arrays(say: Say) -> Iterator[tuple[str, str]]:
    """The signal of each array in what is said, and its field."""
    for name, value in say.drawn.items():
        if isinstance(value, Array):
            yield signal_name(f"{say.kind.strip('/')}_{name}"), name


def _fill(kind: str, part: str, values: Mapping[str, Any]) -> Any:
    """A message of a type such as "std_msgs/msg/Bool", or a part of one; fields of messages in it have paths."""
    package, folder, name = kind.split("/")
    made = getattr(import_module(f"{package}.{folder}"), name)
    message = getattr(made, part)() if part else made()
    for path, value in values.items():
        *owners, last = path.split(".")
        inner = message
        for owner in owners:
            inner = getattr(inner, owner)
        setattr(inner, last, round(value) if type(getattr(inner, last)) is int else value)
    return message
