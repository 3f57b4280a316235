"""`Source`: a file of the code under test as a syntax tree, with the places that mutation operators may change.

`mutants` makes one for each file, and `Names`, the states, commands and constants of all files, as replacements.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

import libcst as cst
from libcst.metadata import MetadataWrapper, ParentNodeProvider, PositionProvider

from pytest_hricdv.coverage.code_map import SourceFile

NOTES = frozenset({"note", "log", "debug", "info", "warn", "warning", "error", "critical", "exception", "print"})
"""Names of functions that write notes for people: changes in their arguments do not affect what a robot does."""

TYPES = frozenset({"TypeVar", "TypeVarTuple", "ParamSpec", "NewType"})
"""Names of functions whose result only type checkers read."""

_COMPOUND = (cst.BaseCompoundStatement, cst.ExceptHandler, cst.MatchCase)
_DECLARING = (cst.Annotation, cst.Decorator, cst.Import, cst.ImportFrom)


class Source:
    """A file as a tree.

    Nodes are unique, so that a node identifies its place. Left out as places are lines that are waived or that coverage
    does not count, docstrings, annotations, decorators, imports, what only type checkers read, and notes for people.

    Args:
        file: the file that parses.
    """

    def __init__(self, file: SourceFile) -> None:
        self.file = file
        wrapper = MetadataWrapper(cst.parse_module(file.text))
        self.module = wrapper.module
        self._positions = wrapper.resolve(PositionProvider)
        self._parents = wrapper.resolve(ParentNodeProvider)
        self._lines = frozenset(file.statements) - {waiver.line for waiver in file.waivers}

    def places(self) -> Iterator[tuple[cst.CSTNode, int]]:
        """The nodes that may be changed, in the order of the text, each with the line of its statement."""
        for node in _walk(self.module):
            line = self.statement_line(node)
            if line in self._lines:
                yield node, line

    def statement_line(self, node: cst.CSTNode) -> int | None:
        """The line in which the innermost statement around a node begins; None for the module itself."""
        here: cst.CSTNode | None = node
        while here is not None and not isinstance(here, (cst.SimpleStatementLine, *_COMPOUND)):
            here = self.parent(here)
        return None if here is None else self._positions[here].start.line

    def parent(self, node: cst.CSTNode) -> cst.CSTNode | None:
        """The node around a node; None for the module."""
        return self._parents.get(node)

    def around(self, node: cst.CSTNode, kind: type[cst.CSTNode]) -> cst.CSTNode | None:
        """The innermost node of this kind around a node; None if there is none."""
        here = self.parent(node)
        while here is not None and not isinstance(here, kind):
            here = self.parent(here)
        return here

    def replace_node(self, old: cst.CSTNode, new: cst.CSTNode) -> str:
        """The text with one node replaced."""
        tree = self.module.deep_replace(old, new)
        assert isinstance(tree, cst.Module)
        return tree.code


def name_of_call(node: cst.CSTNode) -> str:
    """The last name of what is called: `publish` of `robot.bus.publish(...)`; empty for anything but a call."""
    return last_name(node.func) if isinstance(node, cst.Call) else ""


def last_name(node: cst.CSTNode) -> str:
    """`settle_s` of `robot.settings.settle_s`; empty for what is neither a name nor an attribute."""
    if isinstance(node, cst.Attribute):
        return node.attr.value
    return node.value if isinstance(node, cst.Name) else ""


def string_value(node: cst.CSTNode | None) -> str | None:
    """The text of a plain string literal; None for any other node."""
    if not isinstance(node, cst.SimpleString):
        return None
    value = node.evaluated_value
    return value if isinstance(value, str) else None


def _walk(node: cst.CSTNode) -> Iterator[cst.CSTNode]:
    if _is_left_out(node):
        return
    yield node
    for child in node.children:
        yield from _walk(child)


def _is_left_out(node: cst.CSTNode) -> bool:
    if isinstance(node, cst.Expr):
        return isinstance(node.value, cst.BaseString) or name_of_call(node.value) in NOTES
    if isinstance(node, cst.Assign):
        return name_of_call(node.value) in TYPES
    return isinstance(node, _DECLARING) or (isinstance(node, cst.If) and last_name(node.test) == "TYPE_CHECKING")


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
