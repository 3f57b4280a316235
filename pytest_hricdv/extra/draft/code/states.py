"""`StateMachines`: reads machines that the code declares with the libraries `transitions` and `python-statemachine`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.code.constants import (
    Member,
    Reference,
    UnknownConstantError,
    evaluate,
    members,
)
from pytest_hricdv.extra.draft.code.flow import Flow
from pytest_hricdv.extra.draft.code.sources import Module, Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import CodeLine, State, StateMachine, Transition

MACHINE_ARGUMENTS = ("model", "states", "initial", "transitions")
"""Positional parameters of `transitions.Machine`, in their order."""

TRANSITION_ARGUMENTS = ("trigger", "source", "dest")


@dataclass
class _Builder:
    """A machine while it is read."""

    name: str
    kind: str
    location: CodeLine
    states: dict[str, State] = field(default_factory=dict)
    transitions: list[Transition] = field(default_factory=list)
    held_in: str = ""

    def add_state(self, name: str, location: CodeLine) -> None:
        """Add a state, once."""
        self.states.setdefault(name, State(name, location))

    def add_transition(self, source: str, target: str, location: CodeLine) -> None:
        """Add a transition, once."""
        if all((source, target) != (other.source, other.target) for other in self.transitions):
            self.transitions.append(Transition(source, target, location))

    def build(self) -> StateMachine:
        """The machine that was read."""
        states, transitions = tuple(self.states.values()), tuple(self.transitions)
        return StateMachine(self.name, self.kind, states, transitions, self.location, held_in=self.held_in)


class StateMachines:
    """Finds machines of both libraries; those that are plain attributes are in `attributes`."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def machines(self) -> Iterator[StateMachine]:
        """All machines, in the order of the code."""
        yield from self._transitions_library()
        for scope in self._sources.classes:
            bases = self._sources.bases(scope)
            if any(base.startswith("statemachine.") for base in bases):
                yield from self._state_classes(scope)

    # --- transitions

    def _transitions_library(self) -> Iterator[StateMachine]:
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Call):
                continue
            owner = scope.owner if scope is not None else None
            is_base = name_with_dots(node.func).endswith(".__init__") or _is_super(node)
            own = self._sources.class_of(module, node.func)
            made = Scope(module, owner) if is_base and owner is not None else own
            names = (resolve_import(module, node.func), *(self._sources.bases(made) if made is not None else ()))
            if any(name.startswith("transitions.") and name.endswith("Machine") for name in names):
                machine = self._read(module, scope, node, owner)
                yield from [machine] if machine.states else []

    def _read(self, module: Module, scope: Scope | None, node: ast.Call, owner: ast.ClassDef | None) -> StateMachine:
        arguments = _arguments(node, MACHINE_ARGUMENTS)
        builder = _Builder(owner.name if owner else "machine", "transitions", module.location(node))
        model = arguments.get("model")
        model = model.elts[0] if isinstance(model, ast.List) and model.elts else model
        holder = self._flow.owner_of(model, module, scope) if model is not None else owner
        if holder is not None:
            builder.held_in = f"{holder.name}.state"
        states = arguments.get("states")
        for value in self._values(states, module, scope):
            self._add_states(builder, value, module.location(states or node))
        initial = self._first(arguments.get("initial"), module, scope)
        if initial is None and "initial" not in arguments and builder.states:
            initial = "initial"
        if initial is not None:
            builder.add_state(_state(initial), module.location(arguments.get("initial") or node))
        for value in self._values(arguments.get("transitions"), module, scope):
            for row in value if isinstance(value, tuple) else ():
                self._add_row(builder, row, module.location(arguments["transitions"]))
        return builder.build()

    def _add_states(self, builder: _Builder, value: Any, location: CodeLine) -> None:
        rows = value if isinstance(value, tuple) else (value,)
        if isinstance(value, Reference):
            rows = tuple(member for scope in self._sources.classes if scope.node.name == value.name
                         for member, _ in members(self._sources, scope))  # fmt: skip
        for row in rows:
            if isinstance(row, dict):
                name = _state(row.get("name", ""))
                builder.add_state(name, location)
            elif isinstance(row, str | Member):
                builder.add_state(_state(row), location)

    def _add_row(self, builder: _Builder, row: Any, location: CodeLine) -> None:
        content = row
        if isinstance(content, tuple) and len(content) >= 3:
            content = dict(zip(TRANSITION_ARGUMENTS, content, strict=False))
        if not isinstance(content, dict):
            return
        sources, target = content.get("source"), content.get("dest")
        if sources is None or target is None:
            return
        every = [_state(source) for source in (sources if isinstance(sources, tuple) else (sources,))]
        if every == ["*"]:
            every = list(builder.states)
        for source in every:
            into = source if target == "=" else _state(target)
            for name in (source, into):
                if name not in builder.states:
                    builder.add_state(name, location)
            builder.add_transition(source, into, location)

    # --- python-statemachine

    def _state_classes(self, scope: Scope) -> Iterator[StateMachine]:
        assert isinstance(scope.node, ast.ClassDef)
        builder = _Builder(scope.node.name, "python-statemachine", scope.location)
        builder.held_in = f"{scope.node.name}.current_state"
        events: list[ast.expr] = []
        for statement in scope.node.body:
            if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                name, value = statement.targets[0].id, statement.value
                origin = resolve_import(scope.module, value.func) if isinstance(value, ast.Call) else ""
                if isinstance(value, ast.Call) and origin.startswith("statemachine.") and origin.endswith(".State"):
                    builder.add_state(name, scope.module.location(statement))
                else:
                    events.append(value)
            elif isinstance(statement, ast.Expr):
                events.append(statement.value)
        for value in events:
            for source, target in _moves(value, list(builder.states)):
                if source in builder.states and target in builder.states:
                    builder.add_transition(source, target, scope.module.location(value))
        if builder.states:
            yield builder.build()

    # --- values

    def _values(self, node: ast.AST | None, module: Module, scope: Scope | None) -> list[Any]:
        return self._flow.values(node, module, scope)

    def _first(self, node: ast.AST | None, module: Module, scope: Scope | None) -> Any:
        if node is None:
            return None
        try:
            return evaluate(self._sources, module, node)
        except UnknownConstantError:
            values = self._values(node, module, scope)
            return values[0] if values else None


def _moves(value: ast.expr, states: list[str]) -> Iterator[tuple[str, str]]:
    """Pairs of states of `a.to(b) | b.from_(c)`, also within `Event(...)`."""
    if isinstance(value, ast.BinOp):
        yield from _moves(value.left, states)
        yield from _moves(value.right, states)
    elif isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute):
        owner, called = value.func.value, value.func.attr
        own = name_with_dots(owner).rpartition(".")[2]
        others = [name_with_dots(argument).rpartition(".")[2] for argument in value.args]
        if called == "to":
            yield from ((own, other) for other in others)
        elif called == "from_":
            yield from ((other, own) for other in others)
        elif called == "itself":
            state = name_with_dots(owner).split(".")[-2:]
            yield (state[0], state[0])
        elif called == "any":
            target = name_with_dots(owner).split(".")[0]
            yield from ((state, target) for state in states if state != target)
    elif isinstance(value, ast.Call):
        for argument in value.args:
            yield from _moves(argument, states)


def _arguments(node: ast.Call, names: tuple[str, ...]) -> dict[str, ast.expr]:
    arguments = dict(zip(names, node.args, strict=False))
    if isinstance(node.func, ast.Attribute) and name_with_dots(node.func).endswith("Machine.__init__"):
        arguments = dict(zip(names, node.args[1:], strict=False))
    return arguments | {keyword.arg: keyword.value for keyword in node.keywords if keyword.arg}


def _is_super(node: ast.Call) -> bool:
    return (
        isinstance(node.func, ast.Attribute)
        and node.func.attr == "__init__"
        and isinstance(node.func.value, ast.Call)
        and name_with_dots(node.func.value.func) == "super"
    )


def _name(value: Any) -> str:
    return value.name if isinstance(value, Member | Reference) else str(value)


def _state(value: Any) -> str:
    """The state as `transitions` reports it: a member of an enumeration stays one, and is recorded as by `text_of`."""
    return value.text if isinstance(value, Member) else _name(value)
