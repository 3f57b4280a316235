"""The lines that a testbench lacks, as a change of its conftest file: all else of the text stays as it is."""

from __future__ import annotations

import ast
import difflib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from pytest_hricdv.extra.draft.drift import Drift


@dataclass(frozen=True)
class _Insertion:
    """A text that comes into a place (line from 1, column from 0) of another one."""

    line: int
    column: int
    text: str


def add_lines(conftest: str, drift: Sequence[Drift]) -> str:
    """The text of a conftest file with what its testbench lacks; unchanged where there is no place for it.

    Args:
        conftest: the text of the file.
        drift: what the code has; messages, values, transitions and parameters can be added, states cannot.
    """
    try:
        tree = ast.parse(conftest)
    except SyntaxError:
        return conftest
    made = [*_insertions(tree, drift)]
    lines = conftest.splitlines(keepends=True)
    for insertion in sorted(made, key=lambda one: (one.line, one.column), reverse=True):
        line = lines[insertion.line - 1]
        at = len(line.encode()[: insertion.column].decode())  # columns of a tree count bytes
        lines[insertion.line - 1] = line[:at] + insertion.text + line[at:]
    return "".join(lines)


def difference(before: str, after: str, name: str) -> str:
    """The change as a unified diff, which `git apply` or `patch` takes."""
    texts = before.splitlines(keepends=True), after.splitlines(keepends=True)
    return "".join(difflib.unified_diff(*texts, f"a/{name}", f"b/{name}"))


def _insertions(tree: ast.Module, drift: Sequence[Drift]) -> Iterator[_Insertion]:
    testbench = _call(tree, "Testbench")
    if testbench is None:
        return
    messages = [one.message for one in drift if one.message is not None]
    if messages:
        yield from _added(testbench, "messages", [message.name for message in messages], "(", ",)")
        statement = _statement(tree, testbench)
        for message in messages:
            if message.module:
                text = f"from {message.module} import {message.name}\n{' ' * statement.col_offset}"
                yield _Insertion(statement.lineno, statement.col_offset, text)
    moves = [one.name.partition("->") for one in drift if one.kind == "transition" and one.is_undeclared]
    if moves and isinstance(_keyword(testbench, "transitions"), ast.Tuple | ast.List):
        entries = [f'("{source}", "{target}")' for source, _, target in moves]
        yield from _added(testbench, "transitions", entries, "(", ",)")
    values = _keyword(testbench, "values")
    for one in drift:
        if one.kind == "value" and isinstance(values, ast.Dict):
            name, _, text = one.name.partition("=")
            yield from _value(values, name, text)
    concretization = _call(tree, "Concretization")
    parameters = [one.parameter for one in drift if one.parameter is not None]
    if parameters and concretization is not None:
        entries = [
            f'"{parameter.name}": Range({_ends(parameter.default)}, "{parameter.unit}")' for parameter in parameters
        ]
        yield from _added(concretization, "run", entries, "{", "}")


def _call(tree: ast.AST, name: str) -> ast.Call | None:
    calls = (node for node in ast.walk(tree) if isinstance(node, ast.Call))
    return next((call for call in calls if ast.unparse(call.func).rpartition(".")[2] == name), None)


def _keyword(call: ast.Call, name: str) -> ast.expr | None:
    return next((keyword.value for keyword in call.keywords if keyword.arg == name), None)


def _statement(tree: ast.Module, node: ast.AST) -> ast.stmt:
    """The innermost statement around a node."""
    around = [
        statement for statement in ast.walk(tree) if isinstance(statement, ast.stmt) and node in {*ast.walk(statement)}
    ]
    return max(around, key=lambda statement: statement.lineno)


def _added(call: ast.Call, name: str, entries: Sequence[str], opening: str, closing: str) -> Iterator[_Insertion]:
    """Entries at the end of a tuple, list, set or dict that a keyword has; or the keyword with them."""
    value = _keyword(call, name)
    if isinstance(value, ast.Tuple | ast.List | ast.Dict):
        items = value.values if isinstance(value, ast.Dict) else value.elts
        first = value.keys[-1:] if isinstance(value, ast.Dict) else items[-1:]
        if items and first[0] is not None:
            yield _after(items[-1], entries, first[0].col_offset if items[-1].lineno > value.lineno else None)
        return
    arguments = [*call.args, *(keyword.value for keyword in call.keywords)]
    if value is None and arguments:
        indent = call.keywords[-1].col_offset if call.keywords and call.keywords[-1].lineno > call.lineno else None
        yield _after(arguments[-1], [f"{name}={opening}{', '.join(entries)}{closing}"], indent)


def _after(node: ast.expr, entries: Sequence[str], indent: int | None) -> _Insertion:
    """Entries after another one: in lines of their own with this indent, or in its line."""
    assert node.end_lineno is not None, "it was parsed"
    assert node.end_col_offset is not None, "it was parsed"
    separator = ", " if indent is None else f",\n{' ' * indent}"
    return _Insertion(node.end_lineno, node.end_col_offset, "".join(f"{separator}{entry}" for entry in entries))


def _value(values: ast.Dict, name: str, text: str) -> Iterator[_Insertion]:
    for key, value in zip(values.keys, values.values, strict=True):
        is_it = isinstance(key, ast.Constant) and key.value == name
        if is_it and isinstance(value, ast.Tuple | ast.List) and value.elts:
            last = value.elts[-1]
            if last.end_lineno is not None and last.end_col_offset is not None:
                yield _Insertion(last.end_lineno, last.end_col_offset, f', "{text}"')


def _ends(default: str) -> str:
    """Ends of a range around a default: half and twice of it (for a person to set)."""
    try:
        value = float(default)
    except ValueError:
        value = 1.0
    return f"{value / 2:g}, {value * 2:g}"
