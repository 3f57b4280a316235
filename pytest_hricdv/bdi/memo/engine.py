"""The memo of a multi-agent system."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence, Set
from typing import Any

from ..environment import Environment, Perceived, percept_of
from ..prototype import Prototype
from ..result import Result
from ..scheduler import Run
from .diagram import Node, Segment, add, follow
from .forwarding import forwarding_of
from .recording import RecordingRun
from .steering import Steering
from .survey import Content, Fold, Runs, Survey
from .watching import Notes

Segments = list[Segment]
MAX_REMEMBERED = 50_000
"""Runs that are remembered; when there are more, all are forgotten."""


class Memo:
    """What runs have shown so far.

    Args:
        prototypes: the agents.
    """

    def __init__(self, prototypes: tuple[Prototype, ...]) -> None:
        self._prototypes = prototypes
        self._names = [prototype.name for prototype in prototypes]
        self._steering: dict[Hashable, Steering | None] = {}
        """The agents that forward atoms, by their name and the first of their percepts."""
        self._nodes: dict[Hashable, Node] = {}
        self._known: dict[Hashable, Segments | Result] = {}
        """Runs by all that they are given: their segments, or what has been found by running them as a whole."""
        self._spare: RecordingRun | None = None
        """The run that was recorded last: going back with it takes less time than beginning another."""

    def run(self, environment: Environment, seed: int, max_rounds: int) -> Result:
        """The result of a run with what the environment lists now, which must be a plain one.

        Raises:
            BdiError: an agent cannot go on.
        """
        perceived = environment.perceived
        key = (seed, max_rounds, *perceived)
        known = self._known.get(key)
        if known is None:
            if len(self._known) >= MAX_REMEMBERED:
                self._known.clear()
                self._steering.clear()
            known = self._known[key] = self._find(perceived, environment, seed, max_rounds)
        if not isinstance(known, Result):
            result = self._joined(known)
            if result.rounds < max_rounds:
                return result
            known = self._known[key] = self._run_as_a_whole(environment, seed, max_rounds)
        return _copy(known)

    def _find(self, perceived: Perceived, environment: Environment, seed: int, max_rounds: int) -> Segments | Result:
        case = self._case(perceived)
        segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
        return segments or self._run_as_a_whole(environment, seed, max_rounds)

    def _run_as_a_whole(self, environment: Environment, seed: int, max_rounds: int) -> Result:
        run = Run(environment, seed, None)
        for prototype in self._prototypes:
            run.agents[prototype.name] = prototype.agent(run)
        return Result.of(run, run.go(max_rounds))

    def _segments(
        self, steering: Steering, atoms: Set[str], environment: Environment, seed: int, max_rounds: int
    ) -> Segments | None:
        """The segments of a run, whatever rounds they take; those not known yet are run in earnest.

        None if that does not work out.
        """
        node = steering.start(len(atoms), seed)
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
                run = self._at(node, Notes(steering.forwarding, frozenset(atoms)), environment, seed)
            segment = self._add(node, run, seed, max_rounds - rounds)
            if segment is None:
                return None
            reached = segment.then

    def survey(
        self,
        environments: Sequence[Environment],
        atoms: frozenset[str],
        given: Mapping[str, bool],
        seed: int,
        max_rounds: int,
        fold: Fold,
    ) -> Runs | None:
        """Every run that any set of the atoms leads to, each once.

        Args:
            environments: for each number of atoms a plain one with that many, listed for the steering agent; the last
                one with all of them.
            atoms: all of them.
            given: atoms that are in every set that counts, or in none.
            fold: what is of interest of the actions and plans of a segment.

        Returns:
            What is of interest of each run -> atoms that lead to it; None if they cannot be surveyed.

        Raises:
            TooLargeError: there are too many runs.
            BdiError: an agent cannot go on.
        """
        starts: dict[tuple[Node, Content], None] = {}
        for environment in environments:
            case = self._case(environment.perceived)
            segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
            if case is None or segments is None or _rounds(segments) >= max_rounds:
                return None
            steering, listed = case
            way = steering.start(len(listed), seed).way
            if not isinstance(way, Segment) or way.then is None:
                return None
            starts[way.then, fold(way.actions, way.plans)] = None

        def complete(node: Node, chosen: frozenset[str]) -> bool:
            run = self._at(node, Notes(steering.forwarding, chosen), environment, seed)
            return self._add(node, run, seed, max_rounds) is not None

        found: Runs = {}
        for start, (lines, bits) in starts:
            runs = Survey(complete, fold, atoms, given).runs(start)
            if runs is None:
                return None
            for (after, more), chosen in runs.items():
                found.setdefault((lines + after, bits | more), chosen)
        return found

    def _at(self, node: Node, notes: Notes, environment: Environment, seed: int) -> RecordingRun:
        """A run that is at a node."""
        run = self._spare
        if run is None or node.states is None or not run.fits(notes, environment, seed):
            return RecordingRun(environment, seed, self._prototypes, notes, node.states)
        run.go_back(notes, node.states)
        return run

    def _add(self, node: Node, run: RecordingRun, seed: int, max_rounds: int) -> Segment | None:
        """Do the next segment of a run that is at a node; None if that does not work out."""
        # What ends with an error, or is not certain, leaves a run that cannot be used again.
        self._spare = None
        recorded = run.record(max_rounds)
        if recorded is None:
            return None
        self._spare = run
        segment, states = recorded
        if states is not None:
            segment.then = self._nodes.get((seed, states))
            if segment.then is None:
                segment.then = self._nodes[seed, states] = Node(states)
        add(node, run.notes.questions, segment)
        return segment

    def _case(self, perceived: tuple[Any, ...]) -> tuple[Steering, Set[str]] | None:
        """Who forwards the atoms, and the atoms; None if the percepts are not of this kind."""
        if not perceived:
            return None
        agent, count, *percepts = perceived
        first = (agent, percepts[0])
        if first not in self._steering:
            self._steering[first] = self._steering_for(*first)
        steering = self._steering[first]
        if steering is None or count != len(percepts):
            return None
        atoms = {*map(steering.atoms.__getitem__, percepts)}
        return None if "" in atoms else (steering, atoms)

    def _steering_for(self, agent: Any, percept: Any) -> Steering | None:
        """The agent, if it forwards percepts like this one."""
        key = percept_of(percept).key
        for known in self._steering.values():
            if known is not None and known.forwarding.steering == agent and known.forwarding.key == key:
                return known
        found = forwarding_of(agent, key, {prototype.name: prototype for prototype in self._prototypes})
        return None if found is None else Steering(found)

    def _joined(self, segments: Segments) -> Result:
        prints: list[str] = []
        actions: list[tuple[str, str]] = []
        warnings: list[str] = []
        plans: dict[str, list[str]] = {name: [] for name in self._names}
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
        return Result(prints, plans, actions, rounds, segments[-1].ended, warnings, Run.ms(ticks))


def _rounds(segments: Segments) -> int:
    rounds = 0
    for segment in segments:
        rounds += segment.rounds
    return rounds


def _copy(result: Result) -> Result:
    """A result whose lists are the caller's own."""
    plans = {name: labels.copy() for name, labels in result.plans.items()}
    lists = result.prints.copy(), result.actions.copy(), result.warnings.copy()
    return result._replace(plans=plans, prints=lists[0], actions=lists[1], warnings=lists[2])
