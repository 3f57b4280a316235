"""What a person does in one run: the actions of the test in order, and how their messages reach the robot."""

from __future__ import annotations

import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.runtime import text_of

TIMES = ("after_s", "again_s")
"""Parameters of each command: how long a person waits before it, and before the same again."""


@dataclass(frozen=True, init=False)
class Say:
    """A message that a person says.

    Args:
        kind: its class.
        values: of its fields: a value, or a range from which a number is drawn.

    >>> from dataclasses import dataclass
    >>> from pytest_hricdv.testbench import Uniform
    >>> @dataclass
    ... class Order:
    ...     item: str
    ...     cups: int
    >>> Say(Order, item="tea", cups=Uniform(1, 3)).message({"cups": 2.2})
    Order(item='tea', cups=2)
    """

    kind: type[Any]
    fixed: Mapping[str, Any]
    drawn: Mapping[str, Sampler]

    def __init__(self, kind: type[Any], /, **values: Any) -> None:
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "fixed", {k: v for k, v in values.items() if not isinstance(v, Sampler)})
        object.__setattr__(self, "drawn", {k: v for k, v in values.items() if isinstance(v, Sampler)})

    @property
    def parameters(self) -> dict[str, Sampler]:
        """The numbers of a command, for `Concretization.commands`."""
        return {_parameter(name): sampler for name, sampler in self.drawn.items()}

    def message(self, numbers: Mapping[str, Any]) -> Any:
        """The message, with the numbers of a test."""
        whole = _whole_numbers(self.kind)
        drawn = {name: numbers[_parameter(name)] for name in self.drawn}
        return self.kind(**self.fixed, **{name: round(v) if name in whole else v for name, v in drawn.items()})


def _parameter(field: str) -> str:
    return f"{field}_" if field in TIMES else field


def _whole_numbers(kind: type[Any]) -> frozenset[str]:
    """The fields that are integers."""
    try:
        hints = typing.get_type_hints(kind)
    except Exception:  # an annotation that names nothing
        hints = getattr(kind, "__annotations__", {})
    return frozenset(name for name, hint in hints.items() if hint in (int, "int"))


def member(kind: Any, text: str) -> Any:
    """The member of an enumeration that a record calls so. Raises ValueError if there is none."""
    for value in kind:
        if text_of(value) == text:
            return value
    raise ValueError(f"{kind.__name__} has no member {text!r}")


@dataclass(frozen=True)
class MethodCall:
    """A message gets to the robot as the call of a method of its object, or of a function.

    Args:
        method: its name; of a function, its module and name, as "robot.arm:on_order".
        arguments: what it is called with, made of the message.
    """

    method: str
    arguments: Callable[[Any], tuple[Any, ...]] = lambda _: ()


@dataclass(frozen=True)
class CallbackCall:
    """A message that the robot gets as the call of a callback that it has passed to a port.

    Args:
        port: the port and its method or attribute, as "driver.on_button"; with a text among the arguments of the
            method behind it, as "client.subscribe orders".
        arguments: what it is called with, made of the message.
    """

    port: str
    arguments: Callable[[Any], tuple[Any, ...]] = lambda _: ()


LOOKS_EACH_S = 0.25
"""The period (s) at which a person checks for an answer."""


@dataclass(frozen=True)
class Manners:
    """How people wait.

    Args:
        answer_s: for an answer (s).
        stays_s: most time until the robot says nothing more (s).
    """

    answer_s: float = 30.0
    stays_s: float = 150.0


@dataclass
class Visit:
    """A person who acts in one run.

    Args:
        border: of the code.
        name: of the person.
        says: command -> what is said.
        answers: classes of messages that answer what was said.
        hears: all classes of messages of the robot.
        senses: command, or its word, that sets what a device returns -> "port.name", and the text, if it is one.
        manners: how the person waits.
    """

    border: RunBorder
    name: str
    says: dict[str, Say]
    answers: tuple[type[Any], ...]
    hears: tuple[type[Any], ...]
    senses: dict[str, tuple[str, str | None]]
    manners: Manners
    manner: str = "in_time"
    """The manner of the last message."""

    def act(self) -> None:
        """The body of the person's node."""
        run = self.border.run
        bus = run.bus.port(self.name)
        answers = [bus.subscribe(kind) for kind in self.answers]
        hears = [bus.subscribe(kind) for kind in self.hears]
        run.kernel.sleep(LOOKS_EACH_S)
        for action in run.actions():
            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            if run.ending is not None:
                return  # the robot has ended: only earlier questions are waited for
            what, _, how = action.command.rpartition(" ")
            if action.command == "wait_answer":
                self._wait_answer(answers)
            elif action.command == "wait_quiet":
                self._wait_quiet(hears)
            elif action.command in self.senses or what in self.senses:
                name, text = self.senses.get(action.command) or self.senses[what]
                for answer in answers:
                    answer.clear()
                self.border.sense(name, action.parameters.get("value", how == "yes") if text is None else text)
            elif what in self.says:
                self.manner = how
                for answer in answers:
                    answer.clear()
                bus.publish(self.says[what].message(action.parameters))
                if how == "twice":
                    run.kernel.sleep(float(action.parameters["again_s"]))
                    if run.ending is None:
                        bus.publish(self.says[what].message(action.parameters))
        self.border.record("person_is_there", False)
        run.kernel.stop("the person has left")

    def _wait_answer(self, answers: list[Any]) -> None:
        kernel = self.border.run.kernel
        ends_s = kernel.now_s + (self.manners.answer_s if answers else LOOKS_EACH_S)
        while kernel.now_s < ends_s and all(answer.poll() is None for answer in answers):
            kernel.sleep(LOOKS_EACH_S)

    def _wait_quiet(self, hears: list[Any]) -> None:
        """Leave when nothing was said for as long as one waits for an answer."""
        kernel = self.border.run.kernel
        ends_s, quiet_s = kernel.now_s + self.manners.stays_s, kernel.now_s
        while kernel.now_s < min(ends_s, quiet_s + self.manners.answer_s):
            if [message for inbox in hears for message in iter(inbox.poll, None)]:
                quiet_s = kernel.now_s
            kernel.sleep(LOOKS_EACH_S)
