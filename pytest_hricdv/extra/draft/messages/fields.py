"""Fields of message classes, with the values that the code makes them of or compares them with."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.found.findings import FoundValue, MessageField, Place
from pytest_hricdv.extra.draft.messages.classes import MessageClasses
from pytest_hricdv.extra.draft.messages.nested import within
from pytest_hricdv.extra.draft.messages.speech import SUBSCRIBES, TAKES
from pytest_hricdv.extra.draft.reading.classes import own_bases
from pytest_hricdv.extra.draft.reading.constants import Member, Reference, UnknownValueError, evaluate, is_enum, members
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, last_name, parameter_names, texts

KINDS = {"bool": "bool", "int": "float", "float": "float", "str": "str"}
MAX_DEPTH = 5
"""So often a value may be handed on until it is compared (chosen)."""

_Written = tuple[ast.expr, Module, Scope | None]
"""An expression, and where it is written."""

_QUOTED = re.compile(r"[\"'`]{1,2}([A-Za-z][\w .-]{0,40}?)[\"'`]{1,2}")


class MessageFields:
    """Reads the fields of message classes."""

    def __init__(self, sources: Sources, flow: ValueFlow, classes: MessageClasses) -> None:
        self._sources, self._flow, self._classes = sources, flow, classes
        self._entered: list[ast.AST] = []
        """Classes whose fields are being read: one that has instances of itself is not made for ever."""

    def fields(self, scope: Scope) -> tuple[MessageField, ...]:
        """The fields of a message class, those of its bases first, with their values."""
        node = scope.node
        assert isinstance(node, ast.ClassDef)
        if is_enum(self._sources, scope):
            values = tuple(FoundValue(m.text, scope.module.place(s)) for m, s in members(self._sources, scope))
            return (MessageField("name", node.name, "str", scope.place, values, by_type=True),)
        fields = {part.name: part for base in own_bases(self._sources, scope) for part in self.fields(base)}
        for statement in node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                part = self._field(scope, statement)
                if part is not None:
                    fields[part.name] = part
        return tuple(self._with_values(scope, part, len(fields)) for part in fields.values())

    def _field(self, scope: Scope, statement: ast.AnnAssign) -> MessageField | None:
        assert isinstance(statement.target, ast.Name)
        written = ast.unparse(statement.annotation)
        if "ClassVar" in written:
            return None
        place = scope.module.place(statement)
        default = ast.unparse(statement.value) if statement.value is not None else ""
        name = statement.target.id
        kind, values = KINDS.get(written.strip("\"'"), ""), tuple[FoundValue, ...]()
        annotation = statement.annotation
        own = self._sources.class_of(scope.module, annotation)
        if own is not None and is_enum(self._sources, own):
            values = tuple(FoundValue(m.text, own.module.place(s)) for m, s in members(self._sources, own))
            return MessageField(name, written, "str", place, values, "", default, by_type=True)
        if isinstance(annotation, ast.Name):
            defined = self._sources.definition(scope.module, annotation.id)
            if (
                defined is not None
                and isinstance(defined[1], ast.Assign | ast.AnnAssign)
                and defined[1].value is not None
            ):
                annotation = defined[1].value
        if isinstance(annotation, ast.Subscript) and dotted_name(annotation.value).rpartition(".")[2] == "Literal":
            parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
            contents = [self._literal(scope.module, part) for part in parts]
            chosen = tuple(
                FoundValue(text, scope.module.place(annotation)) for text in contents if isinstance(text, str)
            )
            kind = "str" if chosen else "float"
            return MessageField(name, written, kind, place, chosen, "", default, by_type=True)
        inner = within(self._sources, scope.module, statement.annotation)
        if inner is not None and all(node is not inner.scope.node for node in self._entered):
            self._entered.append(inner.scope.node)
            within_it = self.fields(inner.scope)
            self._entered.pop()
            made_of = (inner.scope.module.name, inner.name)
            return MessageField(
                name, written, "", place, default=default, made_of=made_of, parts=within_it, empty=inner.empty
            )
        unit = unit_of(name) if kind == "float" else ""
        return MessageField(name, written, kind, place, (), unit, default)

    def _literal(self, module: Module, node: ast.expr) -> object:
        try:
            value = evaluate(self._sources, module, node)
        except UnknownValueError:
            return None
        return value.text if isinstance(value, Member) else value

    def _with_values(self, scope: Scope, part: MessageField, fields: int) -> MessageField:
        """The same with the texts that it is made of, or compared with; of a docstring where the code says none."""
        if part.kind == "float":
            return replace(part, compared=tuple(dict.fromkeys(self._numbers(scope, part.name))))
        if part.kind != "str" or part.by_type:
            return part
        values: dict[str, FoundValue] = {}
        for text, place in {**self._made_of(scope, part.name), **self._compared(scope, part.name)}.items():
            values.setdefault(text, FoundValue(text, place))
        for text in self._documented(scope, part.name, fields):
            values.setdefault(text, FoundValue(text, scope.place, certainty="likely"))
        is_partial = not all(self._flow.is_whole(*made) for made in self._makings(scope, part.name))
        return replace(part, values=tuple(values.values()), is_partial=is_partial)

    def _numbers(self, scope: Scope, name: str) -> Iterator[float]:
        """The numbers that a field is compared with where it is read, or looked up by: `in (7, 9)`, `BAYS[job.bay]`."""
        for other, module, at in self._others(scope, name):
            for number in (*self._flow.constants(other, module, at), *self._flow.elements(other, module, at)):
                if isinstance(number, int | float) and not isinstance(number, bool):
                    yield float(number)

    def _made_of(self, scope: Scope, name: str) -> dict[str, Place]:
        """Texts with which a message is made."""
        places: dict[str, Place] = {}
        for value, module, at in self._makings(scope, name):
            places |= texts(self._flow.constants(value, module, at))
            places |= self._forwarded(value, module, at)
        return places

    def _makings(self, scope: Scope, name: str) -> Iterator[tuple[ast.expr, Module, Scope | None]]:
        """What a field of a message is made of, wherever one is made."""
        assert isinstance(scope.node, ast.ClassDef)
        names = [
            s.target.id for s in scope.node.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)
        ]
        for call in self._flow.calls.get(scope.node.name, ()):
            value = next((keyword.value for keyword in call.node.keywords if keyword.arg == name), None)
            index = names.index(name) if name in names else len(names)
            if value is None and index < len(call.node.args):
                value = call.node.args[index]
            if value is not None:
                yield value, call.module, call.scope

    def _forwarded(self, value: ast.expr, module: Module, scope: Scope | None) -> dict[str, Place]:
        """Texts of a message's field that is said back in another one, as far as it is compared."""
        places: dict[str, Place] = {}
        for node, _, at in self._flow.expressions(value, module, scope):
            if isinstance(node, ast.Name) and at is not None:
                for written in self._compared_names(node.id, at):
                    places |= self._texts_of(*written)
        return places

    def _compared(self, scope: Scope, name: str) -> dict[str, Place]:
        """Texts that a field is compared with, or looked up by, directly or as a parameter that gets it."""
        places: dict[str, Place] = {}
        for other, module, at in self._others(scope, name):
            places |= self._texts_of(other, module, at)
        return places

    def _others(self, scope: Scope, name: str) -> Iterator[_Written]:
        """What a field is compared with, or looked up in."""
        for module, at, node in self._flow.nodes:
            if isinstance(node, ast.Attribute) and node.attr == name and self._is_of(node.value, scope, module, at):
                yield from self._compared_at(node, module, at)

    def _is_of(self, expression: ast.expr, scope: Scope, module: Module, at: Scope | None) -> bool:
        """Whether an expression can be a message of this class: made, taken of its subscription, or annotated."""
        assert isinstance(scope.node, ast.ClassDef)
        if dotted_name(expression) == "self":
            return False
        for own in self._classes.classes_in(expression, module, at):
            return own.node is scope.node
        for node, where, place in self._flow.expressions(expression, module, at):
            if (
                isinstance(node, ast.Call)
                and last_name(node.func).strip("_") in TAKES
                and isinstance(node.func, ast.Attribute)
            ):
                kinds = list(self._subscribed(node.func.value, where, place))
                return any(kind.node is scope.node for kind in kinds) if kinds else True
        return isinstance(expression, ast.Name | ast.Attribute) and not isinstance(expression, ast.Call)

    def _subscribed(self, receiver: ast.expr, module: Module, scope: Scope | None) -> Iterator[Scope]:
        for node, where, _ in self._flow.expressions(receiver, module, scope):
            if isinstance(node, ast.Call) and last_name(node.func).strip("_") in SUBSCRIBES:
                for argument in node.args:
                    own = self._sources.class_of(where, argument)
                    if own is not None:
                        yield own

    @property
    def _parents(self) -> dict[int, ast.AST]:
        parents: dict[int, ast.AST] | None = self.__dict__.get("_parent_of")
        if parents is None:
            parents = {
                id(child): node
                for module in self._sources.modules
                for node in ast.walk(module.tree)
                for child in ast.iter_child_nodes(node)
            }
            self.__dict__["_parent_of"] = parents
        return parents

    def _compared_at(self, node: ast.AST, module: Module, scope: Scope | None, depth: int = 0) -> Iterator[_Written]:
        """What is compared with an expression, where it stands and wherever it goes from there."""
        parent = self._parents.get(id(node))
        if parent is None or depth > MAX_DEPTH:
            return
        if isinstance(parent, ast.Compare):
            for other in (parent.left, *parent.comparators):
                if other is not node:
                    yield other, module, scope
        elif isinstance(parent, ast.Match):
            for case in parent.cases:
                for value in ast.walk(case.pattern):
                    if isinstance(value, ast.MatchValue):
                        yield value.value, module, scope
        elif isinstance(parent, ast.Subscript) and parent.slice is node:
            yield parent.value, module, scope
        elif isinstance(parent, ast.Await | ast.NamedExpr | ast.BoolOp | ast.UnaryOp):
            yield from self._compared_at(parent, module, scope, depth + 1)
        elif isinstance(parent, ast.Attribute) and parent.attr in ("strip", "lower", "upper", "value", "decode"):
            grand = self._parents.get(id(parent), parent)
            yield from self._compared_at(grand if isinstance(grand, ast.Call) else parent, module, scope, depth + 1)
        elif isinstance(parent, ast.Assign) and scope is not None:
            for target in parent.targets:
                if isinstance(target, ast.Name):
                    yield from self._compared_names(target.id, scope, depth + 1)
        elif isinstance(parent, ast.Call) and node in parent.args:
            yield from self._compared_in_call(parent, node, module, scope, depth)

    def _compared_in_call(
        self, call: ast.Call, node: ast.AST, module: Module, scope: Scope | None, depth: int
    ) -> Iterator[_Written]:
        if isinstance(call.func, ast.Attribute) and call.func.attr == "get":
            yield call.func.value, module, scope
        for method in self._flow.methods.get(last_name(call.func), ()):
            assert not isinstance(method.node, ast.ClassDef)
            names = parameter_names(method.node)[1 if method.owner is not None else 0 :]
            index = call.args.index(node) if isinstance(node, ast.expr) else 0
            if index < len(names):
                yield from self._compared_names(names[index], method, depth + 1)

    def _compared_names(self, name: str, scope: Scope, depth: int = 0) -> Iterator[_Written]:
        if depth > MAX_DEPTH:
            return
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Name) and node.id == name and isinstance(node.ctx, ast.Load):
                yield from self._compared_at(node, scope.module, scope, depth + 1)

    def _texts_of(self, expression: ast.expr, module: Module, scope: Scope | None) -> dict[str, Place]:
        """A text, or those in a collection, or the keys of a table."""
        places: dict[str, Place] = {}
        values = self._flow.constants(expression, module, scope)
        place = module.place(expression)
        for value in [*values, *self._flow.elements(expression, module, scope)]:
            if isinstance(value, str | Member) and not isinstance(value, Reference):
                places |= texts({value: values.get(value, place)})
        return places

    def _documented(self, scope: Scope, name: str, fields: int) -> list[str]:
        """Texts in quotation marks that the docstring has for a field."""
        assert isinstance(scope.node, ast.ClassDef)
        docstring = ast.get_docstring(scope.node) or ""
        line = re.search(rf"^\s*{re.escape(name)}(?:\s*\([^)]*\))?:(.*)$", docstring, re.MULTILINE)
        written = line.group(1) if line else docstring if fields == 1 else ""
        quoted = [text for text in _QUOTED.findall(written) if "`" not in text]
        return quoted if len(quoted) > 1 and not re.search(r"`\w+\.\w+", written) else []
