"""States that an object holds in an attribute: a text, a member of an enumeration, an object for each state, a tree."""

from __future__ import annotations

import ast
from collections.abc import Iterator

from pytest_hricdv.extra.draft.code.classes import form_of, parse_annotation
from pytest_hricdv.extra.draft.code.constants import Member, assignments, members
from pytest_hricdv.extra.draft.code.flow import Flow, annotation_of, last_name
from pytest_hricdv.extra.draft.code.sources import Scope, Sources, name_with_dots, resolve_import
from pytest_hricdv.extra.draft.code_model import CodeLine, State, StateMachine

ATTRIBUTE, OBSERVED = "attribute", "observed"
"""Kinds of machines whose transitions, or whose states as well, no code declares."""


class AttributeStates:
    """Finds the attributes of a class, and of objects that it makes, that hold a state."""

    def __init__(self, sources: Sources, flow: Flow) -> None:
        self._sources, self._flow = sources, flow

    def machines(self, scope: Scope) -> Iterator[StateMachine]:
        """Those of the class itself first; of these, enumerations, then those with most states."""
        for own in (scope, *(part for _, part in self._parts(scope))):
            found = []
            for name, assigned in self._values_of(own):
                states, is_enum = self._of_constants(assigned)
                states = states or self._of_objects(assigned)
                is_tree = any(self._is_tree(where, value) for where, value in assigned)
                if states or is_tree:
                    location = next(iter(states.values())) if states else own.module.location(assigned[0][1])
                    rows = tuple(State(text, at) for text, at in states.items())
                    held = f"{own.node.name}.{name}"
                    machine = StateMachine(name, ATTRIBUTE if rows else OBSERVED, rows, (), location, "", held)
                    found.append(((is_enum, len(states)), machine))
            yield from (machine for _, machine in sorted(found, key=lambda each: each[0], reverse=True))

    def decides(self, scope: Scope, machine: StateMachine) -> bool:
        """Whether a class compares an attribute of its own: else it is what the object does, and no state."""
        name = f"self.{machine.name}"
        for _, at, node in self._flow.nodes:
            if at is not None and at.owner is scope.node and isinstance(node, ast.Compare | ast.Match):
                sides = [node.left, *node.comparators] if isinstance(node, ast.Compare) else [node.subject]
                if any(name_with_dots(side) == name for side in sides):
                    return True
        return False

    def path(self, scope: Scope, machine: StateMachine) -> str:
        """From the object to the attribute that holds the state of a machine; empty where there is no way."""
        owner, _, attribute = machine.held_in.rpartition(".")
        if not owner:
            return ""
        if owner in {scope.node.name, *(base.node.name for base in self._sources.base_classes(scope))}:
            return attribute
        return next((f"{name}.{attribute}" for name, part in self._parts(scope) if part.node.name == owner), "")

    def _values_of(self, scope: Scope) -> Iterator[tuple[str, list[tuple[Scope, ast.expr]]]]:
        yield from ((name, each) for (owner, name), each in self._flow.attributes.items() if owner == id(scope.node))

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
        made = [resolve_import(where.module, called), *(resolve_import(each.module, each.node.returns) for each in own)]  # type: ignore[union-attr]
        return any(name.startswith("py_trees.") for name in made)

    def _of_constants(self, assigned: list[tuple[Scope, ast.expr]]) -> tuple[dict[str, CodeLine], bool]:
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

    def _of_objects(self, assigned: list[tuple[Scope, ast.expr]]) -> dict[str, CodeLine]:
        """Classes of the code with a base in common, one for each state: by their attribute `name`, or their own."""
        return {_name_of(each): each.location for each in self._family(assigned)}

    def first_objects(self, scope: Scope) -> dict[str, Scope]:
        """Base class of states -> the first of them, where an object is given the state that it begins in."""
        families = [self._family(assigned) for _, assigned in self._values_of(scope)]
        return {base.node.name: family[0] for family in families if family
                for base in self._sources.base_classes(family[0])}  # fmt: skip

    def _family(self, assigned: list[tuple[Scope, ast.expr]]) -> list[Scope]:
        changes = [where for where, _ in assigned if where.node.name != "__init__"]
        kinds = [kind for where, value in assigned for kind in self._kinds(where, value)] if changes else []
        for kind in kinds:
            for base in (kind, *self._sources.base_classes(kind)):
                family = [each for each in self._sources.classes
                          if any(above.node is base.node for above in self._sources.base_classes(each))]  # fmt: skip
                if len(family) > 1 and not form_of(self._sources, base):
                    return family
        return []

    def _kinds(self, where: Scope, value: ast.expr) -> Iterator[Scope]:
        """The class of an expression, as called or annotated: `Idle(self)`, `state: State`, `kind: type[State]`."""
        called = value.func if isinstance(value, ast.Call) else value
        annotation = None
        if isinstance(called, ast.Name) and not isinstance(where.node, ast.ClassDef):
            annotation = parse_annotation(annotation_of(where.node, called.id))
        if isinstance(annotation, ast.Subscript) and name_with_dots(annotation.value).lower().endswith("type"):
            annotation = annotation.slice
        for expression in (called if isinstance(value, ast.Call) else None, annotation):
            own = self._sources.class_of(where.module, expression)
            if own is not None:
                yield own


def _name_of(scope: Scope) -> str:
    for statement in scope.node.body:
        for target, value in assignments(statement):
            if name_with_dots(target) == "name" and isinstance(value, ast.Constant) and isinstance(value.value, str):
                return value.value
    return scope.node.name
