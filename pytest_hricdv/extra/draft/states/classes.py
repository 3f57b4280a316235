"""State machines of classes: a class for each state, whose methods make the next one (the state pattern)."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.found.findings import Machine, Place, State, Transition
from pytest_hricdv.extra.draft.reading.sources import Scope, Sources
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow
from pytest_hricdv.extra.draft.states.holders import STATE_NAMES

KIND = "classes"


def class_machines(sources: Sources, flow: ValueFlow) -> Iterator[Machine]:
    """A machine for each attribute that holds an instance of a class for each state.

    Its first state is made where the attribute is set in its class, and a state follows another where a method of that
    makes it. States have a base class of the code in common, or the methods that are called on the attribute.
    """
    for (owner, attribute), values in flow.attributes.items():
        if not any(part in attribute.lower() for part in STATE_NAMES):
            continue
        first = [own for at, value in values if (own := _made(sources, at, value)) is not None]
        holder = next((at for at, _ in values if at.owner is not None and at.owner.name == owner), None)
        if first and holder is not None:
            machine = _walked(sources, flow, first, _called_on(flow, attribute), f"{owner}.{attribute}", holder)
            if len(machine.states) > 1 and machine.transitions:
                yield machine


def _walked(
    sources: Sources, flow: ValueFlow, first: list[Scope], methods: set[str], held: str, holder: Scope
) -> Machine:
    """All states that can be reached from the first ones."""
    states: dict[int, State] = {}
    moves: dict[tuple[str, str], Place] = {}
    waiting = list(first)
    initial = first[0].node
    while waiting:
        scope = waiting.pop(0)
        if id(scope.node) in states:
            continue
        assert isinstance(scope.node, ast.ClassDef)
        states[id(scope.node)] = State(scope.node.name, scope.place, scope.node is initial)
        for following, place in _following(sources, flow, scope, methods):
            assert isinstance(following.node, ast.ClassDef)
            moves.setdefault((scope.node.name, following.node.name), place)
            waiting.append(following)
    transitions = tuple(Transition(source, target, place) for (source, target), place in moves.items())
    name = held.partition(".")[0]
    return Machine(name, KIND, tuple(states.values()), transitions, first[0].place, held=f"{holder.module.name}:{held}")


def _following(sources: Sources, flow: ValueFlow, scope: Scope, methods: set[str]) -> Iterator[tuple[Scope, Place]]:
    """The states that methods of a state make or return, its inherited ones included, each with its place."""
    bases = sources.base_classes(scope)
    family = {id(base.node) for base in bases}
    for method in sources.functions:
        if method.owner is not scope.node and all(method.owner is not base.node for base in bases):
            continue
        for node in ast.walk(method.node):
            own = _made(sources, method, node.value if isinstance(node, ast.Return) else node)
            if own is None or own.node is scope.node:
                continue
            has_methods = methods and methods <= {m.node.name for m in sources.functions if m.owner is own.node}
            if family & {id(base.node) for base in sources.base_classes(own)} or has_methods:
                yield own, method.module.place(node)


def _made(sources: Sources, at: Scope, value: ast.AST | None) -> Scope | None:
    """The class of the code that an expression makes: `Idle()`."""
    return sources.class_of(at.module, value.func) if isinstance(value, ast.Call) else None


def _called_on(flow: ValueFlow, attribute: str) -> set[str]:
    """The methods that are called on an attribute: `self.state.run(self)`."""
    return {
        node.func.attr
        for _, _, node in flow.nodes
        if isinstance(node, ast.Call)
        and isinstance(node.func, ast.Attribute)
        and isinstance(node.func.value, ast.Attribute)
        and node.func.value.attr == attribute
    }
