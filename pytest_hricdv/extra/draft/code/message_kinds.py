"""Which message classes of the code a parameter takes: as it is annotated, tested, dispatched on, or read."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.classes import find_message_classes, form_of, methods_of
from pytest_hricdv.extra.draft.code.flow import Flow, last_name, parameters_of
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots

FORMS = ("dataclass", "namedtuple", "model")
"""Forms of classes that the bus of a test carries."""


class KindReader:
    """Reads the message classes that functions take."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def classes(self, scope: Scope, part: ast.arg) -> list[Scope]:
        """The message classes that a parameter can be of, each once; those of its annotation first."""
        every = [*find_message_classes(self._sources, part.annotation, scope.module), *self._overloads(scope),
                 *self._find_tests(scope, part.arg)]  # fmt: skip
        found = {id(own.node): own for own in every if self._is_message(own)}
        return list(found.values()) or list(self._with_fields(scope, part.arg))

    def _overloads(self, scope: Scope) -> Iterator[Scope]:
        """What a function of `functools.singledispatch` has functions for."""
        for function in self._sources.functions:
            for decorator in function.node.decorator_list:
                each = decorator.func if isinstance(decorator, ast.Call) else decorator
                is_of = isinstance(each, ast.Attribute) and each.attr == "register"
                if not is_of or name_with_dots(each.value) != scope.node.name:  # type: ignore[attr-defined]
                    continue
                assert not isinstance(function.node, ast.ClassDef)
                given = [part for part in parameters_of(function.node) if part.arg != "self"][:1]
                annotations = [*(part.annotation for part in given), *getattr(decorator, "args", ())]
                for annotation in annotations:
                    yield from find_message_classes(self._sources, annotation, function.module)

    def _find_tests(self, scope: Scope, name: str) -> Iterator[Scope]:
        """The classes that a function asks for, with `isinstance` or `match`."""
        for node in ast.walk(scope.node):
            tested: list[ast.expr] = []
            if isinstance(node, ast.Call) and last_name(node.func) == "isinstance" and len(node.args) == 2:
                named = node.args[1]
                listed = named.elts if isinstance(named, ast.Tuple) else [named]
                tested = listed if name_with_dots(node.args[0]) == name else []
            elif isinstance(node, ast.Match) and name_with_dots(node.subject) == name:
                parts = (part for case in node.cases for part in ast.walk(case.pattern))
                tested = [part.cls for part in parts if isinstance(part, ast.MatchClass)]
            for each in tested:
                yield from find_message_classes(self._sources, each, scope.module)

    def _with_fields(self, scope: Scope, name: str) -> Iterator[Scope]:
        """The only message class that has all attributes that a function reads, where it reads two or decides."""
        read = {node.attr for node in ast.walk(scope.node)
                if isinstance(node, ast.Attribute) and name_with_dots(node.value) == name}  # fmt: skip
        fitting = []
        for own in self._sources.classes if read else ():
            fields = self._fields(own) if self._is_message(own) else set()
            if read & fields and read <= {*fields, *methods_of(self._sources, own)}:
                fitting.append(own)
        if len(fitting) == 1:
            yield fitting[0]

    def _is_message(self, own: Scope) -> bool:
        return form_of(self._sources, own) in FORMS and own.module.scope.get(own.node.name) is own.node

    def _fields(self, scope: Scope) -> set[str]:
        bodies = [each.node.body for each in (scope, *self._sources.base_classes(scope))]
        return {s.target.id for body in bodies for s in body
                if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)}  # fmt: skip
