"""State machines written with a library: `transitions`, `python-statemachine`, SMACH, YASMIN, `py_trees`."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.found.findings import Machine, Place, State, Transition
from pytest_hricdv.extra.draft.reading.constants import Member, Reference, UnknownValueError, evaluate, is_enum, members
from pytest_hricdv.extra.draft.reading.sources import Module, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow

MACHINE_ARGUMENTS = ("model", "states", "initial", "transitions")
"""Positional parameters of `transitions.Machine`, in their order."""

TRANSITION_ARGUMENTS = ("trigger", "source", "dest")


@dataclass
class Growing:
    """A machine while it is read."""

    name: str
    kind: str
    place: Place
    states: dict[str, State] = field(default_factory=dict)
    transitions: list[Transition] = field(default_factory=list)
    held: str = ""

    def add_state(self, name: str, place: Place, initial: bool = False, final: bool = False) -> None:
        """Add a state, or what is new about one."""
        before = self.states.get(name)
        if before is not None:
            initial, final, place = initial or before.initial, final or before.final, before.place
        self.states[name] = State(name, place, initial, final)

    def add_transition(self, source: str, target: str, place: Place, event: str = "") -> None:
        """Add a transition, once."""
        if all((source, target) != (other.source, other.target) for other in self.transitions):
            self.transitions.append(Transition(source, target, place, event))

    def done(self) -> Machine:
        """What was read."""
        states, transitions = tuple(self.states.values()), tuple(self.transitions)
        return Machine(self.name, self.kind, states, transitions, self.place, held=self.held)


class LibraryMachines:
    """Finds the machines of libraries."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow

    def machines(self) -> Iterator[Machine]:
        """All of them, in the order of the code."""
        yield from self._transitions_library()
        for scope in self._sources.classes:
            bases = self._sources.bases(scope)
            if any(base.startswith("statemachine.") for base in bases):
                yield from self._state_classes(scope)
        yield from self._with_outcomes()
        yield from self._trees()

    # --- transitions

    def _transitions_library(self) -> Iterator[Machine]:
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Call):
                continue
            origin = imported_name(module, node.func)
            owner = scope.owner if scope is not None else None
            is_base = (owner is not None and dotted_name(node.func).rpartition(".")[2] == "__init__") or _is_super(node)
            if origin.startswith("transitions.") and origin.rpartition(".")[2].endswith("Machine"):
                yield self._read(module, scope, node, owner)
            elif is_base and owner is not None:
                bases = self._sources.bases(Scope(module, owner))
                if any(base.startswith("transitions.") and base.endswith("Machine") for base in bases):
                    yield self._read(module, scope, node, owner)

    def _read(self, module: Module, scope: Scope | None, node: ast.Call, owner: ast.ClassDef | None) -> Machine:
        arguments = _arguments(node, MACHINE_ARGUMENTS)
        growing = Growing(owner.name if owner else "machine", "transitions", module.place(node))
        is_own = dotted_name(arguments.get("model")) in ("self", "") and owner is not None
        if is_own and owner is not None:
            attribute = self._text(arguments.get("model_attribute"), module, scope) or "state"
            growing.held = f"{module.name}:{owner.name}.{attribute}"
        states = arguments.get("states")
        for value in self._values(states, module, scope):
            self._add_states(growing, value, module.place(states or node), "")
        initial = self._first(arguments.get("initial"), module, scope)
        if initial is None and "initial" not in arguments and growing.states:
            initial = "initial"
        if initial is not None:
            growing.add_state(_state(initial), module.place(arguments.get("initial") or node), initial=True)
        for value in self._values(arguments.get("transitions"), module, scope):
            for row in value if isinstance(value, tuple) else ():
                self._add_row(growing, row, module.place(arguments["transitions"]))
        self._calls_on(growing, module, scope, owner)
        return growing.done()

    def _add_states(self, growing: Growing, value: Any, place: Place, prefix: str) -> None:
        rows = value if isinstance(value, tuple) else (value,)
        if isinstance(value, Reference):
            rows = tuple(member for scope in self._sources.classes if scope.node.name == value.name
                         for member, _ in members(self._sources, scope))  # fmt: skip
        for row in rows:
            content = dict(row.pairs) if hasattr(row, "pairs") else row
            if isinstance(content, dict):
                name = prefix + _state(content.get("name", ""))
                growing.add_state(name, place, final=bool(content.get("final")))
                if content.get("children"):
                    self._add_states(growing, content["children"], place, name + "_")
                for inner in content.get("transitions", ()) or ():
                    self._add_row(growing, inner, place, name + "_")
            elif isinstance(content, str | Member):
                growing.add_state(prefix + _state(content), place)

    def _add_row(self, growing: Growing, row: Any, place: Place, prefix: str = "") -> None:
        content = dict(row.pairs) if hasattr(row, "pairs") else row
        if isinstance(content, tuple) and len(content) >= 3:
            content = dict(zip(TRANSITION_ARGUMENTS, content, strict=False))
        if not isinstance(content, dict):
            return
        sources, target, event = content.get("source"), content.get("dest"), _name(content.get("trigger", ""))
        if sources is None or target is None:
            return
        every = [prefix + _state(source) for source in (sources if isinstance(sources, tuple) else (sources,))]
        if every == [prefix + "*"]:
            every = list(growing.states)
        for source in every:
            into = source if target == "=" else prefix + _state(target)
            for name in (source, into):
                if name not in growing.states:
                    growing.add_state(name, place)
            growing.add_transition(source, into, place, event)

    def _calls_on(self, growing: Growing, module: Module, scope: Scope | None, owner: ast.ClassDef | None) -> None:
        """`machine.add_transition(...)`, `add_states`, `add_ordered_transitions` in the same class or module."""
        for where, at, node in self._flow.nodes:
            if not isinstance(node, ast.Call) or where is not module or (at.owner if at else None) is not owner:
                continue
            called = node.func.attr if isinstance(node.func, ast.Attribute) else ""
            if called == "add_transition":
                arguments = _arguments(node, TRANSITION_ARGUMENTS)
                row = {name: self._first(arguments.get(name), where, at) for name in TRANSITION_ARGUMENTS}
                self._add_row(growing, row, where.place(node))
            elif called == "add_transitions" and node.args:
                for value in self._values(node.args[0], where, at):
                    for row in value if isinstance(value, tuple) else ():
                        self._add_row(growing, row, where.place(node))
            elif called in ("add_states", "add_state") and node.args:
                for value in self._values(node.args[0], where, at):
                    self._add_states(growing, value, where.place(node), "")
            elif called == "add_ordered_transitions":
                names = list(growing.states)
                loop = self._first(next((k.value for k in node.keywords if k.arg == "loop"), None), where, at)
                for source, target in zip(names, names[1:] + (names[:1] if loop is not False else []), strict=False):
                    growing.add_transition(source, target, where.place(node), "next_state")

    # --- python-statemachine

    def _state_classes(self, scope: Scope) -> Iterator[Machine]:
        assert isinstance(scope.node, ast.ClassDef)
        growing = Growing(scope.node.name, "python-statemachine", scope.place)
        growing.held = f"{scope.module.name}:{scope.node.name}.current_state"
        events: list[tuple[str, ast.expr]] = []
        for statement in scope.node.body:
            if isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name):
                name, value = statement.targets[0].id, statement.value
                origin = imported_name(scope.module, value.func) if isinstance(value, ast.Call) else ""
                if isinstance(value, ast.Call) and origin.startswith("statemachine.") and origin.endswith(".State"):
                    flags = {k.arg: getattr(k.value, "value", None) for k in value.keywords}
                    place = scope.module.place(statement)
                    growing.add_state(name, place, flags.get("initial") is True, flags.get("final") is True)
                elif isinstance(value, ast.Call) and origin.endswith("States.from_enum"):
                    self._states_of_enum(growing, scope.module, value)
                else:
                    events.append((name, value))
            elif isinstance(statement, ast.Expr):
                events.append(("", statement.value))
        for event, value in events:
            for source, target in _moves(value, list(growing.states)):
                if source in growing.states and target in growing.states:
                    growing.add_transition(source, target, scope.module.place(value), event)
        if growing.states:
            yield growing.done()

    def _states_of_enum(self, growing: Growing, module: Module, call: ast.Call) -> None:
        own = self._sources.class_of(module, call.args[0]) if call.args else None
        flags = {keyword.arg: keyword.value for keyword in call.keywords}
        if own is not None and is_enum(self._sources, own):
            for member, statement in members(self._sources, own):
                initial = dotted_name(flags.get("initial")).endswith("." + member.name)
                finals = [dotted_name(node) for node in ast.walk(flags["final"])] if "final" in flags else []
                final = any(name.endswith("." + member.name) for name in finals)
                growing.add_state(member.name, own.module.place(statement), initial, final)

    # --- SMACH and YASMIN

    def _with_outcomes(self) -> Iterator[Machine]:
        machines: dict[tuple[str, int], Growing] = {}
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute) or len(node.args) < 2:
                continue
            name = node.func.attr
            libraries = {origin.partition(".")[0] for origin in module.imports.values()}
            kind = "smach" if "smach" in libraries else "yasmin" if "yasmin" in libraries else ""
            if not kind or name not in ("add", "add_state"):
                continue
            transitions = next((k.value for k in node.keywords if k.arg == "transitions"), None)
            if transitions is None and len(node.args) > 2:
                transitions = node.args[2]
            label = self._text(node.args[0], module, scope)
            if not label:
                continue
            key = (self._machine_of(module, node), id(scope and scope.node))
            growing = machines.setdefault(key, Growing(key[0], kind, module.place(node)))
            growing.add_state(label, module.place(node), initial=not growing.states)
            for value in self._values(transitions, module, scope):
                for outcome, target in getattr(value, "pairs", ()):
                    if isinstance(target, str):
                        growing.add_transition(label, target, module.place(node), str(outcome))
        for growing in machines.values():
            growing.transitions = [move for move in growing.transitions if move.target in growing.states]
            yield growing.done()

    def _machine_of(self, module: Module, node: ast.Call) -> str:
        """The variable of the machine: on which `add` is called, or that of the innermost `with` around it."""
        assert isinstance(node.func, ast.Attribute)
        receiver = dotted_name(node.func.value)
        if not receiver.endswith("StateMachine"):
            return receiver
        inside = [
            dotted_name(block.items[0].context_expr)
            for block in ast.walk(module.tree)
            if isinstance(block, ast.With) and any(part is node for part in ast.walk(block))
        ]
        return inside[-1] if inside else receiver

    # --- py_trees

    def _trees(self) -> Iterator[Machine]:
        growing: dict[str, Growing] = {}
        for module, scope, node in self._flow.nodes:
            if not isinstance(node, ast.Call):
                continue
            origin = imported_name(module, node.func)
            own = self._sources.class_of(module, node.func)
            is_leaf = own is not None and any(base.startswith("py_trees.") for base in self._sources.bases(own))
            if not is_leaf and not origin.startswith(("py_trees.behaviours.", "py_trees.timers.")):
                continue
            name = next((k.value for k in node.keywords if k.arg == "name"), node.args[0] if node.args else None)
            text = self._text(name, module, scope) or (self._own_name(own) if own is not None else "")
            if text:
                tree = growing.setdefault(module.name, Growing("tree", "py_trees", module.place(node)))
                tree.add_state(text, module.place(node))
        for tree in growing.values():
            yield tree.done()

    def _own_name(self, scope: Scope) -> str:
        """The name that a behaviour gives itself: `super().__init__("Pick")`, or the default of its parameter."""
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Call) and _is_super(node):
                value = next((k.value for k in node.keywords if k.arg == "name"), node.args[0] if node.args else None)
                at = next((s for s in self._sources.functions if any(part is node for part in ast.walk(s.node))), None)
                return self._text(value, scope.module, at)
        return ""

    # --- values

    def _values(self, node: ast.AST | None, module: Module, scope: Scope | None) -> list[Any]:
        return list(self._flow.constants(node, module, scope))

    def _first(self, node: ast.AST | None, module: Module, scope: Scope | None) -> Any:
        if node is None:
            return None
        try:
            return evaluate(self._sources, module, node)
        except UnknownValueError:
            values = self._values(node, module, scope)
            return values[0] if values else None

    def _text(self, node: ast.AST | None, module: Module, scope: Scope | None) -> str:
        value = self._first(node, module, scope)
        return _name(value) if isinstance(value, str | Member) else ""


def _moves(value: ast.expr, states: list[str]) -> Iterator[tuple[str, str]]:
    """Pairs of states of `a.to(b) | b.from_(c)`, also within `Event(...)`."""
    if isinstance(value, ast.BinOp):
        yield from _moves(value.left, states)
        yield from _moves(value.right, states)
    elif isinstance(value, ast.Call) and isinstance(value.func, ast.Attribute):
        owner, called = value.func.value, value.func.attr
        own = dotted_name(owner).rpartition(".")[2]
        others = [dotted_name(argument).rpartition(".")[2] for argument in value.args]
        if called == "to":
            yield from ((own, other) for other in others)
        elif called == "from_":
            yield from ((other, own) for other in others)
        elif called == "itself":
            state = dotted_name(owner).split(".")[-2:]
            yield (state[0], state[0])
        elif called == "any":
            target = dotted_name(owner).split(".")[0]
            yield from ((state, target) for state in states if state != target)
    elif isinstance(value, ast.Call):
        for argument in value.args:
            yield from _moves(argument, states)


def _arguments(node: ast.Call, names: tuple[str, ...]) -> dict[str, ast.expr]:
    arguments = dict(zip(names, node.args, strict=False))
    if isinstance(node.func, ast.Attribute) and dotted_name(node.func).endswith("Machine.__init__"):
        arguments = dict(zip(names, node.args[1:], strict=False))
    return arguments | {keyword.arg: keyword.value for keyword in node.keywords if keyword.arg}


def _is_super(node: ast.Call) -> bool:
    return (
        isinstance(node.func, ast.Attribute)
        and node.func.attr == "__init__"
        and isinstance(node.func.value, ast.Call)
        and dotted_name(node.func.value.func) == "super"
    )


def _name(value: Any) -> str:
    return value.name if isinstance(value, Member | Reference) else str(value)


def _state(value: Any) -> str:
    """How `transitions` tells a state: a member of an enumeration stays one, which is recorded as `text_of` says."""
    return value.text if isinstance(value, Member) else _name(value)
