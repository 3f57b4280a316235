"""`Visit`: a person who does the actions of a test in one run; `Say` and others: how messages reach the robot."""

from __future__ import annotations

import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import text_of

TIMES = ("after_s", "again_s")
"""Parameters of each command: how long a person waits before it, and before repeating it."""


@dataclass(frozen=True)
class Array:
    """An array whose elements all have one number, drawn for the test.

    Args:
        number: its range.
        length: the length of the array; the default is that of a scan with a ray each ten degrees.
    """

    number: Sampler
    length: int = 36


@dataclass(frozen=True, init=False)
class Say:
    """A message that a person says.

    Args:
        kind: its class; of a node, the name of the topic, service or action.
        values: field -> a value, or a range from which a number is drawn.

    >>> from dataclasses import dataclass
    >>> from pytest_hricdv.testbench import Uniform
    >>> @dataclass
    ... class Order:
    ...     item: str
    ...     cups: int
    >>> Say(Order, item="tea", cups=Uniform(1, 3)).message({"cups": 2.2})
    Order(item='tea', cups=2)
    """

    kind: Any
    fixed: Mapping[str, Any]
    drawn: Mapping[str, Sampler | Array]

    def __init__(self, kind: Any, /, **values: Any) -> None:
        object.__setattr__(self, "kind", kind)
        object.__setattr__(self, "fixed", {k: v for k, v in values.items() if not isinstance(v, Sampler | Array)})
        object.__setattr__(self, "drawn", {k: v for k, v in values.items() if isinstance(v, Sampler | Array)})

    @property
    def parameters(self) -> dict[str, Sampler]:
        """The numbers of a command, for `Concretization.commands`."""
        return {_parameter(name): value.number if isinstance(value, Array) else value
                for name, value in self.drawn.items()}  # fmt: skip

    def values(self, numbers: Mapping[str, Any]) -> dict[str, Any]:
        """The fields, with the numbers of a test."""
        values = dict(self.fixed)
        for name, value in self.drawn.items():
            number = numbers[_parameter(name)]
            values[name] = [number] * value.length if isinstance(value, Array) else number
        return values

    def message(self, numbers: Mapping[str, Any]) -> Any:
        """The message, with the numbers of a test."""
        whole = _whole_numbers(self.kind) & {*self.drawn}
        return self.kind(**{name: round(v) if name in whole else v for name, v in self.values(numbers).items()})


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
        run: the test's run.
        says: command -> what is said.
        say: says it, with the numbers of the test.
        answers: inboxes of messages that answer what was said.
        hears: inboxes of all messages of the robot.
        senses: command, or its word, that sets what a device returns -> "port.name", and the text, if it is one.
        sense: lets a device return a value.
        manners: how the person waits.
    """

    run: Run
    says: Mapping[str, Say]
    say: Callable[[Say, Mapping[str, Any]], None]
    answers: Sequence[Any]
    hears: Sequence[Any]
    manners: Manners
    senses: Mapping[str, tuple[str, str | None]] = field(default_factory=dict)
    sense: Callable[[str, Any], None] = lambda name, value: None
    manner: str = "in_time"
    """The manner of the last message."""

    def act(self) -> None:
        """The body of the person's node."""
        kernel = self.run.kernel
        kernel.sleep(LOOKS_EACH_S)
        for action in self.run.actions():
            kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            if self.run.ending is not None:
                return  # the robot has ended: only earlier questions are waited for
            self._do(action.command, action.parameters)
        self.run.recorder.signal(kernel.now_s, "person_is_there", False)
        kernel.stop("the person has left")

    def _do(self, command: str, parameters: Mapping[str, Any]) -> None:
        what, _, how = command.rpartition(" ")
        if command == "wait_answer":
            self._wait_answer()
        elif command == "wait_quiet":
            self._wait_quiet()
        elif command in self.senses or what in self.senses:
            name, text = self.senses.get(command) or self.senses[what]
            self._forget()
            self.sense(name, parameters.get("value", how == "yes") if text is None else text)
        elif what in self.says:
            self.manner = how
            self._forget()
            self.say(self.says[what], parameters)
            if how == "twice":
                self.run.kernel.sleep(float(parameters["again_s"]))
                if self.run.ending is None:
                    self.say(self.says[what], parameters)

    def _forget(self) -> None:
        """What was said before is not an answer."""
        for answer in self.answers:
            _take_all(answer)

    def _wait_answer(self) -> None:
        kernel = self.run.kernel
        ends_s = kernel.now_s + (self.manners.answer_s if self.answers else LOOKS_EACH_S)
        while kernel.now_s < ends_s and all(answer.poll() is None for answer in self.answers):
            kernel.sleep(LOOKS_EACH_S)

    def _wait_quiet(self) -> None:
        """Leave when nothing was said for as long as one waits for an answer."""
        kernel = self.run.kernel
        ends_s, quiet_s = kernel.now_s + self.manners.stays_s, kernel.now_s
        while kernel.now_s < min(ends_s, quiet_s + self.manners.answer_s):
            if [message for inbox in self.hears for message in _take_all(inbox)]:
                quiet_s = kernel.now_s
            kernel.sleep(LOOKS_EACH_S)


def _take_all(inbox: Any) -> list[Any]:
    return list(iter(inbox.poll, None))
