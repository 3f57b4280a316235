"""Disturbances: what can go wrong in the world or at a port, beyond what the published methods generate.

A testbench declares them by name, as a `Disturbance`, `Delay`, `Drop` or `Duplicate`. A test has the line
`disturb NAME` where one happens: when the person comes to that line, `Run` applies it, and no time passes. The suites
bdi-random, rl, by-hand and pseudorandom never have such a line.

>>> from pytest_hricdv.generate.sampler import Uniform
>>> late = Delay("request", delay_s=Uniform(0.5, 2.0, "s"))
>>> late.parameters
{'delay_s': Uniform(low=0.5, high=2.0, unit='s', open_high=False)}
>>> late.message_fault({"delay_s": 0.75})
MessageFault(name='late', delays_s=(0.75,))
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv._base.message import nearest
from pytest_hricdv.generate.abstract import disturbance_line
from pytest_hricdv.generate.sampler import Sampler
from pytest_hricdv.runtime import MessageFault

__all__ = ["MessageDisturbance"]

Parameters = Mapping[str, float]

_NAME = re.compile(r"[A-Za-z_]\w*\Z", re.ASCII)  # one word: it is the argument of a command line


@dataclass(frozen=True)
class Disturbance:
    """A disturbance that the testbench applies itself, such as a leg that slips.

    Args:
        parameters: the ranges of its parameters, by name (with the unit in the name, as in `force_n`).
        handler: applies it: called with the object that was given to `Run.set_disturbance_target`, and the
            parameters by name. It may not block.
    """

    parameters: Mapping[str, Sampler] = field(default_factory=dict, hash=False)
    handler: Callable[[Any, Parameters], None] | None = None

    def faults(self, topics: Collection[str]) -> Iterator[str]:
        """Mistakes in its declaration, a sentence each. `topics`: of the testbench's messages."""
        if not callable(self.handler):
            yield f"handler is {self.handler!r}; expected a function of the world and the parameters"


class MessageDisturbance(ABC):
    """A disturbance of the delivery of a topic's next message; subclasses say which. It needs no handler."""

    topic: str

    @property
    @abstractmethod
    def parameters(self) -> Mapping[str, Sampler]:
        """The ranges of its parameters, by name."""

    @abstractmethod
    def message_fault(self, parameters: Parameters) -> MessageFault:
        """What happens to the message with these parameters."""

    def faults(self, topics: Collection[str]) -> Iterator[str]:
        """Mistakes in its declaration, a sentence each. `topics`: of the testbench's messages."""
        if self.topic not in topics:
            listed = ", ".join(sorted(topics)) or "none"
            yield f"topic {self.topic!r} is not a message{nearest(self.topic, topics)}; there are: {listed}"
        for name, sampler in self.parameters.items():
            if not isinstance(sampler, Sampler) or any(corner < 0 for corner in sampler.corners()):
                yield f"{name} is {sampler!r}; expected a Uniform or Constant of at least 0 s"


@dataclass(frozen=True)
class Drop(MessageDisturbance):
    """The next message of the topic, a name such as "human_ready", never arrives."""

    topic: str

    @property
    def parameters(self) -> Mapping[str, Sampler]:
        """None."""
        return {}

    def message_fault(self, parameters: Parameters) -> MessageFault:
        """It is never delivered."""
        return MessageFault("lost")


@dataclass(frozen=True)
class Delay(MessageDisturbance):
    """The next message of the topic arrives `delay_s` after it was sent."""

    topic: str
    delay_s: Sampler

    @property
    def parameters(self) -> Mapping[str, Sampler]:
        """`delay_s` (s)."""
        return {"delay_s": self.delay_s}

    def message_fault(self, parameters: Parameters) -> MessageFault:
        """It is delivered after the delay."""
        return MessageFault("late", (parameters["delay_s"],))


@dataclass(frozen=True)
class Duplicate(MessageDisturbance):
    """The next message of the topic arrives twice: when it was sent, and `delay_s` later."""

    topic: str
    delay_s: Sampler

    @property
    def parameters(self) -> Mapping[str, Sampler]:
        """`delay_s` (s)."""
        return {"delay_s": self.delay_s}

    def message_fault(self, parameters: Parameters) -> MessageFault:
        """It is delivered at once, and after the delay."""
        return MessageFault("doubled", (0.0, parameters["delay_s"]))


Disturbances = Mapping[str, Disturbance | MessageDisturbance]


def lines(disturbances: Disturbances) -> dict[str, Mapping[str, Sampler]]:
    """The command lines of disturbances, each with the ranges of its parameters."""
    return {disturbance_line(name): disturbance.parameters for name, disturbance in disturbances.items()}


def faults(disturbances: Disturbances, commands: Collection[str], topics: Collection[str]) -> Iterator[str]:
    """Mistakes in a testbench's disturbances, a sentence each.

    Args:
        disturbances: the testbench's disturbances.
        commands: those of its concretization.
        topics: the topics of its messages.
    """
    if not isinstance(disturbances, Mapping):
        yield f"disturbances is {disturbances!r}; expected a mapping of names to disturbances"
        return
    for name, disturbance in disturbances.items():
        if not isinstance(name, str) or not _NAME.match(name):
            yield f"disturbance {name!r}: expected a name of one word (letters, digits and '_')"
        elif (line := disturbance_line(name)) in commands:
            yield f"disturbance {name!r}: the concretization has the command '{line}', too; rename one"
        elif isinstance(disturbance, Disturbance | MessageDisturbance):
            yield from (f"disturbance {name!r}: {fault}" for fault in disturbance.faults(topics))
        else:
            yield f"disturbance {name!r} is {disturbance!r}; expected a Disturbance, Delay, Drop or Duplicate"
