"""What an object or a tuple is made of that a port says or is told."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator

from pytest_hricdv.extra.draft.found.port import Part
from pytest_hricdv.extra.draft.messages.fields import KINDS
from pytest_hricdv.extra.draft.reading.classes import form_of, own_bases
from pytest_hricdv.extra.draft.reading.constants import is_enum
from pytest_hricdv.extra.draft.reading.neutral import MANY, neutral
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow

_FORMS = ("dataclass", "namedtuple", "model")
"""Classes whose objects a stand-in can make, field by field."""


class PartReader:
    """Reads the parts of what annotations name."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow

    def parts(self, module: Module, annotation: ast.expr | None) -> tuple[Part, ...]:
        """The fields of the class, or the items of the tuple, that an annotation names; none for anything else."""
        if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
            try:
                return self.parts(module, ast.parse(annotation.value, mode="eval").body)
            except SyntaxError:
                return ()
        own = self._sources.class_of(module, annotation)
        if own is not None:
            is_made = form_of(self._sources, own) in _FORMS and not is_enum(self._sources, own)
            return tuple(self._fields(own)) if is_made else ()
        if isinstance(annotation, ast.Subscript) and _is_tuple(annotation) and isinstance(annotation.slice, ast.Tuple):
            kinds = [self._kind(module, part) for part in annotation.slice.elts]
            return () if "..." in ast.unparse(annotation) else tuple(Part("", *kind) for kind in kinds)
        return ()

    def _fields(self, scope: Scope) -> Iterator[Part]:
        """In their order, those of its bases first; a default is the neutral value of the field that has one."""
        assert isinstance(scope.node, ast.ClassDef)
        for base in own_bases(self._sources, scope):
            yield from self._fields(base)
        for statement in scope.node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                name, written = statement.target.id, ast.unparse(statement.annotation)
                if "ClassVar" not in written:
                    kind, made = self._kind(scope.module, statement.annotation)
                    yield Part(name, kind, made if statement.value is None else "", self._compared(name))

    def _kind(self, module: Module, annotation: ast.expr) -> tuple[str, str]:
        """The kind of a part, and a neutral value."""
        made, _ = neutral(self._sources, module, annotation) or ("None", ())
        return "floats" if made.endswith(f"* {MANY}") else KINDS.get(ast.unparse(annotation).strip("'\""), ""), made

    def _compared(self, name: str) -> tuple[float, ...]:
        """The numbers that `.name` is compared with, of whatever it is an attribute but `self`."""
        found: dict[float, None] = {}
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Compare):
                continue
            sides = (node.left, *node.comparators)
            if not any(isinstance(side, ast.Attribute) and side.attr == name for side in sides):
                continue
            for side in sides:
                if not dotted_name(side).endswith(f".{name}"):
                    found |= dict.fromkeys(map(float, _numbers(self._flow.constants(side, module, scope))))
        return tuple(found)


def _numbers(values: Iterable[object]) -> Iterator[int | float]:
    for value in values:
        if isinstance(value, int | float) and not isinstance(value, bool):
            yield value


def _is_tuple(annotation: ast.Subscript) -> bool:
    return dotted_name(annotation.value).rpartition(".")[2] in ("tuple", "Tuple")
