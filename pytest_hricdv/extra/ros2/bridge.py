"""The bridge from the ROS graph to the bus of a run, where messages are recorded and monitors see them.

`Ros2Overlay` makes one `Bridge` per run, and publishers, services and actions send through it. `vocabulary` returns the
names that requirements may use for the declared topics, services and actions; `Ros2Execution` calls it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.declarations.ros2 import Ros2, Ros2Error
from pytest_hricdv.extra.ros2.delivery import Arrival, Delivery, check_timing, is_timed, timing_fields
from pytest_hricdv.extra.ros2.interface_packages import provide_interfaces
from pytest_hricdv.extra.ros2.messages import RosMessage, fields_of, import_type, kinds_of
from pytest_hricdv.monitor.node import Kind
from pytest_hricdv.runtime import Bus
from pytest_hricdv.runtime.record import Value

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

ROSOUT = "rosout"
"""The name of the topic `/rosout` in requirements."""

_TERMINAL = "terminal_input"
"""The message that `run.terminal` records when keys are pressed."""


def vocabulary(declared: Ros2) -> dict[str, dict[str, Kind]]:
    """The vocabulary of a declared system: name in requirements -> its fields with their types.

    Raises:
        Ros2Error: a name or type does not exist, or two topics or services have the same name in requirements.
    """
    provide_interfaces(declared.interfaces)
    check_timing(declared)
    names: dict[str, dict[str, Kind]] = {
        ROSOUT: {"level": float, "name": str, "msg": str},
        _TERMINAL: {"terminal": str, "text": str},
    }
    for name, kinds in _kinds(declared):
        if name in names:
            raise Ros2Error(f"ros2: two topics or services are called {name!r} in requirements; rename one of them")
        names[name] = kinds
    return names


def _kinds(declared: Ros2) -> Iterator[tuple[str, dict[str, Kind]]]:
    for full_name, kind in declared.topics.items():
        if full_name == f"/{ROSOUT}":
            raise Ros2Error(f"ros2: requirements know /{ROSOUT} without its being declared; leave it out")
        yield requirement_name(full_name), kinds_of(import_type(kind, "msg"))
    for full_name, kind in declared.services.items():
        name, service = requirement_name(full_name), import_type(kind, "srv")
        yield f"{name}_request", kinds_of(service.Request)
        yield f"{name}_response", kinds_of(service.Response)
    for full_name, kind in declared.actions.items():
        name, action = requirement_name(full_name), import_type(kind, "action")
        yield f"{name}_goal", kinds_of(action.Goal)
        yield f"{name}_answer", {"accepted": bool}
        yield f"{name}_feedback", kinds_of(action.Feedback)
        yield f"{name}_cancel", {}
        yield f"{name}_result", {"status": float, **kinds_of(action.Result)}


def requirement_name(full_name: str) -> str:
    """The name of a topic, service or action in requirements.

    Raises:
        Ros2Error: the name is not full.
    """
    if not full_name.startswith("/") or len(full_name) < 2:
        raise Ros2Error(f'ros2: {full_name!r} is not a full name; expected one with "/" in front, such as "/arm/state"')
    return full_name[1:].replace("/", "_")


AT_ONCE = Arrival()
"""The default arrival of messages."""

_PARAMETER_EVENTS = "/parameter_events"


@dataclass(frozen=True)
class Route:
    """The record of a topic, or of one direction of a service: its name, and the fields of a message."""

    name: str
    fields: Callable[[Any], Mapping[str, Value]]


def _result(response: Any) -> Mapping[str, Value]:
    return {"status": response.status, **fields_of(response.result)}


def _log_fields(entry: Any) -> Mapping[str, Value]:
    """Without the location of the log call: files and lines are not behaviour."""
    return {"level": entry.level, "name": entry.name, "msg": entry.msg}


class Bridge:
    """Carries messages of ROS 2 over the bus of a run: there they are recorded, and may be lost, late or doubled.

    Topics and services that the testbench does not declare are recorded, too, except hidden ones and
    `/parameter_events`.
    """

    def __init__(self, bus: Bus, declared: Ros2, seed: int = 0) -> None:
        self._bus = bus
        self.delivery = Delivery(declared, seed, lambda: bus.kernel.now_s) if is_timed(declared) else None
        if self.delivery is not None:
            fields = timing_fields(declared)
            bus.recorder.disturbance(bus.kernel.now_s, "test", "timing of the middleware", fields)
        self._types = {**declared.topics, **declared.services}
        self._used: dict[tuple[int, str], tuple[str, str]] = {}
        """Domain and full name -> the node that uses it first, and its type."""
        self._full_names: dict[str, tuple[str, str]] = {}
        self._routes: dict[tuple[str, str], Route | None] = {(f"/{ROSOUT}", ""): Route(ROSOUT, _log_fields)}
        for full_name, kind in declared.actions.items():
            self._add_action(full_name, kind)

    def _add_action(self, full_name: str, kind: str) -> None:
        name, of = requirement_name(full_name), f"{full_name}/_action"
        self._types |= {
            f"{of}/send_goal": f"{kind}_SendGoal",
            f"{of}/get_result": f"{kind}_GetResult",
            f"{of}/feedback": f"{kind}_FeedbackMessage",
        }
        self._routes |= {
            (f"{of}/send_goal", "request"): Route(f"{name}_goal", lambda request: fields_of(request.goal)),
            (f"{of}/send_goal", "response"): Route(f"{name}_answer", lambda answer: {"accepted": answer.accepted}),
            (f"{of}/feedback", ""): Route(f"{name}_feedback", lambda message: fields_of(message.feedback)),
            (f"{of}/cancel_goal", "request"): Route(f"{name}_cancel", lambda request: {}),
            (f"{of}/get_result", "response"): Route(f"{name}_result", _result),
        }

    def admit(self, domain: int, node: str, full_name: str, kind: str) -> None:
        """Check the type with which a node uses a topic or service.

        Raises:
            Ros2Error: the testbench declares it with another one, or another node of the domain uses it so: between
                the two, no message would ever arrive.
        """
        declared = self._types.get(full_name, kind)
        if declared != kind:
            raise Ros2Error(f"{full_name}: {node} uses it with the type {kind}, but the testbench declares {declared}")
        other, first = self._used.setdefault((domain, full_name), (node, kind))
        if first != kind:
            raise Ros2Error(f"{full_name}: {node} uses it with the type {kind}, but {other} with {first}")

    def carry(
        self,
        node: str,
        full_name: str,
        direction: str,
        message: Any,
        deliver: Callable[[], None],
        is_heard: Callable[[], bool],
        reliable: Callable[[], str] = lambda: "",
    ) -> None:
        """Record a message, which must not change any more, and deliver it.

        Args:
            node: the full name of the sender.
            direction: "request" or "response" of a service, "" of a topic.
            reliable: between whom it is carried reliably, in words; empty if it may be lost.
        """
        key = (full_name, direction)
        if key not in self._routes:
            self._routes[key] = self._route_of(full_name, direction)
        route = self._routes[key]
        arrival = AT_ONCE if self.delivery is None else self.delivery.arrival(node, full_name, direction, reliable)
        if route is None:
            self._deliver_hidden(full_name, arrival, deliver)
            return
        source = RosMessage(full_name, direction, message)
        fields = route.fields(message)
        self._bus.carry(node[1:], route.name, fields, deliver, is_heard, source, arrival.delay_s, arrival.is_lost)

    def _deliver_hidden(self, full_name: str, arrival: Arrival, deliver: Callable[[], None]) -> None:
        """Deliver an unrecorded message."""
        kernel = self._bus.kernel

        def later() -> None:
            kernel.sleep(arrival.delay_s)
            deliver()

        if arrival.delay_s and not arrival.is_lost:
            kernel.spawn(f"{full_name} on its way", later)
        elif not arrival.is_lost:
            deliver()

    def _route_of(self, full_name: str, direction: str) -> Route | None:
        """The route of a topic or service that belongs to no declared action."""
        if "/_" in full_name or full_name == _PARAMETER_EVENTS:
            return None
        name = requirement_name(full_name) + (f"_{direction}" if direction else "")
        if name in self._bus.topics:
            raise Ros2Error(
                f"{full_name} is called {name!r} in the record, as a message of the bus is; rename one of them"
            )
        other = self._full_names.setdefault(name, (full_name, direction))
        if other != (full_name, direction):
            raise Ros2Error(f"{full_name} and {other[0]} are both called {name!r} in the record; rename one of them")
        return Route(name, fields_of)
