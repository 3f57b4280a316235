"""What is to be called to run the code, and what it has to be handed."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from dataclasses import dataclass

from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.extra.draft.found.findings import Entry
from pytest_hricdv.extra.draft.messages.speech import QUEUES, SAYS, SUBSCRIBES
from pytest_hricdv.extra.draft.reading.classes import form_of, methods_of
from pytest_hricdv.extra.draft.reading.constants import is_enum
from pytest_hricdv.extra.draft.reading.sources import DraftError, Function, Scope, Sources, dotted_name, imported_name
from pytest_hricdv.extra.draft.reading.value_flow import ValueFlow, last_name, parameter_names
from pytest_hricdv.extra.draft.surroundings.ports import PortReader

METHODS = ("run", "work", "serve", "main", "live", "loop", "main_loop", "run_forever", "spin", "execute", "start",
           "control", "step", "tick", "update")  # fmt: skip
"""Methods of a robot's class that make it work, the likeliest first."""

FUNCTIONS = (
    "main",
    "run",
    "work",
    "serve",
    "robot",
    "control",
    "loop",
    "start",
    "spin",
    "amain",
    "main_loop",
    "worker",
    "control_loop",
    "event_loop",
)
"""Functions that make a robot work."""


@dataclass(frozen=True)
class Candidate:
    """Something that may be the entry, and how likely."""

    score: float
    scope: Scope
    method: Scope | None


class EntryFinder:
    """Finds the entry, and reads its ports."""

    def __init__(self, sources: Sources, flow: ValueFlow) -> None:
        self._sources, self._flow = sources, flow
        self._ports = PortReader(sources, flow)

    def entry(self, name: str) -> Entry | None:
        """The entry; None where there is nothing to call.

        Args:
            name: of a function, class, or `Class.method`; empty for the likeliest one.

        Raises:
            DraftError: there is no such function.
        """
        candidates = sorted(self._candidates(), key=lambda candidate: -candidate.score)
        if name:
            return self._read(self._named(name), "certain")
        if not candidates or candidates[0].score <= 0:
            return None
        is_sure = len(candidates) == 1 or candidates[0].score >= candidates[1].score + 2
        return self._read(candidates[0], "certain" if is_sure else "likely")

    def _named(self, name: str) -> Candidate:
        head, _, method = name.partition(".")
        scopes = [scope for scope in (*self._sources.functions, *self._sources.classes)
                  if scope.node.name == head and scope.owner is None]  # fmt: skip
        if not scopes:
            there = [
                scope.node.name for scope in (*self._sources.functions, *self._sources.classes) if scope.owner is None
            ]
            raise DraftError(
                f"--from={self._sources.package}:{name}: no function or class {head!r}{nearest(head, there)}"
            )
        scope = scopes[0]
        if not isinstance(scope.node, ast.ClassDef):
            return Candidate(0.0, scope, None)
        methods = methods_of(self._sources, scope)
        if method and method not in methods:
            raise DraftError(
                f"--from={self._sources.package}:{name}: {head} has no method {method!r}{nearest(method, methods)}"
            )
        chosen = method or next((name for name in METHODS if name in methods), "")
        return Candidate(0.0, scope, methods.get(chosen))

    def _candidates(self) -> Iterator[Candidate]:
        for scope in self._sources.functions:
            function = scope.node
            assert not isinstance(function, ast.ClassDef)
            is_top = scope.owner is None and function in scope.module.tree.body
            if is_top and not function.name.startswith("_"):
                score = self._score(scope, function) + (2 if function.name in FUNCTIONS else -2)
                yield Candidate(score, scope, None)
        for scope in self._sources.classes:
            assert isinstance(scope.node, ast.ClassDef)
            bases = {base.rpartition(".")[2] for base in self._sources.bases(scope)}
            if is_enum(self._sources, scope) or bases & {"Protocol", "ABC", "Exception", "NamedTuple", "TypedDict"}:
                continue
            methods = methods_of(self._sources, scope)
            chosen = next((name for name in METHODS if name in methods), "")
            if form_of(self._sources, scope) and not chosen:
                continue
            begin = methods.get("__init__")
            score = 1.0 if chosen else -1.0
            score += 1.0 if methods.get("__init__") is not None else 0.0
            for method in methods.values():
                assert not isinstance(method.node, ast.ClassDef)
                score += 0.5 * min(self._speaks(method.node), 2)
            score += self._from_outside(scope) + (0 if begin is None else self._port_score(begin))
            score += 3.5 * self._makes_queue(scope.node)
            yield Candidate(score, scope, methods.get(chosen))

    def _score(self, scope: Scope, function: Function) -> float:
        score = self._from_outside(scope) + self._port_score(scope) + min(self._speaks(function), 2)
        # What makes queues and processes itself only starts what is to be tested, and may not end.
        return score - 5.0 * self._starts_others(scope, function)

    @staticmethod
    def _starts_others(scope: Scope, function: Function) -> bool:
        made = {imported_name(scope.module, node.func) for node in ast.walk(function) if isinstance(node, ast.Call)}
        return bool(made & {"multiprocessing.Queue", "multiprocessing.Process", "multiprocessing.Pipe"})

    def _port_score(self, scope: Scope) -> float:
        assert not isinstance(scope.node, ast.ClassDef)
        names = [name for name in parameter_names(scope.node) if name != "self"]
        roles = [self._ports.port(scope, name).role for name in names]
        return 3.0 * any(role in ("bus", "publish", "queue", "reader") for role in roles)

    def _makes_queue(self, owner: ast.ClassDef) -> bool:
        """Whether a class makes a queue of its own that it takes from: what puts into it is outside of the robot."""
        for (name, attribute), assigned in self._flow.attributes.items():
            for where, value in assigned if name == owner.name else ():
                if isinstance(value, ast.Call) and imported_name(where.module, value.func) in QUEUES:
                    calls = [*self._flow.calls.get("get", ()), *self._flow.calls.get("get_nowait", ())]
                    takes = [dotted_name(call.node.func) for call in calls]
                    if any(taken.startswith(f"self.{attribute}.") for taken in takes):
                        return True
        return False

    def _from_outside(self, scope: Scope) -> float:
        """More where nothing of the code calls it, most where its main program does."""
        calls = [
            call
            for call in self._flow.calls.get(scope.node.name, ())
            if call.scope is None or call.scope.node is not scope.node
        ]
        score = 1.5 if not calls else -1.0
        if any(call.scope is None for call in calls):
            score = 2.5
        if scope.module.name.rpartition(".")[2] in (
            "main",
            "__main__",
            "robot",
            "app",
            "node",
            "controller",
            scope.node.name.lower(),
        ):
            score += 0.5
        return score

    def _speaks(self, function: Function) -> int:
        return sum(
            isinstance(node, ast.Call) and last_name(node.func).strip("_") in (*SAYS, *SUBSCRIBES)
            for node in ast.walk(function)
        )

    def _read(self, candidate: Candidate, certainty: str) -> Entry:
        scope, method = candidate.scope, candidate.method
        if not isinstance(scope.node, ast.ClassDef):
            is_async = isinstance(scope.node, ast.AsyncFunctionDef)
            ports = tuple(self._ports.ports(scope))
            return Entry(scope.module.name, scope.node.name, "", is_async, ports, (), scope.place,
                         "certain" if certainty == "certain" else "likely")  # fmt: skip
        begin = methods_of(self._sources, scope).get("__init__")
        ports = tuple(self._ports.ports(begin, skip=1)) if begin is not None else tuple(self._ports.fields(scope))
        method_ports = tuple(self._ports.ports(method, skip=1)) if method is not None else ()
        parts = (
            [method] if method is not None else methods_of(self._sources, scope).values()
        )  # it is called back, if at all
        is_async = any(isinstance(part.node, ast.AsyncFunctionDef) for part in parts)
        name = method.node.name if method is not None else ""
        return Entry(scope.module.name, scope.node.name, name, is_async, ports, method_ports, scope.place,
                     "certain" if certainty == "certain" else "likely")  # fmt: skip
