"""The memo of a multi-agent system."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from functools import lru_cache

from ..environment import Environment, Perceived
from ..prototype import Prototype
from ..result import Result
from ..scheduler import Run
from ..terms import SOURCE_PERCEPT, Key, Structure
from .diagram import Node, Segment, add, follow
from .forwarding import Forwarding, forwarding_of
from .recording import RecordingRun
from .survey import Content, Fold, Runs, Survey
from .watching import Notes

Case = tuple[Forwarding, frozenset[str]]
"""How atoms are forwarded, and the atoms."""
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
        self._forwarding: dict[tuple[str, Key], Forwarding | None] = {}
        self._nodes: dict[Hashable, Node] = {}
        self._known: dict[Hashable, Segments | Result] = {}
        """Runs by all that they are given: their segments, or what has been found by running them as a whole."""

    def run(self, environment: Environment, seed: int, max_rounds: int) -> Result:
        """The result of a run with what the environment lists now, which must be a plain one.

        Raises:
            BdiError: an agent cannot go on.
        """
        perceived = environment.perceived
        key = (perceived, seed, max_rounds)
        known = self._known.get(key)
        if known is None:
            known = self._find(perceived, environment, seed, max_rounds)
            if len(self._known) >= MAX_REMEMBERED:
                self._known.clear()
            self._known[key] = known
        return _copy(known) if isinstance(known, Result) else self._joined(known)

    def _find(self, perceived: Perceived, environment: Environment, seed: int, max_rounds: int) -> Segments | Result:
        case = self._case(perceived)
        if case is not None:
            segments = self._segments(case, environment, seed, max_rounds)
            if segments is not None and _rounds(segments) < max_rounds:
                return segments
        return self._run_as_a_whole(environment, seed, max_rounds)

    def _run_as_a_whole(self, environment: Environment, seed: int, max_rounds: int) -> Result:
        run = Run(environment, seed, None)
        for prototype in self._prototypes:
            run.agents[prototype.name] = prototype.agent(run)
        return Result.of(run, run.go(max_rounds))

    def _segments(self, case: Case, environment: Environment, seed: int, max_rounds: int) -> Segments | None:
        """The segments of a run, whatever rounds they take; those not known yet are run in earnest.

        None if that does not work out.
        """
        forwarding, atoms = case
        node = self._nodes.setdefault((forwarding.steering, forwarding.key, len(atoms), seed), Node())
        reached = None
        segments: Segments = []
        while True:
            # A run that comes to more nodes than there are has been at one of them twice: it will never end.
            following = follow(node, atoms, segments, len(self._nodes) + 1)
            if len(segments) > len(self._nodes):
                return None
            if following is None:
                return segments
            rounds = _rounds(segments)
            if rounds >= max_rounds:
                return None
            node = following
            if node is not reached:
                run = RecordingRun(environment, seed, self._prototypes, Notes(*case), node.states)
            recorded = run.record(max_rounds - rounds)
            if recorded is None:
                return None
            segment, states = recorded
            if states is not None:
                segment.then = reached = self._nodes.setdefault((seed, states), Node(states))
            add(node, run.notes.questions, segment)

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
            segments = None if case is None else self._segments(case, environment, seed, max_rounds)
            if case is None or segments is None or _rounds(segments) >= max_rounds:
                return None
            forwarding, listed = case
            way = self._nodes[forwarding.steering, forwarding.key, len(listed), seed].way
            if not isinstance(way, Segment) or way.then is None:
                return None
            starts[way.then, fold(way.actions, way.plans)] = None

        def complete(node: Node, chosen: frozenset[str]) -> bool:
            run = RecordingRun(environment, seed, self._prototypes, Notes(forwarding, chosen), node.states)
            return self._add(node, run, seed, max_rounds)

        found: Runs = {}
        for start, (lines, bits) in starts:
            runs = Survey(complete, fold, atoms, given).runs(start)
            if runs is None:
                return None
            for (after, more), chosen in runs.items():
                found.setdefault((lines + after, bits | more), chosen)
        return found

    def _add(self, node: Node, run: RecordingRun, seed: int, max_rounds: int) -> bool:
        """Do the next segment of a run that is at a node; False if that does not work out."""
        recorded = run.record(max_rounds)
        if recorded is None:
            return False
        segment, states = recorded
        if states is not None:
            segment.then = self._nodes.setdefault((seed, states), Node(states))
        add(node, run.notes.questions, segment)
        return True

    def _case(self, perceived: Perceived) -> Case | None:
        """How the atoms are forwarded, and the atoms; None if the percepts are not of this kind."""
        if len(perceived) != 1:
            return None
        (steering, percepts) = perceived[0]
        key = percepts[0].key
        atoms = frozenset([_atom(percept, key) for percept in percepts])
        if "" in atoms:
            return None
        if (steering, key) not in self._forwarding:
            self._forwarding[steering, key] = self._find_forwarding(steering, key)
        forwarding = self._forwarding[steering, key]
        return (forwarding, atoms) if forwarding is not None and forwarding.special.isdisjoint(atoms) else None

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


@lru_cache(maxsize=4096)
def _atom(percept: Structure, key: Key) -> str:
    """The atom that a percept ``f(b)`` of that key is about; empty if it is something else."""
    if percept.annots != (SOURCE_PERCEPT,) or percept.key != key or len(percept.args) != 1:
        return ""
    (about,) = percept.args
    if not isinstance(about, Structure) or about.args or about.annots or about.negated:
        return ""
    return about.functor


def _copy(result: Result) -> Result:
    """A result whose lists are the caller's own."""
    plans = {name: labels.copy() for name, labels in result.plans.items()}
    lists = result.prints.copy(), result.actions.copy(), result.warnings.copy()
    return result._replace(plans=plans, prints=lists[0], actions=lists[1], warnings=lists[2])
