"""`python -m pytest_hricdv init --update`: what the code has that model and testbench lack, and the lines to add.

It compares in a process that configures pytest, so that the testbench is that of a session.
"""

from __future__ import annotations

import ast
import difflib
import os
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv._base.atomic_file import write_text
from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.draft.drift import Drift
from pytest_hricdv.extra.draft.feature import FEATURE, find_drift
from pytest_hricdv.hooks import HOOK
from pytest_hricdv.results import journal
from pytest_hricdv.results.codec import ReportError, load
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.session.run_context import RunContext
from pytest_hricdv.session.serving import UNWARNED, in_session

SUITE = "pseudorandom"
"""Nothing is generated, but a session needs a suite, and this one needs nothing of a testbench."""


def update(folder: Path, *, write: bool) -> int:
    """Compare code and testbench of a project, in a process of its own.

    Args:
        folder: of the project.
        write: whether to change its conftest file; otherwise the change is shown.

    Returns:
        0: no drift; 1: drift; 2 and above: the testbench could not be built, which the process has said.
    """
    command = [sys.executable, "-m", "pytest_hricdv.extra.draft.update", "write" if write else "show"]
    return subprocess.run(command, cwd=folder, check=False).returncode


def compare(context: RunContext, *, write: bool, say: Callable[[str], None]) -> int:
    """Tell the drift, and the change of the conftest file; returns the exit status: 1 where there is drift."""
    tests, of_tests = _tests(context)
    result = find_drift(context, tests, FEATURE.settings(context.options).known)
    for text in (of_tests, *result.problems, *result.outdated):
        if text:
            say(text)
    for drift in result.new:
        say(f"{drift.location or 'conftest.py'}: {drift.text}  [{drift.key}]")
    if result.known:
        say(f"known: {', '.join(drift.key for drift in result.known)}")
    path = _conftest(context)
    before = path.read_text(encoding="utf-8")
    if not result.new:
        say("no drift: testbench and tests have what the code has")
        return 0
    _propose(context, (path, before, add_lines(before, result.new)), write=write, say=say)
    return 1


def _conftest(context: RunContext) -> Path:
    hook = getattr(context.collection.config.hook, HOOK)
    return Path(hook.get_hookimpls()[-1].function.__code__.co_filename)


def _propose(context: RunContext, change: tuple[Path, str, str], *, write: bool, say: Callable[[str], None]) -> None:
    """Show a change of a file, its text before and after; or write it."""
    path, before, after = change
    say("")
    if after == before:
        say("nothing of it is a line of conftest.py: plans and disturbances lead to states, and run hands parameters")
        say("to the code, run.test.run[NAME]; what may be so goes to hri_known_drift, a line each: KIND NAME: reason")
    elif write:
        write_text(path, after)
        say(f"{path}: changed; review it")
    else:
        name = os.path.relpath(path, context.collection.config.invocation_params.dir)
        for line in difference(before, after, name).splitlines():
            say(line)
        say("")
        say("nothing was written: the same with --write changes the file")


def _tests(context: RunContext) -> tuple[tuple[TestResult, ...] | None, str]:
    """The tests of the last report of whole suites, and what is to be said where there are none."""
    folder = context.options.report
    try:
        report = load(folder)
        if report.full_report:
            return load((folder / report.full_report).parent).tests, ""
    except ReportError:
        return None, f"no report in {folder}: run pytest first, and states that no plan leads to are told, too"
    kept = folder / journal.NAME
    if kept.is_file() and not journal.read(kept).is_whole:
        return None, f"the report in {folder} is of a part of the suites: run all tests first, to be told of states"
    return report.tests, ""


# --- the lines


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
        drift: what the code has; messages, values and transitions can be added; the rest is for people.
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
        yield from _add(testbench, "messages", [message.name for message in messages], "(", ",)")
        statement = _statement(tree, testbench)
        for message in messages:
            if message.module:
                text = f"from {message.module} import {message.name}\n{' ' * statement.col_offset}"
                yield _Insertion(statement.lineno, statement.col_offset, text)
    moves = [one.name.partition("->") for one in drift if one.kind == "transition" and one.is_undeclared]
    state = _call(testbench, "StateField")
    if moves and state is not None and isinstance(_keyword(state, "transitions"), ast.Tuple | ast.List):
        entries = [f'("{source}", "{target}")' for source, _, target in moves]
        yield from _add(state, "transitions", entries, "(", ",)")
    fields = _keyword(testbench, "fields")
    for one in drift:
        if one.kind == "value" and isinstance(fields, ast.Dict):
            name, _, text = one.name.partition("=")
            yield from _value(fields, name, text)


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


def _add(call: ast.Call, name: str, entries: Sequence[str], opening: str, closing: str) -> Iterator[_Insertion]:
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


def _value(fields: ast.Dict, name: str, text: str) -> Iterator[_Insertion]:
    for key, declared in zip(fields.keys, fields.values, strict=True):
        is_it = isinstance(key, ast.Constant) and key.value == name
        value = _keyword(declared, "values") if isinstance(declared, ast.Call) else None
        if is_it and isinstance(value, ast.Tuple | ast.List) and value.elts:
            last = value.elts[-1]
            if last.end_lineno is not None and last.end_col_offset is not None:
                yield _Insertion(last.end_lineno, last.end_col_offset, f', "{text}"')


# --- the process


def main() -> None:
    """Compare; arguments are `--write` or nothing, and then those of pytest."""
    write, rest = sys.argv[1] == "write", sys.argv[2:]

    def say(text: str) -> None:
        with suppress(BrokenPipeError):  # of whoever read it: the status says the same
            print(visible(text), flush=True)

    def work(context: RunContext) -> None:
        status = compare(context, write=write, say=say)
        with suppress(BrokenPipeError):
            sys.stdout.flush()
        os._exit(status)

    sys.exit(in_session((f"--hri-suite={SUITE}", *rest, *UNWARNED), work) or 2)


if __name__ == "__main__":
    main()
