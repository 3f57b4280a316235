"""How the code waits, its numbers with units, and what can be set from outside."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.findings import Constant, Parameter, Wait
from pytest_hricdv.extra.draft.reading.classes import form_of
from pytest_hricdv.extra.draft.reading.constants import UnknownValueError, evaluate
from pytest_hricdv.extra.draft.reading.naming import unit_of
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow
from pytest_hricdv.extra.draft.ros.nodes import ros_parameters

VIRTUAL = {"time": "time", "datetime": "time", "sched": "time", "threading": "threading", "queue": "threading",
           "concurrent": "threading", "asyncio": "asyncio"}  # fmt: skip
"""Top-level module that the code imports -> the name under which a testbench simulates it."""

SETTINGS = ("settings", "config", "configuration", "options", "parameters", "params")
"""A dataclass with one of these in its name is one of settings."""


def virtual(sources: Sources) -> tuple[str, ...]:
    """What `Testbench.virtual` has to name."""
    tops = {name.partition(".")[0] for name, _ in sources.outside}
    return tuple(dict.fromkeys(VIRTUAL[top] for top in VIRTUAL if top in tops))


CLOCKS = ("monotonic", "perf_counter", "time", "now_s", "now")
"""Calls that tell the time."""


def waits(sources: Sources, flow: ValueFlow) -> Iterator[Wait]:
    """All calls that wait, and times after which the code does something else: `time.monotonic() - begin > 60`."""
    yield from _time_outs(flow)
    for module, scope, node in flow.nodes:
        if not isinstance(node, ast.Call):
            continue
        call = imported_name(module, node.func)
        kind = _kind(call, node, module)
        if kind:
            bound = _bound(node, call)
            seconds = _seconds(sources, flow, module, scope, bound)
            yield Wait(kind, dotted_name(node.func) or "?", module.place(node), seconds, bound is not None)


def _time_outs(flow: ValueFlow) -> Iterator[Wait]:
    """What is added to a time, and what times that have passed are compared with."""
    compared = {id(side): node for _, _, node in flow.nodes if isinstance(node, ast.Compare)
                for side in (node.left, *node.comparators)}  # fmt: skip
    for module, scope, node in flow.nodes:
        if not isinstance(node, ast.BinOp) or not isinstance(node.op, ast.Add | ast.Sub):
            continue
        other: list[ast.expr] = []
        if isinstance(node.op, ast.Sub) and id(node) in compared and _is_clock(flow, module, scope, node.left):
            test = compared[id(node)]
            other = [side for side in (test.left, *test.comparators) if side is not node]
        elif isinstance(node.op, ast.Add) and _is_clock(flow, module, scope, node.left):
            other = [node.right]
        numbers = [value for part in other for value in flow.constants(part, module, scope)]
        seconds = max((value for value in numbers if isinstance(value, int | float)), default=0.0)
        if seconds > 0:
            yield Wait("time-out", ast.unparse(node), module.place(node), float(seconds), bounded=True)


def _is_clock(flow: ValueFlow, module: Module, scope: Scope | None, node: ast.expr) -> bool:
    """Whether an expression is the time: a call that tells it, or a name of what it told."""
    if isinstance(node, ast.Name) and scope is not None:
        return any(_is_now(origin) for origin, _, _ in flow.expressions(node, module, scope))
    return _is_now(node)


def _is_now(node: ast.AST) -> bool:
    if not isinstance(node, ast.Call) or node.args or node.keywords or not isinstance(node.func, ast.Attribute):
        return False
    return node.func.attr in CLOCKS


def _kind(call: str, node: ast.Call, module: Module) -> str:
    last = call.rpartition(".")[2]
    if call in ("time.sleep",):
        return "time"
    if call.startswith("asyncio.") and last in ("sleep", "wait", "wait_for", "timeout", "gather", "run"):
        return "asyncio"
    if call.startswith("rclpy.") and last.startswith("spin"):
        return "rclpy"
    if last in ("create_timer", "create_rate"):
        return "rclpy"
    if last == "sleep" and isinstance(node.func, ast.Attribute):
        return "clock"
    if last in ("wait", "join", "acquire", "get") and isinstance(node.func, ast.Attribute):
        threaded = any(origin.partition(".")[0] in ("threading", "queue") for origin in module.imports.values())
        has_number = bool(node.args) or any(keyword.arg in ("timeout", "timeout_s") for keyword in node.keywords)
        if last == "get" and (not threaded or len(node.args) > 1 or _is_key(node)):
            return ""
        if last == "join" and node.args and not threaded:
            return ""
        if last in ("join", "acquire"):
            return "threading" if threaded else ""
        return "threading" if threaded and (last == "get" or not has_number) else "bus" if last == "wait" else ""
    return ""


def _is_key(node: ast.Call) -> bool:
    return bool(node.args) and isinstance(node.args[0], ast.Constant) and isinstance(node.args[0].value, str)


def _bound(node: ast.Call, call: str) -> ast.expr | None:
    """The expression of how long it waits at most."""
    for keyword in node.keywords:
        if keyword.arg in ("timeout", "timeout_s", "delay", "timer_period_sec", "timeout_sec"):
            return keyword.value
    if call == "asyncio.wait_for":
        return node.args[1] if len(node.args) > 1 else None
    if call in ("asyncio.wait", "asyncio.gather", "asyncio.run") or call.endswith(
        (".join", ".acquire", ".get", "spin")
    ):
        return None
    return node.args[0] if node.args else None


def _seconds(
    sources: Sources, flow: ValueFlow, module: Module, scope: Scope | None, bound: ast.expr | None
) -> float | None:
    numbers = [value for value in flow.constants(bound, module, scope) if isinstance(value, int | float)]
    return float(max(numbers)) if numbers else None


def constants(sources: Sources) -> Iterator[Constant]:
    """Numbers of modules and classes whose names have a unit."""
    for module in sources.modules:
        for body in (module.tree.body, *(n.body for n in ast.walk(module.tree) if isinstance(n, ast.ClassDef))):
            for statement in body:
                if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value is not None:
                    yield from _constants_of(sources, module, statement)


def _constants_of(sources: Sources, module: Module, statement: ast.Assign | ast.AnnAssign) -> Iterator[Constant]:
    for target in statement.targets if isinstance(statement, ast.Assign) else [statement.target]:
        names = target.elts if isinstance(target, ast.Tuple) else [target]
        is_pair = isinstance(target, ast.Tuple) and isinstance(statement.value, ast.Tuple)
        values = statement.value.elts if is_pair and isinstance(statement.value, ast.Tuple) else [statement.value]
        for name, value in zip(names, values, strict=False):
            if not isinstance(name, ast.Name) or not unit_of(name.id):
                continue
            try:
                number = evaluate(sources, module, value)
            except UnknownValueError:
                continue
            if isinstance(number, int | float) and not isinstance(number, bool):
                yield Constant(name.id, float(number), unit_of(name.id), module.place(statement))


def parameters(sources: Sources, flow: ValueFlow) -> Iterator[Parameter]:
    """Fields of dataclasses of settings, and parameters that ROS 2 nodes declare."""
    for scope in sources.classes:
        assert isinstance(scope.node, ast.ClassDef)
        is_settings = any(word in scope.node.name.lower() for word in SETTINGS)
        if not is_settings or form_of(sources, scope) not in ("dataclass", "model"):
            continue
        for statement in scope.node.body:
            if isinstance(statement, ast.AnnAssign) and isinstance(statement.target, ast.Name):
                name, default = statement.target.id, ast.unparse(statement.value) if statement.value else ""
                written, place = ast.unparse(statement.annotation), scope.module.place(statement)
                yield Parameter(name, scope.node.name, written, default, unit_of(name), place)
    for declared in ros_parameters(flow):
        yield Parameter(declared.name, declared.owner, "", declared.default, unit_of(declared.name), declared.place)
