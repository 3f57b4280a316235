"""The memo of a multi-agent system."""

from __future__ import annotations

from collections.abc import Hashable

from ..environment import Environment
from ..prototype import Prototype
from ..result import Result
from ..scheduler import Run
from ..terms import SOURCE_PERCEPT, Key, Structure
from .diagram import Node, Segment, add, follow
from .forwarding import Forwarding, forwarding_of
from .recording import KNOWN, Notes, RecordingRun

Case = tuple[Forwarding, frozenset[str]]
"""How atoms are forwarded, and the atoms."""
MAX_REMEMBERED = 50_000
"""Whole runs that are remembered; when there are more, all are forgotten."""


class Memo:
    """What runs have shown so far.

    Args:
        prototypes: the agents.
    """

    def __init__(self, prototypes: tuple[Prototype, ...]) -> None:
        self._prototypes = prototypes
        self._forwarding: dict[tuple[str, Key], Forwarding | None] = {}
        self._nodes: dict[Hashable, Node] = {}
        self._whole: dict[Hashable, Result] = {}
        self.runs_in_earnest = 0
        """How often the model had to be run."""

    def run(self, environment: Environment, seed: int, max_rounds: int) -> Result:
        """The result of a run with what the environment lists now, which must be a plain one."""
        listed = {prototype.name: environment.percepts(prototype.name) for prototype in self._prototypes}
        key = (seed, max_rounds, tuple(listed.values()))
        known = self._whole.get(key)
        if known is None:
            case = self._case(listed)
            if case is not None:
                known = self._put_together(case, seed, max_rounds)
            known = known or self._run_in_earnest(case, environment, seed, max_rounds)
            if len(self._whole) >= MAX_REMEMBERED:
                self._whole.clear()
            self._whole[key] = known
        return _copy(known)

    def _put_together(self, case: Case, seed: int, max_rounds: int) -> Result | None:
        """The result by what earlier runs have shown, if that is enough."""
        forwarding, atoms = case
        root = self._nodes.get(_root(forwarding, atoms, seed))
        segments = None if root is None else follow(root, atoms)
        if segments is None:
            return None
        result = self._joined(segments)
        return result if result.rounds < max_rounds else None

    def _run_in_earnest(self, case: Case | None, environment: Environment, seed: int, max_rounds: int) -> Result:
        self.runs_in_earnest += 1
        if case is not None:
            result = self._record(case, environment, seed, max_rounds)
            if result is not None:
                return result
        run = Run(environment, seed, None)
        for prototype in self._prototypes:
            run.agents[prototype.name] = prototype.agent(run)
        return Result.of(run, run.go(max_rounds))

    def _record(self, case: Case, environment: Environment, seed: int, max_rounds: int) -> Result | None:
        """The result, with the segments added that are certain; None if the round limit does not allow for it."""

        def known(state: Hashable) -> list[Segment] | None:
            node = self._nodes.get((seed, state))
            return None if node is None else follow(node, case[1])

        run = RecordingRun(environment, seed, self._prototypes, Notes(*case), known)
        ended = run.go(max_rounds)
        segments = run.segments
        if ended == KNOWN:
            self._add(self._nodes.setdefault(_root(*case, seed), Node()), segments, seed)
            result = self._joined([*(segment for _, segment in segments), *run.ahead])
            return result if result.rounds < max_rounds else None
        if run.notes.certain and ended == "idle" and run.rounds < max_rounds:
            run.finish(ended)
            self._add(self._nodes.setdefault(_root(*case, seed), Node()), segments, seed)
        return Result.of(run, ended)

    def _add(self, node: Node, segments: list[tuple[Hashable, Segment]], seed: int) -> None:
        for state, segment in segments:
            if not segment.ended:
                segment.then = self._nodes.setdefault((seed, state), Node())
            there = add(node, segment)
            if there is None:
                return
            node = there.then

    def _case(self, listed: dict[str, tuple[Structure, ...]]) -> Case | None:
        """How the atoms are forwarded, and the atoms; None if the percepts are not of this kind."""
        showing = [name for name, percepts in listed.items() if percepts]
        if len(showing) != 1:
            return None
        (steering,) = showing
        percepts = listed[steering]
        key = percepts[0].key
        atoms = frozenset(_atom(percept, key) for percept in percepts)
        if "" in atoms:
            return None
        if (steering, key) not in self._forwarding:
            self._forwarding[steering, key] = self._find_forwarding(steering, key)
        forwarding = self._forwarding[steering, key]
        return None if forwarding is None or forwarding.special & atoms else (forwarding, atoms)

    def _find_forwarding(self, steering: str, key: Key) -> Forwarding | None:
        by_name = {prototype.name: prototype for prototype in self._prototypes}
        agent = by_name[steering]
        if agent.code is None or key not in agent.code.program.tables or key[2] != 1:
            return None
        if agent.code.tables[agent.code.program.tables[key]]:
            return None
        found = forwarding_of(steering, agent.library, key)
        if found is None or steering in found.receivers:
            return None
        special = set(found.special)
        for name in found.receivers:
            code = by_name[name].code if name in by_name else None
            if code is None:
                return None
            special |= code.propositions.keys() | {functor for _, functor, _ in code.program.noticed}
        return Forwarding(steering, key, found.receivers, frozenset(special))

    def _joined(self, segments: list[Segment]) -> Result:
        prints: list[str] = []
        actions: list[tuple[str, str]] = []
        warnings: list[str] = []
        plans: dict[str, list[str]] = {prototype.name: [] for prototype in self._prototypes}
        rounds = ticks = 0
        for segment in segments:
            rounds += segment.rounds
            ticks += segment.ticks
            actions += segment.actions
            if segment.prints or segment.warnings:
                prints += segment.prints
                warnings += segment.warnings
            for name, labels in segment.plans:
                plans[name] += labels
        return Result(prints, plans, actions, rounds, segments[-1].ended, warnings, Run.ms(ticks))


def _root(forwarding: Forwarding, atoms: frozenset[str], seed: int) -> Hashable:
    return forwarding.steering, forwarding.key, len(atoms), seed


def _atom(percept: Structure, key: Key) -> str:
    """The atom that a percept is about; empty if it is about something else."""
    if percept.key != key or percept.annots != (SOURCE_PERCEPT,) or len(percept.args) != 1:
        return ""
    (about,) = percept.args
    if not isinstance(about, Structure) or about.args or about.annots or about.negated:
        return ""
    return about.functor


def _copy(result: Result) -> Result:
    """A result whose lists are the caller's own."""
    plans = {name: labels.copy() for name, labels in result.plans.items()}
    return Result(
        result.prints.copy(),
        plans,
        result.actions.copy(),
        result.rounds,
        result.ended,
        result.warnings.copy(),
        result.time_ms,
    )
