"""Variables of modules that hold a state, and are looked at in runs: `state = "off"`, `robot = {"state": "idle"}`."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.findings import Machine, Place, State
from pytest_hricdv.extra.draft.reading.constants import Member, is_enum, members
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, texts
from pytest_hricdv.extra.draft.states.holders import STATE_NAMES


def module_machines(sources: Sources, flow: ValueFlow) -> Iterator[Machine]:
    """A machine for each such variable, without its transitions; `held` is source text that reads it."""
    for module in sources.modules:
        for name, statement in module.scope.items():
            if isinstance(statement, ast.Assign | ast.AnnAssign) and any(part in name.lower() for part in STATE_NAMES):
                yield from _machine(module, name, f".{name}", _set(sources, flow, module, name, ""))
        for name, key in _keys(module):
            yield from _machine(module, name, f'.{name}["{key}"]', _set(sources, flow, module, name, key))


def _machine(module: Module, name: str, read: str, states: dict[str, Place]) -> Iterator[Machine]:
    if len(states) > 1:
        listed = tuple(State(text, place, number == 0) for number, (text, place) in enumerate(states.items()))
        place = listed[0].place
        yield Machine(name, "text", listed, (), place, held=f'import_module("{module.name}"){read}')


def _keys(module: Module) -> Iterator[tuple[str, str]]:
    """Dicts of a module that have a key like a state."""
    for name, statement in module.scope.items():
        value = statement.value if isinstance(statement, ast.Assign | ast.AnnAssign) else None
        for key in value.keys if isinstance(value, ast.Dict) else ():
            text = key.value if isinstance(key, ast.Constant) else None
            if isinstance(text, str) and any(part in text.lower() for part in STATE_NAMES):
                yield name, text


def _set(sources: Sources, flow: ValueFlow, module: Module, name: str, key: str) -> dict[str, Place]:
    """The texts that are assigned to a variable, at the top of its module first; with a key, to that of the dict."""
    values: list[tuple[ast.expr, Scope | None]] = []
    for where, scope, node in flow.nodes:
        if where is not module or not isinstance(node, ast.Assign | ast.AnnAssign) or node.value is None:
            continue
        for target in node.targets if isinstance(node, ast.Assign) else [node.target]:
            if key and isinstance(target, ast.Name) and target.id == name and isinstance(node.value, ast.Dict):
                values += [(content, scope) for at, content in zip(node.value.keys, node.value.values, strict=True)
                           if isinstance(at, ast.Constant) and at.value == key]  # fmt: skip
            elif key and isinstance(target, ast.Subscript) and dotted_name(target.value) == name:
                values += [(node.value, scope)] if getattr(target.slice, "value", None) == key else []
            elif not key and isinstance(target, ast.Name) and target.id == name and _is_global(name, scope):
                values.append((node.value, scope))
    known: dict[str, Place] = {}
    for value, scope in values:
        constants = flow.constants(value, module, scope)
        for text, place in texts(constants).items():
            known.setdefault(text, place)
        for enum in {constant.enum for constant in constants if isinstance(constant, Member)}:
            own = next((s for s in sources.classes if s.node.name == enum and is_enum(sources, s)), None)
            for member, at in members(sources, own) if own is not None else ():
                known.setdefault(member.text, own.module.place(at) if own is not None else module.place(at))
    return known


def _is_global(name: str, scope: Scope | None) -> bool:
    return scope is None or any(isinstance(node, ast.Global) and name in node.names for node in ast.walk(scope.node))
