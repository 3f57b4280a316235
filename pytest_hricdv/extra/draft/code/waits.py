"""How the code waits, its numbers with units, and what keeps it from running."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from importlib.machinery import PathFinder

from pytest_hricdv.extra.draft.code.constants import UnknownConstantError, evaluate
from pytest_hricdv.extra.draft.code.flow import Flow
from pytest_hricdv.extra.draft.code.naming import unit_of
from pytest_hricdv.extra.draft.code.sources import Module, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import CodeConstant, Problem, Wait

VIRTUAL = {"time": "time", "datetime": "time", "sched": "time", "threading": "threading", "queue": "threading",
           "concurrent": "threading", "asyncio": "asyncio"}  # fmt: skip
"""Top-level module that the code imports -> the name under which a testbench simulates it."""


def virtual(sources: Sources) -> tuple[str, ...]:
    """The APIs that `VirtualTime.apis` has to name."""
    tops = {name.partition(".")[0] for name, _ in sources.outside}
    return tuple(dict.fromkeys(VIRTUAL[top] for top in VIRTUAL if top in tops))


def waits(flow: Flow) -> Iterator[Wait]:
    """All calls that wait."""
    for module, scope, node in flow.nodes:
        if not isinstance(node, ast.Call):
            continue
        call = resolve_import(module, node.func)
        if _is_wait(call, node, module):
            bound = _time_out(node, call)
            seconds = max(flow.numbers(bound, module, scope), default=None)
            yield Wait(name_with_dots(node.func) or "?", module.location(node), seconds, bound is not None)


def _is_wait(call: str, node: ast.Call, module: Module) -> bool:
    last = call.rpartition(".")[2]
    if not isinstance(node.func, ast.Attribute) or last == "sleep":
        return last == "sleep"
    if call.startswith("asyncio."):
        return last in ("wait", "wait_for", "timeout")
    if last in ("create_timer", "create_rate"):
        return True
    # `get("key")` is of a dict
    is_text = bool(node.args) and isinstance(node.args[0], ast.Constant) and isinstance(node.args[0].value, str)
    is_threaded = any(origin.partition(".")[0] in ("threading", "queue") for origin in module.imports.values())
    return last == "wait" or (is_threaded and last in ("get", "join", "acquire") and not is_text)


def _time_out(node: ast.Call, call: str) -> ast.expr | None:
    """The expression of how long it waits at most."""
    for keyword in node.keywords:
        if keyword.arg in ("timeout", "timeout_s", "delay", "timer_period_sec", "timeout_sec"):
            return keyword.value
    if call == "asyncio.wait_for":
        return node.args[1] if len(node.args) > 1 else None
    if call == "asyncio.wait" or call.endswith((".join", ".acquire", ".get")):
        return None
    return node.args[0] if node.args else None


def constants(sources: Sources) -> Iterator[CodeConstant]:
    """Numbers of modules and classes whose names have a unit."""
    for module in sources.modules:
        for body in (module.tree.body, *(n.body for n in ast.walk(module.tree) if isinstance(n, ast.ClassDef))):
            for statement in body:
                if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
                    yield from _constants_of(sources, module, statement)


def _constants_of(sources: Sources, module: Module, statement: ast.Assign | ast.AnnAssign) -> Iterator[CodeConstant]:
    for target in statement.targets if isinstance(statement, ast.Assign) else [statement.target]:
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        is_pair = isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple)
        values = statement.value.elts if is_pair and isinstance(statement.value, ast.Tuple) else [statement.value]
        for name, value in zip(names, values, strict=False):
            if not isinstance(name, ast.Name) or not unit_of(name.id):
                continue
            try:
                number = evaluate(sources, module, value)
            except UnknownConstantError:
                continue
            if isinstance(number, int | float) and not isinstance(number, bool):
                yield CodeConstant(name.id, float(number), unit_of(name.id), module.location(statement))


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
