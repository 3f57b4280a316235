"""A requirement, and the vocabulary of signals and messages that requirements are written in."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from pytest_hricdv.monitor.formula import Formula

Kind = type[bool] | type[float]

_TEMPORAL = ("always", "eventually", "until", "since", "once", "historically", "previously")
KEYWORDS = frozenset((*_TEMPORAL, "on", "rise", "fall", "not", "hysteresis", "for", "inf"))
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True)
class Vocabulary:
    """The names that formulas may use, with their types.

    Attributes:
        signals: name -> `bool` or `float`; piecewise constant in time.
        messages: topic -> fields, each field -> `bool` or `float`.

    Raises:
        ValueError: a name that a formula cannot contain (no identifier, or a keyword), or another type.

    >>> vocabulary = Vocabulary(signals={"arm_speed": float}, messages={"reading": {"gaze": bool}, "request": {}})
    >>> vocabulary.kind("reading.gaze")
    <class 'bool'>
    """

    signals: Mapping[str, Kind] = field(default_factory=dict)
    messages: Mapping[str, Mapping[str, Kind]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in self.signals.items():
            _check_declaration(f"signal {name!r}", name, kind)
        for topic, fields in self.messages.items():
            _check_declaration(f"topic {topic!r}", topic, bool)
            for name, kind in fields.items():
                _check_declaration(f"field {name!r} of topic {topic!r}", name, kind)

    def kind(self, name: str) -> Kind | None:
        """The type of a signal, or of a field written as `topic.field`; None for an unknown name."""
        topic, dot, member = name.partition(".")
        return self.messages.get(topic, {}).get(member) if dot else self.signals.get(name)

    def names(self) -> list[str]:
        """All signals, and all fields as `topic.field`."""
        return [*self.signals, *(f"{topic}.{name}" for topic, fields in self.messages.items() for name in fields)]


def _check_declaration(what: str, name: str, kind: Kind) -> None:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError(f"{what}: a name consists of letters, digits and _, and does not start with a digit")
    if name in KEYWORDS:
        raise ValueError(f"{what}: this is a keyword of the requirement language; choose another name")
    if kind is not bool and kind is not float:
        raise ValueError(f"{what}: expected the type bool or float, got {kind!r}")


@dataclass(frozen=True)
class Requirement:
    """One requirement.

    Attributes:
        id: the name of its table in the file, such as `R1`.
        title: the requirement in one sentence.
        source: where it comes from (a clause of a standard, a paper); may be empty.
        text: the formula as written, for reports.
        formula: the formula as data.
        shows: numeric signals that a violation reports in addition to those that the formula reads: while a violation
            lasts, the value with the largest absolute value. They have no effect on verdicts.
    """

    id: str
    title: str
    source: str
    text: str
    formula: Formula
    shows: tuple[str, ...] = ()
