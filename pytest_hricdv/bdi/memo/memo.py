"""`Memo` runs a multi-agent system for test generation, and executes no segment of a run twice.

`generate.model_runner` has a memo for each model. How a memo works is described in the package (`bdi.memo`).
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence, Set
from typing import Any

from pytest_hricdv.bdi.agent.intentions import TICKS_PER_MS
from pytest_hricdv.bdi.language.limits import is_even
from pytest_hricdv.bdi.language.terms import Key, Structure
from pytest_hricdv.bdi.memo.decision_diagram import (
    Content,
    ExhaustiveExploration,
    Fold,
    Runs,
    Segment,
    StateNode,
    add,
    follow,
)
from pytest_hricdv.bdi.memo.forwarding import Dependencies, ForwardingRule, find_forwarding
from pytest_hricdv.bdi.memo.recording import RecordingRun
from pytest_hricdv.bdi.run.environment import Environment, PerceptSnapshot, percept_of
from pytest_hricdv.bdi.run.system import MAX_ROUNDS, MultiAgentSystem, Result

Segments = list[Segment]
MAX_REMEMBERED = 50_000
"""Most runs that are remembered; when there are more, all are forgotten (learning makes some thousand runs;
their segments remain in the diagram)."""


class Memo:
    """Runs a system; what has been executed before is not executed again.

    Example::

        memo = Memo(MultiAgentSystem.load("models_bdi/table_assembly.mas2j"))
        result = memo.run(percepts={"meta": ["chosen(leg4)", "chosen(m111l4)"]})

    Args:
        system: the system; with a custom environment nothing is remembered.
    """

    def __init__(self, system: MultiAgentSystem) -> None:
        self.system = system
        self._forwarding: dict[tuple[str, Key], ForwardingRule | None] = {}
        """How agents forward atoms, by their name and the predicate of their percepts."""
        self._roots: dict[tuple[str, Key, int, int], StateNode] = {}
        """Where runs begin, by the steering agent, its percepts' predicate, the number of atoms and the seed."""
        self._nodes: dict[Hashable, StateNode] = {}
        self._remembered: dict[Hashable, Segments | Result] = {}
        """Runs by all that they are given: their segments, or the result of executing them as a whole."""

    def run(
        self,
        *,
        max_rounds: int = MAX_ROUNDS,
        seed: int = 0,
        percepts: Mapping[str, Iterable[str | Structure]] | None = None,
    ) -> Result:
        """The result of :meth:`MultiAgentSystem.run` with these arguments.

        Raises:
            BdiError: an agent cannot continue.
            ValueError: an argument is out of its range, or names an unknown agent.
        """
        environment = self.system.environment
        if max_rounds < 0 or type(environment) is not Environment:
            return self.system.run(max_rounds=max_rounds, seed=seed, percepts=percepts)
        self.system.show(percepts)
        perceived = environment.percept_snapshot
        key = (seed, max_rounds, *perceived)
        remembered = self._remembered.get(key)
        if remembered is None:
            if len(self._remembered) >= MAX_REMEMBERED:
                self._remembered.clear()
                self._forwarding.clear()
            remembered = self._remembered[key] = self._find(perceived, environment, seed, max_rounds)
        if not isinstance(remembered, Result):
            result = self._join(remembered)
            if result.rounds < max_rounds:
                return result
            remembered = self._remembered[key] = self.system.run(max_rounds=max_rounds, seed=seed)
        return _copy(remembered)

    def _find(
        self, perceived: PerceptSnapshot, environment: Environment, seed: int, max_rounds: int
    ) -> Segments | Result:
        case = self._case(perceived)
        segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
        return segments or self.system.run(max_rounds=max_rounds, seed=seed)

    def explore_all(
        self,
        agent: str,
        functor: str,
        atoms: Sequence[str],
        fixed: Mapping[str, bool],
        fold: Fold,
        max_rounds: int = MAX_ROUNDS,
        seed: int = 0,
    ) -> Runs | None:
        """Every run that there is when an agent perceives ``functor(b)`` for any set of atoms ``b``.

        Args:
            agent: the agent, which has to forward the atoms (see :mod:`pytest_hricdv.bdi.memo`).
            functor: the functor of its percepts.
            atoms: the atoms that sets are made of.
            fixed: atoms that are in every set that counts, or in none.
            fold: reduces the actions and executed plans of a segment to what is of interest: strings in order, and a
                bit set.
            max_rounds: as in :meth:`run`.
            seed: as in :meth:`run`.

        Returns:
            What is of interest of each run, each once -> atoms that lead to it; None if runs cannot be separated into
            segments.

        Raises:
            TooLargeError: there are too many runs.
            BdiError: an agent cannot continue.
            ValueError: there is no such agent.
        """
        starts: dict[tuple[StateNode, Content], None] = {}
        percepts = [f"{functor}({atom})" for atom in atoms]
        environment, first = Environment(), None
        for count in range(1, len(atoms) + 1):
            self.system.check_agent(agent)
            environment = Environment()
            environment.show(agent, percepts[:count])
            first = self._first_segment(environment, seed, max_rounds)
            if first is None:
                return None
            _, segment, then = first
            starts[then, fold(segment.actions, segment.plans)] = None
        if first is None:
            return None
        forwarding = first[0]

        def complete(node: StateNode, chosen: frozenset[str]) -> bool:
            run = self._at(node, forwarding, chosen, environment, seed)
            return self._add(node, run, seed, max_rounds) is not None

        all_runs: Runs = {}
        for start, (lines, bits) in starts:
            runs = ExhaustiveExploration(complete, fold, frozenset(atoms), fixed).runs(start)
            if runs is None:
                return None
            for (after, more), chosen in runs.items():
                all_runs.setdefault((lines + after, bits | more), chosen)
        return all_runs

    def _first_segment(
        self, environment: Environment, seed: int, max_rounds: int
    ) -> tuple[ForwardingRule, Segment, StateNode] | None:
        """How atoms are forwarded, what runs do before they depend on one, and where they are then."""
        case = self._case(environment.percept_snapshot)
        segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
        if case is None or segments is None or _rounds(segments) >= max_rounds:
            return None
        forwarding, atoms = case
        edge = self._root(forwarding, len(atoms), seed).edge
        if not isinstance(edge, Segment) or edge.then is None:
            return None
        return forwarding, edge, edge.then

    def obstacle(self, agent: str, functor: str, atoms: Iterable[str]) -> str:
        """Why runs may not be separable into segments, in a clause that names agents and atoms (see `explore_all`)."""
        forwarding = find_forwarding(agent, percept_of(f"{functor}(b)").key, self.system.templates)
        if forwarding is None:
            return (
                f"agent {agent!r} does other things with its percepts {functor}(B) than to tell B to named agents in a "
                f"loop over all of them, or an agent that it tells has plans for messages"
            )
        special = [atom for atom in atoms if not forwarding.atoms[f"{functor}({atom})"]]
        if special:
            receivers = ", ".join(sorted(forwarding.receivers))
            return (
                f"{', '.join(special[:3])}{', ...' if special[3:] else ''} trigger a plan of {receivers} when they "
                f"come, are believed there at first, or are named by {agent!r}"
            )
        return "an agent uses what differs from run to run, such as the clock, random numbers, or its own plans"

    # --- segments

    def _segments(
        self, forwarding: ForwardingRule, atoms: Set[str], environment: Environment, seed: int, max_rounds: int
    ) -> Segments | None:
        """The segments of a run, whatever rounds they take; unknown segments are executed.

        None if that is not possible.
        """
        node = self._root(forwarding, len(atoms), seed)
        reached = None
        segments: Segments = []
        while True:
            # A run that comes to more nodes than there are has been at one of them twice: it will never end.
            most = len(self._nodes) + 1
            following = follow(node, atoms, segments, most + 1)
            if len(segments) > most:
                return None
            if following is None:
                return segments
            rounds = _rounds(segments)
            if rounds >= max_rounds:
                return None
            node = following
            if node is not reached:
                run = self._at(node, forwarding, frozenset(atoms), environment, seed)
            segment = self._add(node, run, seed, max_rounds, rounds)
            if segment is None:
                return None
            reached = segment.then

    def _root(self, forwarding: ForwardingRule, atoms: int, seed: int) -> StateNode:
        """The node where a run with this number of atoms begins."""
        return self._roots.setdefault((forwarding.steering, forwarding.key, atoms, seed), StateNode())

    def _at(
        self, node: StateNode, forwarding: ForwardingRule, atoms: frozenset[str], environment: Environment, seed: int
    ) -> RecordingRun:
        """A run that is at a node."""
        dependencies = Dependencies(forwarding, atoms, arrived=node.states is not None)
        run = RecordingRun(environment, seed, self.system.templates, dependencies, node.states)
        run.new_agent = self.system.new_agent
        return run

    def _add(self, node: StateNode, run: RecordingRun, seed: int, max_rounds: int, done: int = 0) -> Segment | None:
        """Execute the next segment of a run that is at a node; None if that is not possible."""
        work_left = run.work_left
        recorded = run.record(max_rounds - done)
        if recorded is None:
            return None
        segment, states = recorded
        if not is_even(work_left - run.work_left, segment.rounds, max_rounds):
            return None
        if states is not None:
            segment.then = self._nodes.setdefault((seed, states), StateNode(states))
        add(node, run.dependencies.answers, segment)
        return segment

    def _case(self, perceived: tuple[Any, ...]) -> tuple[ForwardingRule, Set[str]] | None:
        """How atoms are forwarded, and the atoms; None if the percepts are not of this kind."""
        if not perceived:
            return None
        agent, count, *percepts = perceived
        which = agent, percept_of(percepts[0]).key
        if which not in self._forwarding:
            self._forwarding[which] = find_forwarding(*which, self.system.templates)
        forwarding = self._forwarding[which]
        if forwarding is None or count != len(percepts):
            return None
        atoms = {*map(forwarding.atoms.__getitem__, percepts)}
        return None if "" in atoms else (forwarding, atoms)

    def _join(self, segments: Segments) -> Result:
        prints: list[str] = []
        actions: list[tuple[str, str]] = []
        warnings: list[str] = []
        plans: dict[str, list[str]] = {name: [] for name in self.system.agents}
        rounds = ticks = 0
        for segment in segments:
            rounds += segment.rounds
            ticks += segment.ticks
            actions += segment.actions
            for name, labels in segment.plans:
                plans[name] += labels
            if segment.prints or segment.warnings:
                prints += segment.prints
                warnings += segment.warnings
        last = segments[-1]
        time_ms = ticks / TICKS_PER_MS
        return Result(prints, plans, actions, rounds, last.ended, warnings, time_ms, endless=last.endless)


def _rounds(segments: Segments) -> int:
    return sum([segment.rounds for segment in segments])


def _copy(result: Result) -> Result:
    """A result whose lists belong to the caller."""
    plans = {name: labels.copy() for name, labels in result.plans.items()}
    lists = result.prints.copy(), result.actions.copy(), result.warnings.copy()
    return result._replace(plans=plans, prints=lists[0], actions=lists[1], warnings=lists[2])
