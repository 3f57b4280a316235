"""A survey: every run that there is, over all sets of atoms that could be forwarded.

There are as many sets as subsets, but few of them make a difference: the decision diagram has an edge for each segment
that any set leads to. So the diagram is completed first, node by node, whatever led there; then the runs are put
together from the end, so that what follows from a node is worked out once for all runs that come to it.

A node may be reached with an answer that a later question asks for again: the runs from a node depend on the answers so
far to what can still be asked. Runs with equal content are one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from pytest_hricdv.bdi.memo.decision_diagram import Decision, Edge, Node, Segment

Lines = tuple[str, ...]
Content = tuple[Lines, int]
"""What is of interest of a run: texts in order, and a bit set."""
Fold = Callable[[Sequence[tuple[str, str]], Sequence[tuple[str, list[str]]]], Content]
Answers = frozenset[tuple[str, bool]]
Runs = dict[Content, frozenset[str]]
"""Each run with a set of atoms that leads to it."""
MAX_NODES = 5_000
MAX_RUNS = 50_000


class TooLargeError(Exception):
    """There are more nodes or runs than a survey takes on."""


class NeverEndsError(Exception):
    """A run comes to the same node twice."""


@dataclass
class ExhaustiveExploration:
    """Surveys the runs from a node.

    Args:
        complete: does the next segment from a node with these atoms, and adds it to the diagram; False if that does not
            work out.
        fold: what is of interest of the actions and plans of a segment.
        atoms: what sets are made of; nothing else is forwarded.
        given: atoms that are in every set that counts, or in none.
    """

    complete: Callable[[Node, frozenset[str]], bool]
    fold: Fold
    atoms: frozenset[str]
    given: Mapping[str, bool]
    _later: dict[Node, frozenset[str]] = field(default_factory=dict)
    """What can be asked from a node on, as far as is known."""
    _known: dict[tuple[Node, Answers], Runs | None] = field(default_factory=dict)
    _contents: dict[Segment, Content] = field(default_factory=dict)
    _held: int = 0

    def runs(self, start: Node) -> Runs | None:
        """All runs from a node; None if one of them cannot be told apart piece by piece, or never ends.

        Raises:
            TooLargeError: there are too many.
        """
        while True:
            nodes = self._visit(start)
            if nodes is None:
                return None
            later = self._asked_later(nodes)
            if all(self._later.get(node) == asked for node, asked in later.items()):
                break
            # Runs were taken for equal that a later question tells apart: visit them again, now that it is known.
            self._later = later
        try:
            return self._runs(start, self._relevant(start, self.given))
        except NeverEndsError:
            return None

    def _visit(self, start: Node) -> list[Node] | None:
        """Every node that a set of atoms leads to; for all of these sets the diagram is complete then."""
        found: dict[Node, None] = {}
        visited: set[tuple[Node, Answers]] = set()
        pending: list[tuple[Node, Mapping[str, bool]]] = [(start, self.given)]
        while pending:
            node, known = pending.pop()
            key = (node, self._relevant(node, known))
            if key in visited:
                continue
            visited.add(key)
            found[node] = None
            if len(visited) > MAX_NODES:
                raise TooLargeError
            while (gap := self._gap(node, known)) is not None:
                if not self.complete(node, gap):
                    return None
            for answers, edge in self._edges(node, known):
                if isinstance(edge, Segment) and edge.then is not None:
                    pending.append((edge.then, {**known, **answers}))
        return list(found)

    def _relevant(self, node: Node, known: Mapping[str, bool]) -> Answers:
        asked = self._later.get(node, frozenset())
        return frozenset(item for item in known.items() if item[0] in asked)

    def _runs(self, node: Node, known: Answers) -> Runs:
        key = (node, known)
        if key not in self._known:
            self._known[key] = None
            self._known[key] = runs = self._put_together(node, dict(known))
            self._held += len(runs)
            if len(runs) > MAX_RUNS or self._held > 8 * MAX_RUNS:
                raise TooLargeError
        found = self._known[key]
        if found is None:
            raise NeverEndsError
        return found

    def _put_together(self, node: Node, known: Mapping[str, bool]) -> Runs:
        runs: Runs = {}
        for answers, segment in self._edges(node, known):
            assert isinstance(segment, Segment)
            lines, bits = self._content(segment)
            chosen = frozenset(atom for atom, answer in answers.items() if answer)
            for (after, later_bits), more in self._following(segment, {**known, **answers}).items():
                content, atoms = (lines + after, bits | later_bits), chosen | more
                if content not in runs or len(atoms) < len(runs[content]):
                    runs[content] = atoms
        return runs

    def _following(self, segment: Segment, known: Mapping[str, bool]) -> Runs:
        if segment.then is None:
            return {((), 0): frozenset()}
        return self._runs(segment.then, self._relevant(segment.then, known))

    def _content(self, segment: Segment) -> Content:
        if segment not in self._contents:
            self._contents[segment] = self.fold(segment.actions, segment.plans)
        return self._contents[segment]

    def _edges(self, node: Node, known: Mapping[str, bool]) -> Iterator[tuple[dict[str, bool], Edge]]:
        """Where a node's questions lead with what is known, each with the answers on the edge."""
        pending: list[tuple[dict[str, bool], Edge]] = [({}, node.edge)]
        while pending:
            answers, here = pending.pop()
            if not isinstance(here, Decision):
                yield answers, here
                continue
            certain = known.get(here.atom, None if here.atom in self.atoms else False)
            for answer, edge in ((False, here.no), (True, here.yes)):
                if certain is None or certain == answer:
                    pending.append(({**answers, here.atom: answer}, edge))

    def _gap(self, node: Node, known: Mapping[str, bool]) -> frozenset[str] | None:
        """Atoms with which it is not known how to go on from a node; None if all is known."""
        for answers, edge in self._edges(node, known):
            if edge is None:
                return frozenset(atom for atom, answer in {**known, **answers}.items() if answer)
        return None

    def _asked_later(self, nodes: Sequence[Node]) -> dict[Node, frozenset[str]]:
        """What can be asked from each node on: the least that holds."""
        edges = {node: [(set(answers), edge) for answers, edge in self._edges(node, {})] for node in nodes}
        later = {node: frozenset(atom for answers, _ in edges[node] for atom in answers) for node in nodes}
        changed = True
        while changed:
            changed = False
            for node in reversed(nodes):
                followers = [edge.then for _, edge in edges[node] if isinstance(edge, Segment) and edge.then in later]
                asked = later[node].union(*(later[follower] for follower in followers if follower is not None))
                changed = changed or asked != later[node]
                later[node] = asked
        return later
