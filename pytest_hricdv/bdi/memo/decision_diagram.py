"""The decision diagram: nodes, the decisions that lead out of them, and the segments of runs between them."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field
from typing import final

from pytest_hricdv.bdi.memo.snapshot import AgentSnapshot


@dataclass(slots=True, eq=False)
class Node:
    """A point of a run between two segments, and where it continues.

    Args:
        states: the mental states of all agents in order, up to the atoms forwarded; None at the beginning of a run.
    """

    states: tuple[AgentSnapshot, ...] | None = None
    edge: Edge = None


@final
@dataclass(slots=True, eq=False)
class Decision:
    """Whether an atom is among those forwarded."""

    atom: str
    yes: Edge = None
    no: Edge = None


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


Edge = Decision | Segment | None
"""None where no run has been executed yet."""


def follow(node: Node, atoms: Container[str], segments: list[Segment], most: int) -> Node | None:
    """Follow the diagram from a node as far as it is known.

    Args:
        node: the node.
        atoms: those that are forwarded.
        segments: those of the run so far; the ones that follow are added.
        most: how many there may be in the end.

    Returns:
        The node reached; None if the run ends.
    """
    for _ in range(most - len(segments)):
        edge = node.edge
        while type(edge) is Decision:
            edge = edge.yes if edge.atom in atoms else edge.no
        if edge is None:
            break
        segments.append(edge)
        if edge.then is None:
            return None
        node = edge.then
    return node


def add(node: Node, answers: dict[str, bool], segment: Segment) -> None:
    """Add a segment that leaves a node.

    Args:
        node: the node.
        answers: the atoms queried in the segment, in order, and whether they are among those forwarded. The next
            query is a function of the node and the answers so far: up to there, the decisions are the same.
        segment: the segment.
    """
    place: Node | Decision = node
    branch = "edge"
    for atom, answer in answers.items():
        decision = getattr(place, branch)
        if decision is None:
            decision = Decision(atom)
            setattr(place, branch, decision)
        assert isinstance(decision, Decision)
        assert decision.atom == atom
        place, branch = decision, "yes" if answer else "no"
    setattr(place, branch, segment)
