"""A file of the code under test as a syntax tree, with the places that may be changed."""

from __future__ import annotations

from collections.abc import Iterator

import libcst as cst
from libcst.metadata import MetadataWrapper, ParentNodeProvider, PositionProvider

from pytest_hricdv.coverage.code_map import SourceFile

NOTES = frozenset({"note", "log", "debug", "info", "warn", "warning", "error", "critical", "exception", "print"})
"""Names of functions that write remarks for people: what they are called with changes nothing that a robot does."""

TYPES = frozenset({"TypeVar", "TypeVarTuple", "ParamSpec", "NewType"})
"""Names of functions whose result only type checkers read."""

_COMPOUND = (cst.BaseCompoundStatement, cst.ExceptHandler, cst.MatchCase)
_DECLARING = (cst.Annotation, cst.Decorator, cst.Import, cst.ImportFrom)


class Source:
    """A file as a tree.

    Nodes are unique, so that a node identifies its place. Left out as places are lines that are waived or that coverage
    does not count, docstrings, annotations, decorators, imports, what only type checkers read, and notes for people.

    Args:
        file: that parses.
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
