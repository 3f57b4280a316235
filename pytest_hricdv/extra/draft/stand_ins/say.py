"""What a person can say to a robot, and how it gets there."""

from __future__ import annotations

import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

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
    for each in kind:
        if text_of(each) == text:
            return each
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
    """A message gets to the robot as the call of a function that it has handed to a port.

    Args:
        port: the port and its method or attribute, as "driver.on_button"; with a text among the arguments of the
            method behind it, as "client.subscribe orders".
        arguments: what it is called with, made of the message.
    """

    port: str
    arguments: Callable[[Any], tuple[Any, ...]] = lambda _: ()
