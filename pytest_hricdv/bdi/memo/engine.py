"""The memo of a multi-agent system."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence, Set
from itertools import chain
from typing import Any, NamedTuple

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


class Fixed(NamedTuple):
    """A result as it is remembered: tuples of texts, which are no work for the garbage collector, however many.

    Args:
        prints, actions, warnings, rounds, ended: as in the result.
        plans: the labels of the plans that each agent executed, in the order of the agents.
        ticks: of the virtual clock.
    """

    prints: tuple[str, ...]
    actions: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]
    plans: tuple[tuple[str, ...], ...]
    rounds: int
    ticks: int
    ended: str


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
        self._known: dict[Hashable, Fixed] = {}
        """Runs by all that they are given."""
        self._results: dict[tuple[int, ...], Fixed] = {}
        """Runs by the numbers of their segments."""
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
                self._results.clear()
            known = self._known[key] = self._find(perceived, environment, seed, max_rounds)
        return self._result(known)

    def _find(self, perceived: Perceived, environment: Environment, seed: int, max_rounds: int) -> Fixed:
        case = self._case(perceived)
        segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
        if segments is not None:
            numbers = tuple([segment.number for segment in segments])
            found = self._results.get(numbers)
            if found is None:
                found = self._results[numbers] = _joined(segments)
            if found.rounds < max_rounds:
                return found
        return self._run_as_a_whole(environment, seed, max_rounds)

    def _run_as_a_whole(self, environment: Environment, seed: int, max_rounds: int) -> Fixed:
        run = Run(environment, seed, None)
        for prototype in self._prototypes:
            run.agents[prototype.name] = prototype.agent(run)
        ended = run.go(max_rounds)
        plans = tuple([tuple(agent.executed) for agent in run.agents.values()])
        lists = tuple(run.prints), tuple(run.actions), tuple(run.warnings), plans
        return Fixed(*lists, run.rounds, run.ticks, ended)

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
            rounds = sum(segment.rounds for segment in segments)
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

        def content(segment: Segment) -> Content:
            return fold(segment.actions, list(zip(self._names, segment.plans, strict=True)))

        starts: dict[tuple[Node, Content], None] = {}
        for environment in environments:
            case = self._case(environment.perceived)
            segments = None if case is None else self._segments(*case, environment, seed, max_rounds)
            if case is None or segments is None or sum(segment.rounds for segment in segments) >= max_rounds:
                return None
            steering, listed = case
            way = steering.start(len(listed), seed).way
            if not isinstance(way, Segment) or way.then is None:
                return None
            starts[way.then, content(way)] = None

        def complete(node: Node, chosen: frozenset[str]) -> bool:
            run = self._at(node, Notes(steering.forwarding, chosen), environment, seed)
            return self._add(node, run, seed, max_rounds) is not None

        found: Runs = {}
        for start, (lines, bits) in starts:
            runs = Survey(complete, content, atoms, given).runs(start)
            if runs is None:
                return None
            for (after, more), chosen in runs.items():
                found.setdefault((lines + after, bits | more), chosen)
        return found

    def _at(self, node: Node, notes: Notes, environment: Environment, seed: int) -> RecordingRun:
        """A run that is at a node."""
        run = self._spare
        if run is None or node.states is None or not run.fits(notes, environment, seed):
            run = self._spare = RecordingRun(environment, seed, self._prototypes, notes, node.states)
        else:
            run.go_back(notes, node.states)
        return run

    def _add(self, node: Node, run: RecordingRun, seed: int, max_rounds: int) -> Segment | None:
        """Do the next segment of a run that is at a node; None if that does not work out."""
        recorded = run.record(max_rounds)
        if recorded is None:
            self._spare = None
            return None
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

    def _result(self, fixed: Fixed) -> Result:
        prints, actions, warnings, plans, rounds, ticks, ended = fixed
        executed = dict(zip(self._names, map(list, plans), strict=True))
        return Result([*prints], executed, [*actions], rounds, ended, [*warnings], Run.ms(ticks))


def _joined(segments: Segments) -> Fixed:
    """What segments amount to."""
    prints, actions, warnings, *plans = [
        tuple(chain.from_iterable(parts)) for parts in zip(*[segment.done for segment in segments], strict=True)
    ]
    rounds, ticks = sum([segment.rounds for segment in segments]), sum([segment.ticks for segment in segments])
    return Fixed(prints, actions, warnings, tuple(plans), rounds, ticks, segments[-1].ended)
