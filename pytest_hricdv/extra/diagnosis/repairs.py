"""Repairs: changes to a suspicious statement that might mend a fault.

A fault is what a programmer did wrong or forgot, so repairs are the reverse: another condition, a part of it more or
less, a call more or less, another order, an early return, another number. What is added is taken from the code itself,
because what a function lacks is often written elsewhere (W. Weimer, T. Nguyen, C. Le Goues, S. Forrest: Automatically
Finding Patches Using Genetic Programming, ICSE 2009). A repair that makes tests pass is a hint where the fault is, and
seldom the best way to mend it.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import partial

from pytest_hricdv.coverage.code_map import SourceFile
from pytest_hricdv.coverage.gaps import functions
from pytest_hricdv.extra.diagnosis.surroundings import Scope, negated, parsed, position, scope_of

MOST_ADDED = 6
"""So many calls, or conditions, are tried at one place: the nearest in the text. Chosen: each costs a run."""

_SCALES = (0.8, 1.25, 0.5, 2.0, 0.1, 10.0)
"""A number is changed by these factors: first by those that change least besides."""

_COUNTS = 10
"""Whole numbers below this count something: they are one more or less. Greater ones are changed by factors."""


@dataclass(frozen=True)
class Repair:
    """A change to one statement.

    Args:
        file: name.
        line: first line of the statement.
        function: that it is in.
        operator: the kind of change.
        words: what is changed, as in ``with `a` in place of `b` ``.
        text: of the whole file, changed.
    """

    file: str
    line: int
    function: str
    operator: str
    words: str
    text: str


Change = tuple[str, list[ast.stmt]]
"""What is changed, in words, and the statements that stand in place of the statement."""

Operator = Callable[[ast.stmt, Scope], Iterator[Change]]


def repairs(files: Sequence[SourceFile], file: SourceFile, line: int) -> Iterator[Repair]:
    """The repairs of a statement, those first that mend most.

    Args:
        files: of the code under test: what is added is taken from them.
        file: the statement's.
        line: its first line.
    """
    tree = parsed(file.text)
    place = position(tree, line)
    if place is None:
        return
    name = next(function.name for function in functions(file.text) if line in function)
    scope = scope_of(place, [parsed(other.text) for other in (file, *(other for other in files if other != file))])
    statement = scope.block[scope.number]
    seen = {ast.unparse(tree)}
    for operator, change in OPERATORS.items():
        for words, after in change(statement, scope):
            scope.block[scope.number : scope.number + 1] = after
            text = ast.unparse(ast.fix_missing_locations(tree))
            scope.block[scope.number : scope.number + len(after)] = [statement]
            if text not in seen and _compiles(text):
                seen.add(text)
                yield Repair(file.name, line, name, operator, words, text)


def condition_changed(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """A part of a condition less, or one more, or the contrary."""
    if not isinstance(statement, ast.If | ast.While):
        return
    test = statement.test
    tests: list[ast.expr] = []
    if isinstance(test, ast.BoolOp):
        for number in range(len(test.values)):
            left = test.values[:number] + test.values[number + 1 :]
            tests.append(left[0] if len(left) == 1 else ast.BoolOp(test.op, left))
    tests.append(negated(test))
    for other in scope.conditions[:MOST_ADDED]:
        if ast.dump(other) not in {ast.dump(node) for node in ast.walk(test)}:
            tests += [ast.BoolOp(ast.And(), [other, test]), ast.BoolOp(ast.Or(), [other, test])]
    for new in tests:
        changed = deepcopy(statement)
        changed.test = deepcopy(new)
        yield f"with the condition `{ast.unparse(new)}` in place of `{ast.unparse(test)}`", [changed]


def comparison_changed(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """A limit that belongs to the other side, or a comparison the other way round."""
    yield from _of_nodes(statement, ast.Compare, _compared)


def left_out(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """Something is done that should not be."""
    if scope.function is not None and isinstance(statement, ast.Expr | ast.Assign | ast.AugAssign | ast.Break):
        yield f"without `{_first_line(statement)}`", [ast.Pass()]
    if isinstance(statement, ast.Return) and statement.value is None:
        yield "without `return`", [ast.Pass()]


def call_added(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """Something is not done that should be."""
    if scope.function is None:
        return
    for call in scope.calls[:MOST_ADDED]:
        if ast.dump(call) != ast.dump(statement):
            text, here = ast.unparse(call), _first_line(statement)
            if not isinstance(statement, ast.Return | ast.Break | ast.Continue | ast.Raise):
                yield f"with `{text}` after `{here}`", [statement, deepcopy(call)]
            yield f"with `{text}` before `{here}`", [deepcopy(call), statement]


def ended_early(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """A function, or a pass of a loop, goes on that should end."""
    if scope.function is None or isinstance(statement, ast.Return | ast.Break | ast.Continue | ast.Raise):
        return
    leaving: list[ast.stmt] = [ast.Return(deepcopy(value)) for value in scope.returned[:3]]
    leaving += [ast.Break(), ast.Continue()] if scope.in_loop else []
    for end in leaving:
        if isinstance(statement, ast.If) and not isinstance(statement.body[-1], ast.Return | ast.Raise):
            changed = deepcopy(statement)
            changed.body.append(end)
            yield f"with `{ast.unparse(end)}` where `{ast.unparse(statement.test)}`", [changed]
        for condition in scope.conditions[: MOST_ADDED // 2]:
            guard = ast.If(deepcopy(condition), [end], [])
            yield f"with `{ast.unparse(end)}` before it where `{ast.unparse(condition)}`", [guard, statement]


def guarded(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """Something is done always that should be done under a condition."""
    if isinstance(statement, ast.Expr):
        for condition in scope.conditions[:MOST_ADDED]:
            yield (
                f"with `{ast.unparse(statement)}` only where `{ast.unparse(condition)}`",
                [ast.If(deepcopy(condition), [statement], [])],
            )


def number_changed(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """A number is too large or too small: each is changed a little before one is changed much."""
    for change in range(len(_SCALES)):
        yield from _of_nodes(statement, ast.Constant, partial(_number, change))


def value_changed(statement: ast.stmt, scope: Scope) -> Iterator[Change]:
    """A function returns what it returns elsewhere."""
    if isinstance(statement, ast.Return):
        for value in scope.returned:
            new = ast.Return(deepcopy(value))
            yield f"with `{ast.unparse(new)}` in place of `{ast.unparse(statement)}`", [new]


OPERATORS: dict[str, Operator] = {
    "condition changed": condition_changed,
    "left out": left_out,
    "comparison changed": comparison_changed,
    "number changed": number_changed,
    "call added": call_added,
    "ended early": ended_early,
    "guarded": guarded,
    "value changed": value_changed,
}
"""What a kind of change is called -> the changes; those first that mend most, or are few."""


def _of_nodes(
    statement: ast.stmt, kind: type[ast.expr], changes: Callable[[ast.expr], Iterator[ast.expr]]
) -> Iterator[Change]:
    """Changes to expressions of a statement's own: not of the statements within it."""
    own = [*_own(statement)]
    for number, node in enumerate(own):
        if isinstance(node, kind):
            for new in changes(node):
                changed = deepcopy(statement)
                target = [*_own(changed)][number]
                _replace(changed, target, new)
                yield f"with `{ast.unparse(new)}` in place of `{ast.unparse(node)}`", [changed]


def _own(statement: ast.AST) -> Iterator[ast.expr]:
    for child in ast.iter_child_nodes(statement):
        if not isinstance(child, ast.stmt):
            if isinstance(child, ast.expr):
                yield child
            yield from _own(child)


def _replace(tree: ast.AST, old: ast.expr, new: ast.expr) -> None:
    for node in ast.walk(tree):
        for name, value in ast.iter_fields(node):
            if value is old:
                setattr(node, name, new)
            elif isinstance(value, list) and any(item is old for item in value):
                value[:] = [new if item is old else item for item in value]


_OTHER_SIDE: Mapping[type[ast.cmpop], tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.GtE),
    ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.LtE),
    ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,),
    ast.NotEq: (ast.Eq,),
    ast.Is: (ast.IsNot,),
    ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,),
    ast.NotIn: (ast.In,),
}


def _compared(node: ast.expr) -> Iterator[ast.expr]:
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        for other in _OTHER_SIDE[type(node.ops[0])]:
            yield ast.Compare(node.left, [other()], node.comparators)


def _number(change: int, node: ast.expr) -> Iterator[ast.expr]:
    """A number with the so-manieth change; none where it has fewer."""
    if isinstance(node, ast.Constant) and type(node.value) is float:
        yield ast.Constant(float(f"{node.value * _SCALES[change]:.6g}"))
    elif isinstance(node, ast.Constant) and type(node.value) is int:
        if abs(node.value) >= _COUNTS:
            yield ast.Constant(round(node.value * _SCALES[change]))
        elif change < 2:
            yield ast.Constant(node.value + (1, -1)[change])


def _first_line(statement: ast.stmt) -> str:
    return ast.unparse(statement).splitlines()[0]


def _compiles(text: str) -> bool:
    try:
        compile(text, "", "exec", dont_inherit=True)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True
