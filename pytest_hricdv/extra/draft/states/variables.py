"""State machines without a library: a variable that holds the state, and where it is tested and set."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.found.findings import Machine, Place, State, Transition
from pytest_hricdv.extra.draft.reading.constants import Reference
from pytest_hricdv.extra.draft.reading.sources import Function, Module, Scope, Sources, dotted_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, parameter_names
from pytest_hricdv.extra.draft.states.holders import Holder, enum_of, holders, initial_of_class, state_name

MAX_CALLS = 8
"""Methods that call methods (chosen)."""

Names = frozenset[str]


@dataclass
class Walk:
    """What is seen on the way through the functions that test and set one variable."""

    sources: Sources
    flow: ValueFlow
    holder: Holder
    states: dict[str, Place]
    moves: dict[tuple[str, str], Place] = field(default_factory=dict)
    initial: set[str] = field(default_factory=set)
    calls: list[Any] = field(default_factory=list)
    done: dict[Any, Names] = field(default_factory=dict)

    def function(self, scope: Scope, before: Names, bound: dict[str, Names] | None = None) -> Names:
        """Walk through a function that is entered in one of these states; in which ones it returns."""
        key = (id(scope.node), before, tuple(sorted((bound or {}).items(), key=str)))
        if key in self.done:
            return self.done[key]
        if len(self.calls) >= MAX_CALLS or key in self.calls:
            return before
        self.calls.append(key)
        assert not isinstance(scope.node, ast.ClassDef)
        returned: list[Names] = []
        after = self._block(scope.node.body, before, scope, bound or {}, returned)
        self.calls.pop()
        self.done[key] = frozenset().union(*returned, after or frozenset())
        return self.done[key]

    def _block(
        self, body: Sequence[ast.stmt], before: Names, scope: Scope, bound: dict[str, Names], returned: list[Names]
    ) -> Names | None:
        """After the statements; None where none of them is left by its end."""
        states: Names | None = before
        for statement in body:
            if states is None:
                return None
            states = self._statement(statement, states, scope, bound, returned)
        return states

    def _statement(
        self, node: ast.stmt, before: Names, scope: Scope, bound: dict[str, Names], returned: list[Names]
    ) -> Names | None:
        def block(body: Sequence[ast.stmt], states: Names) -> Names | None:
            return self._block(body, states, scope, bound, returned)

        if isinstance(node, ast.If):
            states = self._expression(node.test, before, scope, bound)
            yes, no = self._split(node.test, states, scope)
            return _either(block(node.body, yes) if yes or not self.states else None, block(node.orelse, no))
        if isinstance(node, ast.Match):
            return self._match(node, before, scope, bound, returned)
        if isinstance(node, ast.While | ast.For | ast.AsyncFor):
            return self._loop(node, before, scope, bound, returned)
        if isinstance(node, ast.Try):
            after = block(node.body, before)
            reached = before | (after or frozenset()) | frozenset(t for _, t in self._moves_in(node.body))
            for handler in node.handlers:
                after = _either(after, block(handler.body, reached))
            if node.orelse and after is not None:
                after = block(node.orelse, after)
            return block(node.finalbody, after) if node.finalbody and after is not None else after
        if isinstance(node, ast.With | ast.AsyncWith):
            return block(node.body, before)
        if isinstance(node, ast.Return):
            returned.append(self._expression(node.value, before, scope, bound) if node.value else before)
            return None
        if isinstance(node, ast.Raise | ast.Continue | ast.Break):
            self._left_loops.append((type(node), before))
            return None
        if isinstance(node, ast.Assign | ast.AnnAssign):
            return self._assign(node, before, scope, bound)
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            return before
        return self._expression(node, before, scope, bound)

    @property
    def _left_loops(self) -> list[tuple[type[ast.stmt], Names]]:
        left: list[tuple[type[ast.stmt], Names]] = self.__dict__.setdefault("_left", [])
        return left

    def _moves_in(self, body: Sequence[ast.stmt]) -> list[tuple[ast.AST, str]]:
        module = self.holder.module
        return [
            (node, name)
            for statement in body
            for node in ast.walk(statement)
            if isinstance(node, ast.Assign) and any(self.holder.is_it(target) for target in node.targets)
            for name in self._names(node.value, module, None, {})
        ]

    def _loop(
        self,
        node: ast.While | ast.For | ast.AsyncFor,
        before: Names,
        scope: Scope,
        bound: dict[str, Names],
        returned: list[Names],
    ) -> Names | None:
        states, left = before, len(self._left_loops)
        for _ in range(len(self.states) + 2):
            inside = states
            if isinstance(node, ast.While):
                inside = self._split(node.test, self._expression(node.test, states, scope, bound), scope)[0]
            after = self._block(node.body, inside, scope, bound, returned) or frozenset()
            again = [names for how, names in self._left_loops[left:] if how is ast.Continue]
            reached = states.union(after, *again)
            if reached == states:
                break
            states = reached
        broken = [names for how, names in self._left_loops[left:] if how is ast.Break]
        del self._left_loops[left:]
        is_endless = isinstance(node, ast.While) and isinstance(node.test, ast.Constant) and bool(node.test.value)
        if is_endless:
            return frozenset().union(*broken) if broken else None
        leaves = states
        if isinstance(node, ast.While):
            leaves = self._split(node.test, states, scope)[1]
        return leaves.union(*broken)

    def _match(
        self, node: ast.Match, before: Names, scope: Scope, bound: dict[str, Names], returned: list[Names]
    ) -> Names | None:
        rest = self._expression(node.subject, before, scope, bound)
        after: Names | None = None
        for case in node.cases:
            here = rest
            if self.holder.is_it(node.subject):
                tested = self._pattern(case.pattern, scope)
                here = rest if tested is None else rest & tested
                if case.guard is None:
                    rest = frozenset() if tested is None else rest - tested
            elif isinstance(node.subject, ast.Tuple):
                here = self._tuple_case(node.subject, case.pattern, rest, scope)
            if here:
                after = _either(after, self._block(case.body, here, scope, bound, returned))
        return _either(after, rest if rest or not self.states else None)

    def _tuple_case(self, subject: ast.Tuple, pattern: ast.pattern, before: Names, scope: Scope) -> Names:
        if isinstance(pattern, ast.MatchSequence):
            for part, inner in zip(subject.elts, pattern.patterns, strict=False):
                if self.holder.is_it(part):
                    tested = self._pattern(inner, scope)
                    return before if tested is None else before & tested
        return before

    def _pattern(self, pattern: ast.pattern, scope: Scope) -> Names | None:
        """The states that a pattern names; None for all."""
        if isinstance(pattern, ast.MatchValue):
            return self._names(pattern.value, scope.module, scope, {})
        if isinstance(pattern, ast.MatchOr):
            parts = [self._pattern(part, scope) for part in pattern.patterns]
            return None if None in parts else frozenset().union(*(part for part in parts if part is not None))
        return None

    def _split(self, test: ast.expr, states: Names, scope: Scope) -> tuple[Names, Names]:
        """In which states a condition can be true, and in which ones it can be false."""
        if isinstance(test, ast.UnaryOp) and isinstance(test.op, ast.Not):
            yes, no = self._split(test.operand, states, scope)
            return no, yes
        if isinstance(test, ast.BoolOp):
            is_and = isinstance(test.op, ast.And)
            yes, no = (states, frozenset()) if is_and else (frozenset(), states)
            for part in test.values:
                part_yes, part_no = self._split(part, states, scope)
                yes, no = (yes & part_yes, no | part_no) if is_and else (yes | part_yes, no & part_no)
            return yes, no
        if isinstance(test, ast.Compare) and len(test.ops) == 1:
            left, right, how = test.left, test.comparators[0], test.ops[0]
            if self.holder.is_it(right) and not self.holder.is_it(left):
                left, right = right, left
            if self.holder.is_it(left):
                names = self._names(right, scope.module, scope, {})
                if names and isinstance(how, ast.Eq | ast.Is | ast.In):
                    return states & names, states - names
                if names and isinstance(how, ast.NotEq | ast.IsNot | ast.NotIn):
                    return states - names, states & names
        return states, states

    def _assign(self, node: ast.Assign | ast.AnnAssign, before: Names, scope: Scope, bound: dict[str, Names]) -> Names:
        states = self._expression(node.value, before, scope, bound) if node.value is not None else before
        targets: list[ast.expr] = node.targets if isinstance(node, ast.Assign) else [node.target]
        pairs: list[tuple[ast.expr, ast.expr | None]] = [(target, node.value) for target in targets]
        for target in targets:
            if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
                pairs += list(zip(target.elts, node.value.elts, strict=False))
        for target, value in pairs:
            if self.holder.is_it(target) and isinstance(target, ast.Attribute | ast.Name):
                states = self._set(value, states, scope, bound)
        return states

    def _set(self, value: ast.expr | None, before: Names, scope: Scope, bound: dict[str, Names]) -> Names:
        into: set[str] = set()
        dispatched = self._dispatched(value, before)
        if dispatched:
            for state, method in dispatched:
                for name in self._returned(method):
                    self._move(frozenset({state}), name, scope.module.place(value or scope.node))
                    into.add(name)
            return frozenset(into)
        for name in self._names(value, scope.module, scope, bound) & frozenset(self.states):
            self._move(before, name, scope.module.place(value or scope.node))
            into.add(name)
        return frozenset(into) or (before if before else frozenset())

    def _move(self, before: Names, into: str, place: Place) -> None:
        if not before:
            self.initial.add(into)
        for state in sorted(before):
            if state != into:
                self.moves.setdefault((state, into), place)

    def _names(self, node: ast.AST | None, module: Module, scope: Scope | None, bound: dict[str, Names]) -> Names:
        """States that an expression names."""
        if isinstance(node, ast.Name) and node.id in bound:
            return bound[node.id]
        if isinstance(node, ast.IfExp):
            return self._names(node.body, module, scope, bound) | self._names(node.orelse, module, scope, bound)
        values = list(self.flow.constants(node, module, scope))
        if isinstance(node, ast.Tuple | ast.Set | ast.List | ast.Name | ast.Attribute):
            values += [part for value in values if isinstance(value, tuple) for part in value]
        return frozenset(name for name in map(state_name, values) if name in self.states)

    def _returned(self, scope: Scope) -> Names:
        names: set[str] = set()
        for node in ast.walk(scope.node):
            if isinstance(node, ast.Return):
                names |= self._names(node.value, scope.module, scope, {})
        return frozenset(names)

    def _expression(self, node: ast.AST | None, before: Names, scope: Scope, bound: dict[str, Names]) -> Names:
        """After the calls in an expression: those of methods of the same class, or of functions within the same one."""
        states = before
        for call in (part for part in ast.walk(node) if isinstance(part, ast.Call)) if node is not None else ():
            dispatched = self._dispatched(call, states)
            if dispatched:
                states = frozenset().union(*(self.function(method, frozenset({state})) for state, method in dispatched))
                continue
            method = self._called(call)
            if method is not None and method.node is not scope.node:
                states = self.function(method, states, self._binding(call, method, scope, bound)) or states
        return states

    def _called(self, call: ast.Call) -> Scope | None:
        name = dotted_name(call.func)
        if self.holder.owner is not None and name.startswith("self.") and name.count(".") == 1:
            for method in self.flow.methods.get(name[5:], ()):
                if method.owner is self.holder.owner and self._matters(method):
                    return method
        return None

    def _matters(self, method: Scope) -> bool:
        """Whether a method sets the state, or calls one that does."""
        cache: dict[int, bool] = self.__dict__.setdefault("_setting", {})
        if id(method.node) not in cache:
            cache[id(method.node)] = False
            cache[id(method.node)] = any(
                (isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store) and self.holder.is_it(node))
                or (isinstance(node, ast.Call) and self._called(node) is not None)
                for node in ast.walk(method.node)
            )  # fmt: skip
        return cache[id(method.node)]

    def _binding(self, call: ast.Call, method: Scope, scope: Scope, bound: dict[str, Names]) -> dict[str, Names]:
        assert not isinstance(method.node, ast.ClassDef)
        binding: dict[str, Names] = {}
        names = parameter_names(method.node)[1:]
        pairs = [*zip(names, call.args, strict=False), *((k.arg, k.value) for k in call.keywords if k.arg)]
        for name, value in pairs:
            states = self._names(value, scope.module, scope, bound)
            if states and name is not None:
                binding[name] = states
        return binding

    def _dispatched(self, node: ast.AST | None, states: Names) -> list[tuple[str, Scope]]:
        """Methods of a table that is looked up by the state, `self._steps[self.state]()`, or of `getattr`."""
        while isinstance(node, ast.Await):
            node = node.value
        if not isinstance(node, ast.Call):
            return []
        function: ast.expr = node.func
        if isinstance(function, ast.Call) and dotted_name(function.func) == "getattr" and len(function.args) > 1:
            return self._by_name(function.args[1], states)
        key, table = None, None
        if isinstance(function, ast.Subscript):
            key, table = function.slice, function.value
        elif (
            isinstance(function, ast.Call) and isinstance(function.func, ast.Attribute) and function.func.attr == "get"
        ):
            key, table = (function.args[0] if function.args else None), function.func.value
        if table is None or not self.holder.is_it(key):
            return []
        scope = self._scope_around(node)
        found: list[tuple[str, Scope]] = []
        for value in self.flow.constants(table, self.holder.module, scope):
            for entry, content in getattr(value, "pairs", ()):
                state = state_name(entry)
                if state in states and isinstance(content, Reference):
                    found += [
                        (state, method) for method in self.flow.methods.get(content.name.rpartition(".")[2], ())[:1]
                    ]
        return found

    def _by_name(self, name: ast.expr, states: Names) -> list[tuple[str, Scope]]:
        parts = name.values if isinstance(name, ast.JoinedStr) else []
        prefix = "".join(str(part.value) for part in parts[:1] if isinstance(part, ast.Constant))
        return [
            (state, method)
            for state in sorted(states)
            for method in self.flow.methods.get(prefix + state.lower(), self.flow.methods.get(prefix + state, ()))[:1]
        ]

    def _scope_around(self, node: ast.AST) -> Scope | None:
        return next((scope for _, scope, other in self.flow.nodes if other is node), None)


def _either(left: Names | None, right: Names | None) -> Names | None:
    if left is None:
        return right
    return left if right is None else left | right


def written_machines(sources: Sources, flow: ValueFlow) -> Iterator[Machine]:
    """Machines that are a variable with its tests and assignments."""
    for holder, states in holders(sources, flow):
        walk = Walk(sources, flow, holder, states)
        methods = [scope for scope in sources.functions if scope.owner is holder.owner and holder.owner is not None]
        if holder.function is not None:
            methods = [scope for scope in sources.functions if scope.node is holder.function]
        for scope in sorted(methods, key=lambda scope: getattr(scope.node, "name", "") != "__init__"):
            function = scope.node
            assert not isinstance(function, ast.ClassDef)
            is_begin = function.name in ("__init__", "__post_init__") or holder.function is not None
            if is_begin:
                walk.function(scope, frozenset())
            elif not _is_called_inside(flow, function, holder) or any(
                row.function.node is function for row in flow.handled
            ):
                walk.function(scope, frozenset(states))
        initial = walk.initial or initial_of_class(flow, holder, sources)
        owner = holder.owner.name if holder.owner is not None else getattr(holder.function, "name", "")
        listed = tuple(State(name, place, name in initial) for name, place in states.items())
        ordered = sorted(walk.moves.items(), key=lambda move: (move[1], move[0]))  # sets have none
        moves = tuple(Transition(source, target, place) for (source, target), place in ordered)
        place = holder.module.place(holder.owner or holder.function or holder.module.tree)
        held = f"{holder.module.name}:{owner}.{holder.attribute}" if holder.owner is not None else ""
        yield Machine(owner, "enum" if enum_of(sources, flow, holder) else "text", listed, moves, place, held=held)


def _is_called_inside(flow: ValueFlow, function: Function, holder: Holder) -> bool:
    """Whether only methods of the same class call it: then it is seen with the states in which they do."""
    calls = [
        call for call in flow.calls.get(function.name, ()) if call.scope is not None and call.scope.node is not function
    ]
    if calls:
        return all(call.scope is not None and call.scope.owner is holder.owner for call in calls)
    tables = [node for _, _, node in flow.nodes if isinstance(node, ast.Dict)
              and any(dotted_name(value) == f"self.{function.name}" for value in node.values)]  # fmt: skip
    dispatch = [node for _, _, node in flow.nodes if isinstance(node, ast.JoinedStr) and node.values
                and isinstance(node.values[0], ast.Constant) and function.name.startswith(str(node.values[0].value))
                and len(str(node.values[0].value)) > 2]  # fmt: skip
    return bool(tables or dispatch)
