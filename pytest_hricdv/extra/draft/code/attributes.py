"""Finds attributes that hold the state of an object: a string, an enumeration, a state object or a behaviour tree.

`AttributeStates` returns each as a `StateMachine` of the draft; machines of libraries are in `states`.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.classes import form_of
from pytest_hricdv.extra.draft.code.constants import Member, members
from pytest_hricdv.extra.draft.code.flow import Flow, last_name
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import CodeLine, State, StateMachine

ATTRIBUTE, OBSERVED = "attribute", "observed"
"""Kinds of a `StateMachine`: the code declares only its states, or not even these (a tree of `py_trees`)."""


class AttributeStates:
    """Finds attributes with a state, in a class and in the objects that it makes."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def machines(self, scope: Scope) -> Iterator[StateMachine]:
        """The machines of a class: its own first; within these, enumerations, then those with most states."""
        for own in (scope, *(part for _, part in self._parts(scope))):
            found = self._machines_of(own)
            ordered = sorted(found, key=lambda pair: (pair[1], len(pair[0].states)), reverse=True)
            yield from (machine for machine, _ in ordered)

    def _machines_of(self, own: Scope) -> Iterator[tuple[StateMachine, bool]]:
        """A class's own machines, each with whether it is an enumeration."""
        for name, assigned in self._values_of(own):
            states, is_enum = self._constant_states(assigned)
            if states or any(self._is_tree(where, value) for where, value in assigned):
                location = next(iter(states.values())) if states else own.module.location(assigned[0][1])
                rows = tuple(State(text, at) for text, at in states.items())
                held = f"{own.node.name}.{name}"
                yield StateMachine(name, ATTRIBUTE if rows else OBSERVED, rows, (), location, "", held), is_enum

    def enumerations(self) -> Iterator[StateMachine]:
        """Enumerations whose members the code assigns to attributes that change."""
        for scope in self._sources.classes:
            yield from (machine for machine, is_enum in self._machines_of(scope) if is_enum)

    def decides(self, scope: Scope, machine: StateMachine) -> bool:
        """Whether a class uses the attribute as a state: compares it, or sets it to objects that are no messages."""
        for name, assigned in self._values_of(scope):
            made = [self._sources.class_of(where.module, getattr(value, "func", None)) for where, value in assigned]
            if name == machine.name and any(own is not None and not form_of(self._sources, own) for own in made):
                return True
        for _, at, node in self._flow.nodes:
            if at is not None and at.owner is scope.node and isinstance(node, ast.Compare | ast.Match):
                sides = [node.left, *node.comparators] if isinstance(node, ast.Compare) else [node.subject]
                if any(name_with_dots(side) == f"self.{machine.name}" for side in sides):
                    return True
        return False

    def path(self, scope: Scope, machine: StateMachine) -> str:
        """The path from the object to the attribute with the state of a machine; empty if there is none."""
        owner, _, attribute = machine.held_in.rpartition(".")
        if not owner:
            return ""
        if owner in {scope.node.name, *(base.node.name for base in self._sources.base_classes(scope))}:
            return attribute
        return next((f"{name}.{attribute}" for name, part in self._parts(scope) if part.node.name == owner), "")

    def _values_of(self, scope: Scope) -> Iterator[tuple[str, list[tuple[Scope, ast.expr]]]]:
        yield from (
            (name, values) for (owner, name), values in self._flow.attributes.items() if owner == id(scope.node)
        )

    def _parts(self, scope: Scope) -> Iterator[tuple[str, Scope]]:
        """Attributes that hold an object of the code, which the class makes, and its class."""
        for name, assigned in self._values_of(scope):
            for where, value in assigned:
                own = self._sources.class_of(where.module, value.func) if isinstance(value, ast.Call) else None
                if own is not None:
                    yield name, own

    def _is_tree(self, where: Scope, value: ast.expr) -> bool:
        """Whether an expression makes something of `py_trees`, or calls a function that is annotated so."""
        called = getattr(value, "func", None)
        own = self._flow.methods.get(last_name(called), []) if called is not None else []
        returned = (resolve_import(function.module, function.node.returns) for function in own)  # type: ignore[union-attr]
        made = [resolve_import(where.module, called), *returned]
        return any(name.startswith("py_trees.") for name in made)

    def _constant_states(self, assigned: list[tuple[Scope, ast.expr]]) -> tuple[dict[str, CodeLine], bool]:
        """Texts or members of one enumeration, where nothing else is assigned; and whether they are members."""
        values = [value for where, expression in assigned
                  for value in self._flow.constants(expression, where.module, where)]  # fmt: skip
        texts = {value.text if isinstance(value, Member) else value: at for value, at in values
                 if isinstance(value, str | Member)}  # fmt: skip
        if len(texts) < 2 or len(texts) != len({str(value) for value, _ in values}) or "" in texts:
            return {}, False
        enums = {value.enum for value, _ in values if isinstance(value, Member)}
        for own in self._sources.classes if len(enums) == 1 else ():
            if own.node.name in enums:
                texts |= {member.text: own.module.location(at) for member, at in members(self._sources, own)
                          if member.text not in texts}  # fmt: skip
        return texts, bool(enums)
