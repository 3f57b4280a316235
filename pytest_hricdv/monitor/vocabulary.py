"""What a requirement may speak of: the signals and messages of a testbench, with their types."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

Kind = type[bool] | type[float]

_TEMPORAL = ("always", "eventually", "until", "since", "once", "historically", "previously")
KEYWORDS = frozenset((*_TEMPORAL, "on", "rise", "fall", "not", "hysteresis", "for", "inf"))
IDENTIFIER = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True)
class Vocabulary:
    """The names that requirements are written over.

    Attributes:
        signals: name -> `bool` or `float`; piecewise constant in time.
        messages: topic -> fields, each field -> `bool` or `float`.

    Raises:
        ValueError: a name that a formula could not contain (no identifier, or a keyword), or another type.

    >>> vocabulary = Vocabulary(signals={"arm_speed": float}, messages={"reading": {"gaze": bool}, "request": {}})
    >>> vocabulary.kind("reading.gaze")
    <class 'bool'>
    """

    signals: Mapping[str, Kind] = field(default_factory=dict)
    messages: Mapping[str, Mapping[str, Kind]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in self.signals.items():
            _check(f"signal {name!r}", name, kind)
        for topic, fields in self.messages.items():
            _check(f"topic {topic!r}", topic, bool)
            for name, kind in fields.items():
                _check(f"field {name!r} of topic {topic!r}", name, kind)

    def kind(self, name: str) -> Kind | None:
        """The type of a signal or of a field written `topic.field`; None if there is none of that name."""
        topic, dot, member = name.partition(".")
        return self.messages.get(topic, {}).get(member) if dot else self.signals.get(name)

    def names(self) -> list[str]:
        """All signals, and all fields as `topic.field`."""
        return [*self.signals, *(f"{topic}.{name}" for topic, fields in self.messages.items() for name in fields)]


def _check(what: str, name: str, kind: Kind) -> None:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError(f"{what}: a name is made of letters, digits and _ and starts with no digit")
    if name in KEYWORDS:
        raise ValueError(f"{what}: this is a keyword of the requirement language; choose another name")
    if kind is not bool and kind is not float:
        raise ValueError(f"{what}: expected the type bool or float, got {kind!r}")
