"""Finds how long the code waits at most (`time_outs`), and what keeps it from running unchanged (`problems`)."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import PathFinder

from pytest_hricdv.extra.draft.code.constants import assignments
from pytest_hricdv.extra.draft.code.flow import Flow, last_name
from pytest_hricdv.extra.draft.code.naming import unit_of
from pytest_hricdv.extra.draft.code.sources import Module, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import CodeLine, Problem

WAITS = {"sleep": 0, "wait": 0, "timeout": 0, "create_timer": 0, "wait_for": 1}
"""Function that waits -> position of its time-out among the arguments."""

KEYWORDS = ("timeout", "timeout_s", "delay", "timer_period_sec", "timeout_sec")
"""Keyword arguments with a time-out."""


def time_outs(flow: Flow) -> Iterator[tuple[float, CodeLine]]:
    """How long calls wait at most, and the constants whose names say that they are seconds (s)."""
    for module, scope, node in flow.nodes:
        bounds: list[ast.expr] = []
        if isinstance(node, ast.Call):
            place = WAITS.get(last_name(node.func), len(node.args))
            named = [keyword.value for keyword in node.keywords if keyword.arg in KEYWORDS]
            bounds = named or node.args[place : place + 1]
        elif scope is None:
            bounds = [value for target, value in assignments(node) if unit_of(last_name(target)) == "s"]
        found = (number for bound in bounds for number in flow.numbers(bound, module, scope))
        yield from ((number, module.location(node)) for number in found)


def problems(sources: Sources, flow: Flow) -> Iterator[Problem]:
    """Files that cannot be read, modules that are not installed, and the first place where a terminal is read."""
    yield from sources.problems
    guarded = find_guarded_imports(sources)
    seen: set[str] = set()
    for dotted, location in sources.outside:
        top = dotted.partition(".")[0]
        if top in guarded or top in sys.stdlib_module_names or not top:
            continue
        absent = _absent_part(dotted, [str(sources.root), *sys.path])
        if absent and absent not in seen:
            seen.add(absent)
            text = f"`{absent}` is not installed here: the draft replaces it by a stand-in; better install it"
            yield Problem("missing module", text, location)
    for module, _, node in flow.nodes:
        call = resolve_import(module, node.func) if isinstance(node, ast.Call) else resolve_import(module, node)
        if (isinstance(node, ast.Call) and call == "input") or (
            isinstance(node, ast.Attribute) and call == "sys.stdin"
        ):
            text = (
                "reads a terminal, at which nobody types in the draft: docs/bring-your-code.md says how a person does"
            )
            yield Problem("terminal", f"{text} (`run.terminal`)", module.location(node))
            return


def _absent_part(dotted: str, folders: Sequence[str]) -> str:
    """The first module of a dotted name that is not installed, as `google.auth`; empty if all are, or it is unknown."""
    name, places = "", [*folders]
    for part in dotted.split("."):
        name = f"{name}.{part}".lstrip(".")
        spec = PathFinder.find_spec(name, places)
        if spec is None:
            return name
        if spec.origin is not None or spec.submodule_search_locations is None:
            return ""  # only a namespace has nothing but modules
        places = [*spec.submodule_search_locations]
    return ""


def find_guarded_imports(sources: Sources) -> set[str]:
    """Top-level names that the code imports and runs without: see `_imports_with_fallback`."""
    return {name for module in sources.modules for name in _imports_with_fallback(module)}


_CATCHING = ("ImportError", "ModuleNotFoundError", "Exception", "BaseException")


def _is_guard(node: ast.AST) -> bool:
    """Whether a statement continues where an import in it fails, or is for type checkers only."""
    caught: list[ast.expr | None] = []
    if isinstance(node, ast.Try):
        caught = [handler.type for handler in node.handlers]
    elif isinstance(node, ast.With):
        calls = [item.context_expr for item in node.items if isinstance(item.context_expr, ast.Call)]
        caught = [arg for call in calls if name_with_dots(call.func).endswith("suppress") for arg in call.args]
    elif isinstance(node, ast.If):
        return name_with_dots(node.test).endswith("TYPE_CHECKING")
    return any(kind is None or any(name in ast.unparse(kind) for name in _CATCHING) for kind in caught)


def _imports_with_fallback(module: Module) -> Iterator[str]:
    """Optional imports of a module, within `try: ... except ImportError` and the like."""
    for node in ast.walk(module.tree):
        if isinstance(node, ast.Try | ast.With | ast.If) and _is_guard(node):
            for statement in (part for body in node.body for part in ast.walk(body)):
                if isinstance(statement, ast.Import):
                    yield from (alias.name.partition(".")[0] for alias in statement.names)
                elif isinstance(statement, ast.ImportFrom) and statement.module:
                    yield statement.module.partition(".")[0]
