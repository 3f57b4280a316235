"""Which classes of messages an expression or an annotation can mean."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.constants import is_enum
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.type_tables import is_first
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow


class MessageClasses:
    """Finds the message classes that an expression can be an instance of."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow

    def classes_in(self, expression: ast.AST | None, module: Module, scope: Scope | None) -> Iterator[Scope]:
        """Message classes whose instances (or members) an expression can be."""
        for node, where, at in self._flow.expressions(expression, module, scope):
            own = None
            if isinstance(node, ast.Call):
                own = self._sources.class_of(where, node.func) if isinstance(node.func, ast.expr) else None
                if dotted_name(node.func).rpartition(".")[2] in ("replace", "copy", "deepcopy") and node.args:
                    yield from self.classes_in(node.args[0], where, at)
                yield from self._returned(node, where)
            elif isinstance(node, ast.Attribute):
                own = self._sources.class_of(where, node.value)
                own = own if own is not None and is_enum(self._sources, own) else None
            elif isinstance(node, ast.Name) and at is not None:
                yield from self._of_parameter(node.id, at)
            if own is not None and form_of(self._sources, own):
                yield own

    def _returned(self, node: ast.Call, module: Module) -> Iterator[Scope]:
        name = dotted_name(node.func).rpartition(".")[2]
        for scope in self._flow.methods.get(name, ()):
            assert not isinstance(scope.node, ast.ClassDef)
            yield from self.in_annotation(scope.node.returns, scope.module)

    def _of_parameter(self, name: str, scope: Scope) -> Iterator[Scope]:
        assert not isinstance(scope.node, ast.ClassDef)
        row = self._flow.handlers.get(id(scope.node))
        if row is not None and is_first(scope, name):
            yield row.message
            return
        arguments = scope.node.args
        for part in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs):
            if part.arg == name:
                yield from self.in_annotation(part.annotation, scope.module)

    def in_annotation(self, annotation: ast.expr | None, module: Module, depth: int = 0) -> Iterator[Scope]:
        """Message classes that an annotation names, through unions and aliases."""
        if annotation is None or depth > 5:
            return
        if isinstance(annotation, ast.BinOp):
            yield from self.in_annotation(annotation.left, module, depth + 1)
            yield from self.in_annotation(annotation.right, module, depth + 1)
            return
        if isinstance(annotation, ast.Subscript) and dotted_name(annotation.value).endswith(("Union", "Optional")):
            parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
            for part in parts:
                yield from self.in_annotation(part, module, depth + 1)
            return
        if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str) and not dotted_name(annotation):
            try:
                yield from self.in_annotation(ast.parse(annotation.value, mode="eval").body, module, depth + 1)
            except SyntaxError:
                return
            return
        own = self._sources.class_of(module, annotation)
        if own is not None:
            if form_of(self._sources, own):
                yield own
            return
        name = dotted_name(annotation)
        defined = self._sources.definition(module, name) if name else None
        if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
            yield from self.in_annotation(defined[1].value, defined[0], depth + 1)
