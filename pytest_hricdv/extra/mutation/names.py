"""Meanings of names in the code under test: constants of one kind, members of enumerations, opposite commands."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import libcst as cst

from pytest_hricdv.extra.mutation.source import Source, last_name, string_value

_OPPOSITES = (
    ("open", "close"),
    ("grasp", "release"),
    ("grip", "release"),
    ("start", "stop"),
    ("enable", "disable"),
    ("lock", "unlock"),
    ("attach", "detach"),
    ("raise", "lower"),
    ("up", "down"),
    ("left", "right"),
    ("push", "pull"),
)
OPPOSITES: Mapping[str, tuple[str, ...]] = {
    word: tuple(b if word == a else a for a, b in _OPPOSITES if word in (a, b)) for pair in _OPPOSITES for word in pair
}
"""Command -> the commands that do the contrary."""

_TIME_OR_SPEED = re.compile(
    r"(?:^|_)(?:timeout|delay|period|interval|duration|patience|speed|velocity|acceleration|rate|seconds|secs?|hz|ms|us)"
    r"$|_s$"
)
_ENUMERATIONS = frozenset({"Enum", "IntEnum", "StrEnum", "Flag", "IntFlag"})


def is_time_or_speed(name: str) -> bool:
    """Whether a name says that it is a time or a speed: `settle_s`, `max_speed_rad_s`, `timeout`."""
    return _TIME_OR_SPEED.search(name) is not None


@dataclass(frozen=True)
class Names:
    """Names of all files of the code under test.

    Args:
        constants: string constant -> the texts of the others that its file defines, the one that follows it first.
        members: enumeration -> its members, in order.
        assigned: attribute or variable -> the string literals that are assigned to it.
        commands: (receiver, method) of all calls of a method.
    """

    constants: Mapping[str, Sequence[str]] = field(default_factory=dict)
    members: Mapping[str, Sequence[str]] = field(default_factory=dict)
    assigned: Mapping[str, Sequence[str]] = field(default_factory=dict)
    commands: frozenset[tuple[str, str]] = frozenset()

    @classmethod
    def of(cls, sources: Iterable[Source]) -> Names:
        """The names of these files."""
        constants: dict[str, list[str]] = {}
        members: dict[str, list[str]] = {}
        assigned: defaultdict[str, list[str]] = defaultdict(list)
        commands = set()
        for source in sources:
            constants |= _others(dict(_string_constants(source.module)))
            for node, _ in source.places():
                if isinstance(node, cst.ClassDef) and any(
                    last_name(base.value) in _ENUMERATIONS for base in node.bases
                ):
                    members[node.name.value] = [name for name, _ in _assignments(node.body.body)]
                elif isinstance(node, cst.Assign) and (text := string_value(node.value)) is not None:
                    assigned[last_name(node.targets[0].target)].append(text)
                elif isinstance(node, cst.Call) and isinstance(node.func, cst.Attribute):
                    commands.add((last_name(node.func.value), node.func.attr.value))
        return cls(constants, members, dict(assigned), frozenset(commands))


def next_other(item: str, items: Sequence[str]) -> str | None:
    """The next item that differs, from the beginning again after the last one; None if all are equal."""
    start = items.index(item) if item in items else 0
    return next((other for other in (*items[start:], *items[:start]) if other != item), None)


def _others(constants: Mapping[str, str]) -> dict[str, list[str]]:
    texts = [*constants.values()]
    rotated = {name: texts[place:] + texts[:place] for place, name in enumerate(constants)}
    return {name: [text for text in others if text != constants[name]] for name, others in rotated.items()}


def _string_constants(module: cst.Module) -> Iterator[tuple[str, str]]:
    for name, value in _assignments(module.body):
        text = string_value(value)
        if text is not None and name.isupper():
            yield name, text


def _assignments(body: Sequence[cst.CSTNode]) -> Iterator[tuple[str, cst.BaseExpression]]:
    for line in body:
        for small in line.body if isinstance(line, cst.SimpleStatementLine) else ():
            if isinstance(small, cst.Assign) and isinstance(small.targets[0].target, cst.Name):
                yield small.targets[0].target.value, small.value
            elif isinstance(small, cst.AnnAssign) and isinstance(small.target, cst.Name) and small.value is not None:
                yield small.target.value, small.value
