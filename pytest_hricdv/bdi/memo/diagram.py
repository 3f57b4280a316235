"""The decision diagram: nodes, the questions that lead out of them, and the segments of runs between them."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field


@dataclass(slots=True, eq=False)
class Node:
    """A mental state of all agents, up to the atoms forwarded; where a run goes from it."""

    way: Way = None


@dataclass(slots=True, eq=False)
class Question:
    """Whether an atom is among those forwarded."""

    atom: str
    yes: Way = None
    no: Way = None


@dataclass(slots=True)
class Segment:
    """What happens from one node to the next.

    Args:
        rounds: the rounds it takes.
        ticks: the ticks of the virtual clock.
        prints: what is printed.
        actions: the external actions.
        warnings: the warnings.
        plans: the agents that execute plans, and the labels of those.
        questions: the atoms that it depends on, and whether they are among those forwarded.
        ended: how the run ends with it, or empty.
    """

    rounds: int
    ticks: int
    prints: tuple[str, ...]
    actions: tuple[tuple[str, str], ...]
    warnings: tuple[str, ...]
    plans: tuple[tuple[str, tuple[str, ...]], ...]
    questions: tuple[tuple[str, bool], ...]
    ended: str = ""
    then: Node = field(default_factory=Node, repr=False)


Way = Question | Segment | None
"""None where no run has gone yet."""


def follow(node: Node, atoms: Container[str]) -> list[Segment] | None:
    """The segments of the run with a set of atoms; None if one of them is not known yet."""
    segments: list[Segment] = []
    while True:
        way = node.way
        while isinstance(way, Question):
            way = way.yes if way.atom in atoms else way.no
        if way is None:
            return None
        segments.append(way)
        if way.ended:
            return segments
        node = way.then


def add(node: Node, segment: Segment) -> Segment | None:
    """Add a segment that leaves a node.

    Returns:
        The segment that is there now: the same if it was there already. None if the diagram has a segment that
        ends elsewhere: then what follows is there, too, in other pieces.
    """
    place: Node | Question = node
    branch = "way"
    for atom, answer in segment.questions:
        question = getattr(place, branch)
        if question is None:
            question = Question(atom)
            setattr(place, branch, question)
        if not isinstance(question, Question) or question.atom != atom:
            return None
        place, branch = question, "yes" if answer else "no"
    there = getattr(place, branch)
    if there is None:
        setattr(place, branch, segment)
        return segment
    return there if isinstance(there, Segment) and there.rounds == segment.rounds else None
