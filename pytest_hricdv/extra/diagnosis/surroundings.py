"""Surroundings of a statement: its block, its function, and what the code does elsewhere that may be lacking here."""

from __future__ import annotations

import ast
import builtins
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

_PAIRS = (("open", "close"), ("start", "stop"), ("set", "clear"), ("enable", "disable"), ("acquire", "release"))
OPPOSITES = {command: undo for pair in _PAIRS for command, undo in (pair, pair[::-1])}
"""Names of commands that undo each other."""


@dataclass(frozen=True)
class Scope:
    """What is around a statement.

    Args:
        block: the statements that it is one of.
        number: which of them.
        function: that it is in; None outside of functions.
        in_loop: of this function.
        calls: statements elsewhere in the code that call something, the nearest first.
        conditions: of decisions elsewhere in the code, the nearest first.
        returned: what the function returns elsewhere.
    """

    block: list[ast.stmt]
    number: int
    function: ast.FunctionDef | ast.AsyncFunctionDef | None
    in_loop: bool
    calls: Sequence[ast.stmt]
    conditions: Sequence[ast.expr]
    returned: Sequence[ast.expr | None]


def parsed(text: str) -> ast.Module:
    """The tree of a text; an empty one of what is no Python."""
    try:
        return ast.parse(text)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


@dataclass(frozen=True)
class Position:
    """Where a statement stands: its block, its number there, what is around it (the innermost last)."""

    block: list[ast.stmt]
    number: int
    around: tuple[ast.AST, ...]


def position(tree: ast.AST, line: int, around: tuple[ast.AST, ...] = ()) -> Position | None:
    """Of the first statement that begins in a line; None where there is none, or it defines a function or a class.

    Args:
        tree: to look in.
        line: of the text.
        around: what is around the tree.
    """
    for _, value in ast.iter_fields(tree):
        if isinstance(value, list) and value and isinstance(value[0], ast.stmt):
            for number, statement in enumerate(value):
                if statement.lineno == line and not isinstance(statement, ast.FunctionDef | ast.ClassDef):
                    return Position(value, number, (*around, tree))
    for child in ast.iter_child_nodes(tree):
        inner = position(child, line, (*around, tree))
        if inner is not None:
            return inner
    return None


def scope_of(place: Position, trees: Sequence[ast.Module]) -> Scope:
    """What is around a statement.

    Args:
        place: of the statement, in the first of the trees.
        trees: of the code.
    """
    enclosing = [node for node in place.around if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
    function = enclosing[-1] if enclosing else None
    start = place.around.index(function) if function is not None else 0
    in_loop = any(isinstance(node, ast.For | ast.While) for node in place.around[start:])
    if function is None:
        return Scope(place.block, place.number, None, in_loop, (), (), ())
    names = _names(function) | _names(trees[0], deeply=False) | {*dir(builtins)}
    line = place.block[place.number].lineno
    calls: list[ast.stmt] = []
    conditions: list[ast.expr] = []
    for number, tree in enumerate(trees):
        statements = [node for node in ast.walk(tree) if isinstance(node, ast.stmt)]
        for node in sorted(statements, key=lambda node: abs(node.lineno - line) if number == 0 else node.lineno):
            if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call) and _read(node) <= names:
                calls += [node, *_opposites(node, node.value)]
            elif isinstance(node, ast.If | ast.While) and (number > 0 or node.lineno != line):
                conditions += [part for part in _parts(node.test) if _read(part) <= names]
    returned = [node.value for node in ast.walk(function) if isinstance(node, ast.Return)]
    return Scope(
        place.block,
        place.number,
        function,
        in_loop,
        _once(calls),
        _once(conditions),
        _once(returned) if any(value is not None for value in returned) else (None,),
    )


def _opposites(statement: ast.Expr, call: ast.Call) -> Iterator[ast.stmt]:
    """What is opened and never closed has no `close` that could be taken from elsewhere."""
    if isinstance(call.func, ast.Attribute) and call.func.attr in OPPOSITES:
        opposite = ast.Attribute(call.func.value, OPPOSITES[call.func.attr], ast.Load())
        yield ast.copy_location(ast.Expr(ast.Call(opposite, call.args, call.keywords)), statement)


def _parts(test: ast.expr) -> Iterator[ast.expr]:
    """What a condition is made of, and the contrary of each."""
    for part in test.values if isinstance(test, ast.BoolOp) else [test]:
        if not isinstance(part, ast.Constant | ast.NamedExpr):
            yield part
            yield negated(part)


def _names(tree: ast.AST, *, deeply: bool = True) -> set[str]:
    """Names that there are in a function; or, not deeply, that a module defines."""
    names: set[str] = set()
    for node in ast.walk(tree) if deeply else ast.iter_child_nodes(tree):
        if isinstance(node, ast.arg):
            names.add(node.arg)
        elif isinstance(node, ast.Name):
            names.add(node.id)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            names |= {(alias.asname or alias.name).partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.Assign | ast.AnnAssign) and not deeply:
            names |= {target.id for target in ast.walk(node) if isinstance(target, ast.Name)}
    return names


def _read(node: ast.AST) -> set[str]:
    return {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}


Node = TypeVar("Node", bound=ast.AST | None)


def _once(nodes: Iterable[Node]) -> tuple[Node, ...]:
    """Equal ones once."""
    return tuple({"" if node is None else ast.dump(node): node for node in nodes}.values())


def negated(test: ast.expr) -> ast.expr:
    """The contrary of a condition."""
    if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
        return test.operand
    return ast.UnaryOp(ast.Not(), test)
