"""The memo's decision diagram: the `Segment`s of runs between `StateNode`s, and the `AtomDecision`s that select one.

`Memo` follows the diagram in a run and adds missing segments; `ExhaustiveExploration` finds all runs through it.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

from pytest_hricdv.bdi.memo.snapshot import AgentSnapshot


@dataclass(slots=True, eq=False)
class StateNode:
    """A point of a run between two segments, and where it continues.

    Args:
        states: the mental states of all agents in order, up to the atoms forwarded; None at the beginning of a run.
    """

    states: tuple[AgentSnapshot, ...] | None = None
    edge: Edge = None


@final
@dataclass(slots=True, eq=False)
class AtomDecision:
    """Whether an atom is among those forwarded."""

    atom: str
    yes: Edge = None
    no: Edge = None


@dataclass(slots=True, eq=False)
class Segment:
    """The events from one node to the next.

    Args:
        rounds, ticks: how many rounds, and ticks of the virtual clock, it takes.
        prints, actions, warnings: the texts printed, the external actions, and the warnings.
        plans: the agents that execute plans, and the labels of those.
        ended: how the run ends with it, or empty.
        endless: the plans that had not ended then.
        then: the node it leads to; None if the run ends.
    """

    rounds: int
    ticks: int
    prints: list[str]
    actions: list[tuple[str, str]]
    warnings: list[str]
    plans: list[tuple[str, list[str]]]
    ended: str = ""
    endless: list[str] = field(default_factory=list)
    then: StateNode | None = field(default=None, repr=False)


Edge = AtomDecision | Segment | None
"""None if no run has been executed yet."""


def follow(node: StateNode, atoms: Container[str], segments: list[Segment], most: int) -> StateNode | None:
    """Follow the diagram from a node as far as it is known.

    Args:
        atoms: those that are forwarded.
        segments: those of the run so far; the ones that follow are added.
        most: how many there may be in the end.

    Returns:
        The node reached; None if the run ends.
    """
    for _ in range(most - len(segments)):
        edge = node.edge
        while type(edge) is AtomDecision:
            edge = edge.yes if edge.atom in atoms else edge.no
        if edge is None:
            break
        segments.append(edge)
        if edge.then is None:
            return None
        node = edge.then
    return node


def add(node: StateNode, answers: dict[str, bool], segment: Segment) -> None:
    """Add a segment that leaves a node.

    Args:
        answers: the atoms queried in the segment, in order, and whether they are among those forwarded. The next
            query is a function of the node and the answers so far: up to there, the decisions are the same.
    """
    place: StateNode | AtomDecision = node
    branch = "edge"
    for atom, answer in answers.items():
        decision = getattr(place, branch)
        if decision is None:
            decision = AtomDecision(atom)
            setattr(place, branch, decision)
        assert isinstance(decision, AtomDecision)
        assert decision.atom == atom
        place, branch = decision, "yes" if answer else "no"
    setattr(place, branch, segment)


Lines = tuple[str, ...]
Content = tuple[Lines, int]
"""The relevant content of a run: texts in order, and a bit set."""
Fold = Callable[[Sequence[tuple[str, str]], Sequence[tuple[str, list[str]]]], Content]
Answers = frozenset[tuple[str, bool]]
Runs = dict[Content, frozenset[str]]
"""Each run with a set of atoms that leads to it."""
MAX_NODES = 5_000
"""Most nodes, each with the answers that matter there, of one exploration: 35 times the most of the table's, 143."""
MAX_RUNS = 50_000
"""Most runs from one node: nearly four times the most of the table's, 13,122, which are found in a second. All nodes
together, whose runs are held at the same time, may have eight times as many: the table's have 72,161."""


class TooLargeError(Exception):
    """There are more nodes or runs than the limit of an exhaustive exploration."""


class NeverEndsError(Exception):
    """A run comes to the same node twice."""


@dataclass
class ExhaustiveExploration:
    """Finds every run over all sets of atoms that could be forwarded, without executing a run for every set.

    There are exponentially many sets, but few of them make a difference: the diagram has an edge for each segment that
    any set leads to. So the diagram is completed first, node by node, for all sets that lead to a node; then the runs
    are composed from the end, so that the continuations of a node are computed once for all runs that reach it.

    A node may be reached with an answer that a later decision needs again: the runs from a node depend on those answers
    so far that can still be needed. Runs with equal content are one.

    Args:
        complete: executes the next segment from a node with these atoms, and adds it to the diagram; False if that is
            not possible.
        fold: what is of interest of the actions and plans of a segment.
        atoms: the atoms that sets are made of; nothing else is forwarded.
        fixed: atoms that are in every set that counts, or in none.
    """

    complete: Callable[[StateNode, frozenset[str]], bool]
    fold: Fold
    atoms: frozenset[str]
    fixed: Mapping[str, bool]
    _later: dict[StateNode, frozenset[str]] = field(default_factory=dict)
    """The atoms that can be queried from a node on, as far as is known."""
    _runs_from: dict[tuple[StateNode, Answers], Runs | None] = field(default_factory=dict)
    _contents: dict[Segment, Content] = field(default_factory=dict)
    _held: int = 0

    def runs(self, start: StateNode) -> Runs | None:
        """All runs from a node; None if one of them cannot be separated into segments, or never ends.

        Raises:
            TooLargeError: there are too many.
        """
        while True:
            nodes = self._visit(start)
            if nodes is None:
                return None
            later = self._queries_from(nodes)
            if all(self._later.get(node) == asked for node, asked in later.items()):
                break
            # Runs that a later query distinguishes have been treated as equal: visit them again.
            self._later = later
        try:
            return self._runs(start, self._relevant(start, self.fixed))
        except NeverEndsError:
            return None

    def _visit(self, start: StateNode) -> list[StateNode] | None:
        """Complete the diagram for all sets of atoms; the nodes that these lead to."""
        nodes: dict[StateNode, None] = {}
        visited: set[tuple[StateNode, Answers]] = set()
        pending: list[tuple[StateNode, Mapping[str, bool]]] = [(start, self.fixed)]
        while pending:
            node, decided = pending.pop()
            key = (node, self._relevant(node, decided))
            if key in visited:
                continue
            visited.add(key)
            nodes[node] = None
            if len(visited) > MAX_NODES:
                raise TooLargeError
            while (gap := self._gap(node, decided)) is not None:
                if not self.complete(node, gap):
                    return None
            for answers, edge in self._edges(node, decided):
                if isinstance(edge, Segment) and edge.then is not None:
                    pending.append((edge.then, {**decided, **answers}))
        return list(nodes)

    def _relevant(self, node: StateNode, decided: Mapping[str, bool]) -> Answers:
        asked = self._later.get(node, frozenset())
        return frozenset(item for item in decided.items() if item[0] in asked)

    def _runs(self, node: StateNode, decided: Answers) -> Runs:
        key = (node, decided)
        if key not in self._runs_from:
            self._runs_from[key] = None  # whoever comes here before the runs are there has come round in a circle
            self._runs_from[key] = runs = self._compose(node, dict(decided))
            self._held += len(runs)
            if len(runs) > MAX_RUNS or self._held > 8 * MAX_RUNS:
                raise TooLargeError
        cached = self._runs_from[key]
        if cached is None:
            raise NeverEndsError
        return cached

    def _compose(self, node: StateNode, decided: Mapping[str, bool]) -> Runs:
        runs: Runs = {}
        for answers, segment in self._edges(node, decided):
            assert isinstance(segment, Segment)
            lines, bits = self._content(segment)
            chosen = frozenset(atom for atom, answer in answers.items() if answer)
            for (after, later_bits), more in self._runs_after(segment, {**decided, **answers}).items():
                content, atoms = (lines + after, bits | later_bits), chosen | more
                # Keep one of the smallest sets that lead to a run: it is shown to people.
                if content not in runs or len(atoms) < len(runs[content]):
                    runs[content] = atoms
        return runs

    def _runs_after(self, segment: Segment, decided: Mapping[str, bool]) -> Runs:
        if segment.then is None:
            return {((), 0): frozenset()}
        return self._runs(segment.then, self._relevant(segment.then, decided))

    def _content(self, segment: Segment) -> Content:
        if segment not in self._contents:
            self._contents[segment] = self.fold(segment.actions, segment.plans)
        return self._contents[segment]

    def _edges(self, node: StateNode, decided: Mapping[str, bool]) -> Iterator[tuple[dict[str, bool], Edge]]:
        """The edges that leave a node under the answers decided so far, each with the answers that it needs."""
        pending: list[tuple[dict[str, bool], Edge]] = [({}, node.edge)]
        while pending:
            answers, here = pending.pop()
            if not isinstance(here, AtomDecision):
                yield answers, here
                continue
            certain = decided.get(here.atom, None if here.atom in self.atoms else False)
            for answer, edge in ((False, here.no), (True, here.yes)):
                if certain is None or certain == answer:
                    pending.append(({**answers, here.atom: answer}, edge))

    def _gap(self, node: StateNode, decided: Mapping[str, bool]) -> frozenset[str] | None:
        """Atoms for which the diagram has no edge at a node; None if it is complete there."""
        for answers, edge in self._edges(node, decided):
            if edge is None:
                return frozenset(atom for atom, answer in {**decided, **answers}.items() if answer)
        return None

    def _queries_from(self, nodes: Sequence[StateNode]) -> dict[StateNode, frozenset[str]]:
        """The atoms that can be queried from each node on: a least fixed point."""
        edges = {node: [(set(answers), edge) for answers, edge in self._edges(node, {})] for node in nodes}
        later = {node: frozenset(atom for answers, _ in edges[node] for atom in answers) for node in nodes}
        changed = True
        while changed:
            changed = False
            for node in reversed(nodes):  # mostly followers first: then few passes are needed
                followers = [edge.then for _, edge in edges[node] if isinstance(edge, Segment) and edge.then in later]
                asked = later[node].union(*(later[follower] for follower in followers if follower is not None))
                changed = changed or asked != later[node]
                later[node] = asked
        return later
