"""The decision diagram: nodes, the questions that lead out of them, and the segments of runs between them."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field
from typing import final

from .state import MentalState


@dataclass(slots=True, eq=False)
class Node:
    """Where a run is between two segments, and where it goes from there.

    Args:
        states: the mental states of all agents in order, up to the atoms forwarded; None at the beginning of a run.
    """

    states: tuple[MentalState, ...] | None = None
    way: Way = None


@final
@dataclass(slots=True, eq=False)
class Question:
    """Whether an atom is among those forwarded."""

    atom: str
    yes: Way = None
    no: Way = None


@dataclass(slots=True, eq=False)
class Segment:
    """What happens from one node to the next.

    Args:
        rounds: the rounds it takes.
        ticks: the ticks of the virtual clock.
        prints: what is printed.
        actions: the external actions.
        warnings: the warnings.
        plans: the agents that execute plans, and the labels of those.
        ended: how the run ends with it, or empty.
        then: the node it leads to; None if the run ends.
    """

    rounds: int
    ticks: int
    prints: list[str]
    actions: list[tuple[str, str]]
    warnings: list[str]
    plans: list[tuple[str, list[str]]]
    ended: str = ""
    then: Node | None = field(default=None, repr=False)


Way = Question | Segment | None
"""None where no run has gone yet."""


def follow(node: Node, atoms: Container[str], segments: list[Segment], most: int) -> Node | None:
    """Go on from a node as far as is known.

    Args:
        node: the node.
        atoms: those that are forwarded.
        segments: those of the run so far; the ones that follow are added.
        most: how many there may be in the end.

    Returns:
        The node reached; None if the run ends.
    """
    for _ in range(most - len(segments)):
        way = node.way
        while type(way) is Question:
            way = way.yes if way.atom in atoms else way.no
        if way is None:
            break
        segments.append(way)
        if way.then is None:
            return None
        node = way.then
    return node


def add(node: Node, questions: dict[str, bool], segment: Segment) -> None:
    """Add a segment that leaves a node.

    Args:
        node: the node.
        questions: the atoms asked about in the segment, in order, and whether they are among those forwarded. What
            is asked next is a function of the node and the answers so far: so far it is asked here, too.
        segment: the segment.
    """
    place: Node | Question = node
    branch = "way"
    for atom, answer in questions.items():
        question = getattr(place, branch)
        if question is None:
            question = Question(atom)
            setattr(place, branch, question)
        assert isinstance(question, Question)
        assert question.atom == atom
        place, branch = question, "yes" if answer else "no"
    setattr(place, branch, segment)
