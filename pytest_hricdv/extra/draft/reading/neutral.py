"""A value of a type that says as little as possible, as source text: what stand-ins return."""

from __future__ import annotations

import ast

from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.constants import is_enum, members
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name

PLAIN = {"bool": "False", "int": "0", "float": "0.0", "str": '""', "bytes": 'b""', "None": "None"}
EMPTY = {"list": "[]", "List": "[]", "dict": "{}", "Dict": "{}", "set": "set()", "Sequence": "[]", "Iterable": "[]",
         "Mapping": "{}", "frozenset": "frozenset()", "deque": "[]"}  # fmt: skip

MANY = 36
"""Numbers in a tuple of any length (chosen: a scan with a ray each ten degrees)."""

FAR = "10.0"
"""Each of them (chosen: of distances, nobody is near)."""

MAX_DEPTH = 4

Made = tuple[str, tuple[tuple[str, str], ...]]
"""Source text, and the names that it needs, each as (module, name)."""


def neutral(sources: Sources, module: Module, annotation: ast.expr | None, depth: int = 0) -> Made | None:
    """A value of the type that an annotation names; None where nothing is known of it."""
    if annotation is None or depth > MAX_DEPTH:
        return None
    if isinstance(annotation, ast.Constant) and annotation.value is None:
        return "None", ()
    if isinstance(annotation, ast.Constant) and isinstance(annotation.value, str):
        try:
            return neutral(sources, module, ast.parse(annotation.value, mode="eval").body, depth + 1)
        except SyntaxError:
            return None
    if isinstance(annotation, ast.BinOp):
        left = neutral(sources, module, annotation.left, depth + 1)
        return left or neutral(sources, module, annotation.right, depth + 1)
    if isinstance(annotation, ast.Subscript):
        return _subscripted(sources, module, annotation, depth)
    name = dotted_name(annotation).rpartition(".")[2]
    if name in PLAIN:
        return PLAIN[name], ()
    if name in EMPTY:
        return EMPTY[name], ()
    own = sources.class_of(module, annotation)
    if own is not None:
        return _made(sources, own, depth)
    defined = sources.definition(module, dotted_name(annotation)) if name else None
    if defined is not None and isinstance(defined[1], ast.Assign | ast.AnnAssign):
        return neutral(sources, defined[0], defined[1].value, depth + 1)
    return ("()", ()) if name == "tuple" else None


def _subscripted(sources: Sources, module: Module, annotation: ast.Subscript, depth: int) -> Made | None:
    name = dotted_name(annotation.value).rpartition(".")[2]
    parts = annotation.slice.elts if isinstance(annotation.slice, ast.Tuple) else [annotation.slice]
    if name in ("Optional",):
        return "None", ()
    if name in ("Union", "Annotated"):
        return neutral(sources, module, parts[0], depth + 1)
    if name == "Literal":
        return ast.unparse(parts[0]), ()
    if name in ("tuple", "Tuple"):
        if len(parts) == 2 and isinstance(parts[1], ast.Constant) and parts[1].value is Ellipsis:
            inner = neutral(sources, module, parts[0], depth + 1)
            return (f"({FAR},) * {MANY}", ()) if inner == ("0.0", ()) else ("()", ())
        made = [neutral(sources, module, part, depth + 1) or ("None", ()) for part in parts]
        return "(" + ", ".join(text for text, _ in made) + ",)", tuple(need for _, needs in made for need in needs)
    if name in ("list", "List", "Sequence") and dotted_name(parts[0]) == "float":
        return f"[{FAR}] * {MANY}", ()
    return (EMPTY[name], ()) if name in EMPTY else None


def _made(sources: Sources, scope: Scope, depth: int) -> Made | None:
    assert isinstance(scope.node, ast.ClassDef)
    name, need = scope.node.name, ((scope.module.name, scope.node.name),)
    if is_enum(sources, scope):
        first = members(sources, scope)[:1]
        return (f"{name}.{first[0][0].name}", need) if first else None
    if form_of(sources, scope) not in ("dataclass", "namedtuple", "model", "typeddict"):
        return None
    arguments, needs = [], list(need)
    for statement in scope.node.body:
        if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name) and statement.value is None:
            value = neutral(sources, scope.module, statement.annotation, depth + 1) or ("None", ())
            arguments.append(f"{statement.target.id}={value[0]}")
            needs += value[1]
    return f"{name}({', '.join(arguments)})", tuple(dict.fromkeys(needs))
