"""What a draft needs of the code's classes: form (dataclass, typed dict, enumeration ...), methods, neutral values.

A *neutral value* is the source text of a value for an annotation (`neutral_value`), such as `0.0` for a float.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.constants import is_enum, members
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import Imports

_PLAIN = {"bool": "False", "int": "0", "float": "0.0", "str": '""', "bytes": 'b""', "None": "None"}
_EMPTY = {"list": "[]", "List": "[]", "dict": "{}", "Dict": "{}", "set": "set()", "Sequence": "[]", "Iterable": "[]",
          "Mapping": "{}", "frozenset": "frozenset()", "deque": "[]"}  # fmt: skip

FORMS = ("dataclass", "namedtuple", "model")
"""Forms of classes that the bus of a test carries."""

ARRAY_LENGTH = 36
"""Numbers in an array of any length: a scan with a ray each ten degrees."""

FAR = "10.0"
"""The neutral number in an array; if it is a distance, nobody is near."""

_TRANSPARENT = ("Union", "Optional")
"""Annotations that are of the types within them."""

_MAX_DEPTH = 5

Neutral = tuple[str, Imports]
"""A neutral value: its source text, and the imports that it needs."""


def form_of(sources: Sources, scope: Scope) -> str:
    """The form of a class that can be a message; empty if it cannot be one."""
    node = scope.node
    assert isinstance(node, ast.ClassDef)
    if _is_dataclass(scope):
        return "dataclass"
    for decorator in node.decorator_list:
        name = resolve_import(scope.module, decorator.func if isinstance(decorator, ast.Call) else decorator)
        if name.startswith(("attr.", "attrs.")):
            return "model"
    bases = {base.rpartition(".")[2] for base in sources.bases(scope)}
    for base, form in (("NamedTuple", "namedtuple"), ("TypedDict", "typeddict"), ("BaseModel", "model"),
                       ("Struct", "model")):  # fmt: skip
        if base in bases:
            return form
    if any(_is_dataclass(base) for base in sources.base_classes(scope)):
        return "dataclass"
    return "enum" if is_enum(sources, scope) else ""


def _is_dataclass(scope: Scope) -> bool:
    decorators = (node.func if isinstance(node, ast.Call) else node for node in scope.node.decorator_list)
    return any(name_with_dots(decorator).rpartition(".")[2] == "dataclass" for decorator in decorators)


def methods_of(sources: Sources, scope: Scope) -> dict[str, Scope]:
    """The methods of a class by their names, with those of its bases in the code."""
    methods: dict[str, Scope] = {}
    for base in (*reversed(sources.base_classes(scope)), scope):
        assert isinstance(base.node, ast.ClassDef)
        for statement in base.node.body:
            if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef):
                methods[statement.name] = Scope(base.module, statement, base.node)
    return methods


def parse_annotation(annotation: ast.expr | None) -> ast.expr | None:
    """An annotation; of one that is written as a string, its content."""
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        try:
            return ast.parse(annotation.value, mode="eval").body
        except SyntaxError:
            return None
    return annotation


def find_message_classes(
    sources: Sources, annotation: ast.expr | None, module: Module, depth: int = 0
) -> Iterator[Scope]:
    """Message classes that an annotation names, through unions and aliases."""
    annotation = parse_annotation(annotation)
    if annotation is None or depth > _MAX_DEPTH:
        return
    parts: list[ast.expr] = []
    if isinstance(annotation, ast.BinOp):
        parts = [annotation.left, annotation.right]
    elif isinstance(annotation, ast.Subscript) and name_with_dots(annotation.value).endswith(_TRANSPARENT):
        parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
    own = sources.class_of(module, annotation)
    if own is not None and form_of(sources, own):
        yield own
    name = name_with_dots(annotation)
    defined = sources.definition(module, name) if name and own is None else None
    if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
        yield from find_message_classes(sources, defined[1].value, defined[0], depth + 1)
    for part in parts:
        yield from find_message_classes(sources, part, module, depth + 1)


def find_parameter_classes(sources: Sources, function: Scope, part: ast.arg) -> list[Scope]:
    """The message classes that a parameter can be of, each once: of its annotation, `isinstance` and `match`."""
    found = [*find_message_classes(sources, part.annotation, function.module)]
    for node in ast.walk(function.node):
        tested: list[ast.expr] = []
        if isinstance(node, ast.Call) and name_with_dots(node.func) == "isinstance" and len(node.args) == 2:
            named = node.args[1]
            listed = named.elts if isinstance(named, ast.Tuple) else [named]
            tested = listed if name_with_dots(node.args[0]) == part.arg else []
        elif isinstance(node, ast.Match) and any(name_with_dots(side) == part.arg for side in ast.walk(node.subject)):
            parts = (pattern for case in node.cases for pattern in ast.walk(case.pattern))
            tested = [pattern.cls for pattern in parts if isinstance(pattern, ast.MatchClass)]
        found += [
            own for tested_class in tested for own in find_message_classes(sources, tested_class, function.module)
        ]
    return list({id(own.node): own for own in found if form_of(sources, own) in FORMS
                 and own.module.scope.get(own.node.name) is own.node}.values())  # fmt: skip


def neutral_value(sources: Sources, module: Module, annotation: ast.expr | None, depth: int = 0) -> Neutral | None:
    """A value of the annotated type that says as little as possible; None where nothing is known of the type."""
    annotation = parse_annotation(annotation)
    if annotation is None or depth > _MAX_DEPTH:
        return None
    if isinstance(annotation, ast.Constant) and annotation.value is None:
        return "None", ()
    if isinstance(annotation, ast.BinOp):
        left = neutral_value(sources, module, annotation.left, depth + 1)
        return left or neutral_value(sources, module, annotation.right, depth + 1)
    if isinstance(annotation, ast.Subscript):
        return _subscript_value(sources, module, annotation, depth)
    name = name_with_dots(annotation).rpartition(".")[2]
    if name in _PLAIN or name in _EMPTY:
        return _PLAIN.get(name) or _EMPTY[name], ()
    own = sources.class_of(module, annotation)
    if own is not None:
        return _instance(sources, own, depth)
    defined = sources.definition(module, name_with_dots(annotation)) if name else None
    if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
        return neutral_value(sources, defined[0], defined[1].value, depth + 1)
    return ("()", ()) if name == "tuple" else None


def _subscript_value(sources: Sources, module: Module, annotation: ast.Subscript, depth: int) -> Neutral | None:
    name = name_with_dots(annotation.value).rpartition(".")[2]
    parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
    if name == "Optional":
        return "None", ()
    if name == "Union":
        return neutral_value(sources, module, parts[0], depth + 1)
    if name == "Literal":
        return ast.unparse(parts[0]), ()
    if name in ("tuple", "Tuple"):
        if len(parts) == 2 and isinstance(parts[1], ast.Constant) and parts[1].value is Ellipsis:
            return (f"({FAR},) * {ARRAY_LENGTH}" if name_with_dots(parts[0]) == "float" else "()"), ()
        values = [neutral_value(sources, module, part, depth + 1) or ("None", ()) for part in parts]
        text = "(" + ", ".join(text for text, _ in values) + ",)"
        return text, tuple(need for _, imports in values for need in imports)
    if name in ("list", "List", "Sequence") and name_with_dots(parts[0]) == "float":
        return f"[{FAR}] * {ARRAY_LENGTH}", ()
    return (_EMPTY[name], ()) if name in _EMPTY else None


def _instance(sources: Sources, scope: Scope, depth: int) -> Neutral | None:
    assert isinstance(scope.node, ast.ClassDef)
    name, own = scope.node.name, ((scope.module.name, scope.node.name),)
    if is_enum(sources, scope):
        first = members(sources, scope)[:1]
        return (f"{name}.{first[0][0].name}", own) if first else None
    if form_of(sources, scope) not in ("dataclass", "namedtuple", "model", "typeddict"):
        return None
    arguments, imports = [], list(own)
    for base in (*reversed(sources.base_classes(scope)), scope):
        assert isinstance(base.node, ast.ClassDef)
        for statement in base.node.body:
            if not isinstance(statement, ast.AnnAssign) or not isinstance(statement.target, ast.Name):
                continue
            if statement.value is None and "ClassVar" not in ast.unparse(statement.annotation):
                value = neutral_value(sources, base.module, statement.annotation, depth + 1) or ("None", ())
                arguments.append(f"{statement.target.id}={value[0]}")
                imports += value[1]
    return f"{name}({', '.join(arguments)})", tuple(dict.fromkeys(imports))
