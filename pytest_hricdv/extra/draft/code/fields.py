"""Reads the fields of message classes, with the values that the code sets them to or compares them with.

A draft takes its ranges and variants from them. `FieldReader` is used by the readers of messages, ports and stimuli.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from dataclasses import replace

from pytest_hricdv.extra.draft.code.classes import neutral_value, parse_annotation
from pytest_hricdv.extra.draft.code.constants import Member, UnknownConstantError, evaluate, is_enum, members
from pytest_hricdv.extra.draft.code.flow import SAME, Flow, Origin, texts
from pytest_hricdv.extra.draft.code.naming import unit_of
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots
from pytest_hricdv.extra.draft.code_model import CodeLine, FieldValue, MessageField

KINDS = {"bool": "bool", "int": "float", "float": "float", "str": "str"}
"""Annotation -> kind of a field."""

MAX_NUMBER = 1e100
"""Greater numbers stand for infinity."""

MAX_NAMES = 2
"""Names that a value may have between its field and a comparison: `kind = order.kind`, or a parameter."""


class FieldReader:
    """Reads the fields of message classes."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def fields(self, scope: Scope) -> tuple[MessageField, ...]:
        """The fields of a message class, those of its bases first, with their values."""
        node = scope.node
        assert isinstance(node, ast.ClassDef)
        if is_enum(self._sources, scope):
            values = tuple(FieldValue(m.text, scope.module.location(s)) for m, s in members(self._sources, scope))
            return (MessageField("name", node.name, "str", scope.location, values, by_type=True),)
        fields: dict[str, MessageField] = {}
        for base in (*reversed(self._sources.base_classes(scope)), scope):
            assert isinstance(base.node, ast.ClassDef)
            for statement in base.node.body:
                if not isinstance(statement, ast.AnnAssign) or not isinstance(statement.target, ast.Name):
                    continue
                if "ClassVar" not in ast.unparse(statement.annotation):
                    part = self._field(base.module, statement.target.id, statement)
                    fields[part.name] = part
        return tuple(self._with_values(scope, part) for part in fields.values())

    def _field(self, module: Module, name: str, statement: ast.AnnAssign) -> MessageField:
        written = ast.unparse(statement.annotation)
        default = ast.unparse(statement.value) if statement.value is not None else ""
        kind = KINDS.get(written.strip("\"'"), "")
        neutral, imports = neutral_value(self._sources, module, statement.annotation) or ("", ())
        part = MessageField(name, written, kind, module.location(statement), default=default, neutral=neutral,
                            imports=imports, unit=unit_of(name) if kind == "float" else "")  # fmt: skip
        part = replace(part, observed=self._limits(module, statement))
        own = self._sources.class_of(module, statement.annotation)
        if own is not None and is_enum(self._sources, own):
            values = tuple(FieldValue(m.text, own.module.location(s)) for m, s in members(self._sources, own))
            return replace(part, kind="str", values=values, by_type=True)
        literal = self._literal_of(module, statement.annotation)
        if literal is None:
            return part
        contents = [self._constant(module, option) for option in literal]
        values = tuple(FieldValue(text, part.location) for text in contents if isinstance(text, str))
        return replace(part, kind="str" if values else "float", values=values, by_type=True)

    def _limits(self, module: Module, statement: ast.AnnAssign) -> tuple[float, ...]:
        """The limits of a number that pydantic, msgspec or attrs check: `Field(ge=1, le=4)`; empty without both."""
        limits: dict[str, float] = {}
        for node in ast.walk(statement):
            for keyword in node.keywords if isinstance(node, ast.Call) else ():
                value = self._constant(module, keyword.value) if keyword.arg in ("ge", "gt", "le", "lt") else None
                if isinstance(value, int | float) and keyword.arg is not None:
                    limits[keyword.arg[0]] = float(value)
        return (limits["g"], limits["l"]) if len(limits) == 2 else ()

    def _literal_of(self, module: Module, annotation: ast.expr) -> list[ast.expr] | None:
        """The options of a `Literal`, also of one that has a name."""
        annotation = parse_annotation(annotation) or annotation
        if isinstance(annotation, ast.Name):
            defined = self._sources.definition(module, annotation.id)
            if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign) and defined[1].value:
                annotation = defined[1].value
        if isinstance(annotation, ast.Subscript) and name_with_dots(annotation.value).rpartition(".")[2] == "Literal":
            return annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
        return None

    def _constant(self, module: Module, node: ast.expr) -> object:
        try:
            value = evaluate(self._sources, module, node)
        except UnknownConstantError:
            return None
        return value.text if isinstance(value, Member) else value

    def field_of_type(self, scope: Scope, name: str, annotation: ast.expr) -> MessageField:
        """A field of an annotated type, as far as this says which values it has."""
        statement = ast.AnnAssign(ast.Name(name), annotation, None, simple=1)
        return replace(self._field(scope.module, name, statement), location=scope.location)

    def parameter(self, scope: Scope, name: str, annotation: ast.expr | None) -> MessageField:
        """A parameter of a function as a field, with the values that the function compares it with."""
        if annotation is not None:
            part = self.field_of_type(scope, name, annotation)
            if part.by_type:
                return part
        else:
            part = MessageField(name, "", "", scope.location, unit=unit_of(name))
        return self._with_comparisons(part, list(self._comparisons_of_name(name, scope, 0)))

    def read_value(self, node: ast.expr, scope: Scope, name: str) -> MessageField:
        """A value that a function reads as a field: of a key of a dict."""
        part = MessageField(name, "", "", scope.module.location(node), unit=unit_of(name))
        return self._with_comparisons(part, list(self._comparisons(node, scope.module, scope, 0)))

    def _with_comparisons(self, part: MessageField, others: list[Origin]) -> MessageField:
        """A field with what it is compared with; this says its kind, where nothing else does."""
        numbers = tuple(dict.fromkeys(number for other in others for number in self._numbers(other)))
        values: dict[str, CodeLine] = {}
        for other in others if part.kind in ("", "str") else ():
            for text, location in texts(self._flow.constants(*other)).items():
                values.setdefault(text, location)
        kind = part.kind or ("str" if values else "float" if numbers or part.unit else "")
        field_values = tuple(FieldValue(*value) for value in values.items()) if kind == "str" else ()
        return replace(part, kind=kind, compared=numbers if kind == "float" else (), values=field_values)

    def values_in(self, functions: Iterable[Scope], name: str) -> tuple[FieldValue, ...]:
        """The texts that functions compare the field of this name of a message with, whatever its class."""
        others = [other for scope in functions for node in ast.walk(scope.node)
                  if isinstance(node, ast.Attribute) and node.attr == name.rpartition(".")[2]
                  for other in self._comparisons(node, scope.module, scope, 0)]  # fmt: skip
        values = texts([constant for other in others for constant in self._flow.constants(*other)])
        return tuple(FieldValue(*value) for value in values.items())

    def _with_values(self, scope: Scope, part: MessageField) -> MessageField:
        """The field with the texts that it is made of or compared with, or the numbers that it is compared with."""
        if part.by_type or part.kind not in ("float", "str"):
            return part
        others = list(self._others(scope, part.name))
        if part.kind == "float":
            numbers = [number for other in others for number in self._numbers(other)]
            return replace(part, compared=tuple(dict.fromkeys(numbers)))
        made_of = list(self._arguments(scope, part.name))
        values: dict[str, CodeLine] = {}
        for other in (*made_of, *others):
            for text, location in texts(self._flow.constants(*other)).items():
                values.setdefault(text, location)
        is_partial = not all(self._flow.is_complete(*made) for made in made_of)
        return replace(part, values=tuple(FieldValue(*value) for value in values.items()), is_partial=is_partial)

    def _numbers(self, other: Origin) -> Iterator[float]:
        """Numbers that an expression can be, or that are in a tuple or the keys of a table."""
        for value in self._flow.values(*other):
            for number in value if isinstance(value, tuple | dict) else (value,):
                if isinstance(number, int | float) and not isinstance(number, bool) and abs(number) < MAX_NUMBER:
                    yield float(number)

    def _arguments(self, scope: Scope, name: str) -> Iterator[Origin]:
        """The expressions for a field, wherever a message is made."""
        assert isinstance(scope.node, ast.ClassDef)
        names = [
            s.target.id for s in scope.node.body if isinstance(s, ast.AnnAssign) and isinstance(s.target, ast.Name)
        ]
        index = names.index(name) if name in names else len(names)
        for call in self._flow.calls.get(scope.node.name, ()):
            value = next((keyword.value for keyword in call.node.keywords if keyword.arg == name), None)
            if value is None and index < len(call.node.args):
                value = call.node.args[index]
            if value is not None:
                yield value, call.module, call.scope

    def _others(self, scope: Scope, name: str) -> Iterator[Origin]:
        """The values that a field is compared with, or looked up in, where a message can be of this class."""
        for module, at, node in self._flow.nodes:
            if isinstance(node, ast.Attribute) and node.attr == name and name_with_dots(node.value) != "self":
                owner = self._flow.owner_of(node.value, module, at)
                if owner is None or owner is scope.node:
                    yield from self._comparisons(node, module, at, 0)
            elif isinstance(node, ast.MatchClass) and name in node.kwd_attrs:
                own = self._sources.class_of(module, node.cls)
                if own is not None and own.node is scope.node:
                    yield from self._pattern_origins(node.kwd_patterns[node.kwd_attrs.index(name)], module, at)

    def _pattern_origins(self, pattern: ast.pattern, module: Module, scope: Scope | None) -> Iterator[Origin]:
        """The values in a pattern, and those that a name of it is compared with: `case Order(drink=drink)`."""
        for part in ast.walk(pattern):
            if isinstance(part, ast.MatchValue):
                yield part.value, module, scope
            elif isinstance(part, ast.MatchAs) and part.name and scope is not None:
                yield from self._comparisons_of_name(part.name, scope, 1)

    def _comparisons(self, node: ast.AST, module: Module, scope: Scope | None, names: int) -> Iterator[Origin]:
        """The values compared with an expression, directly and under the names that it gets."""
        parent = self._flow.parents.get(id(node))
        if isinstance(parent, ast.Compare):
            yield from ((other, module, scope) for other in (parent.left, *parent.comparators) if other is not node)
        elif isinstance(parent, ast.Match):
            yield from (other for case in parent.cases for other in self._pattern_origins(case.pattern, module, None))
        elif isinstance(parent, ast.Subscript) and parent.slice is node:
            yield parent.value, module, scope
        elif isinstance(parent, ast.Attribute) and parent.attr in (*SAME, "value"):
            above = self._flow.parents.get(id(parent))
            yield from self._comparisons(above if isinstance(above, ast.Call) else parent, module, scope, names)
        elif isinstance(parent, ast.Attribute) and parent.attr == "startswith":
            above = self._flow.parents.get(id(parent))
            yield from ((other, module, scope) for other in getattr(above, "args", ()))
        elif isinstance(parent, ast.Assign) and scope is not None and names < MAX_NAMES:
            for target in parent.targets:
                if isinstance(target, ast.Name):
                    yield from self._comparisons_of_name(target.id, scope, names + 1)
        elif isinstance(parent, ast.Call) and node in parent.args and names < MAX_NAMES:
            if isinstance(parent.func, ast.Attribute) and parent.func.attr == "get":
                yield parent.func.value, module, scope
            for method, parameter in self._flow.receivers(parent, node) if isinstance(node, ast.expr) else ():
                yield from self._comparisons_of_name(parameter, method, names + 1)

    def _comparisons_of_name(self, name: str, scope: Scope, names: int) -> Iterator[Origin]:
        for node in self._flow.names_in(scope).get(name, ()):
            if isinstance(node.ctx, ast.Load):
                yield from self._comparisons(node, scope.module, scope, names)


def merge_fields(before: MessageField | None, other: MessageField) -> MessageField:
    """Two uses of the same value as one."""
    if before is None:
        return other
    values = {value.text: value for value in (*before.values, *other.values)}
    compared = tuple(dict.fromkeys((*before.compared, *other.compared))) if not values else ()
    kind = "str" if values else before.kind or other.kind
    return replace(other, kind=kind, values=tuple(values.values()), compared=compared)
