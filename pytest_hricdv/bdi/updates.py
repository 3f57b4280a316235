"""Belief updates as statements: ``+b``, ``-b``, ``-+b``, ``++b``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .inference import first
from .instances import Maker, maker_of
from .intentions import Frame, Intention
from .syntax import Believe
from .terms import Structure

if TYPE_CHECKING:
    from .agent import Agent
    from .execution import Step


def believe(statement: Believe) -> Step:
    """How to update a belief: a change posts an event that the intention waits for; otherwise it goes on by itself."""
    ready = statement.ready
    make: Maker = maker_of(statement.literal) if ready is None else lambda agent, frame: ready
    return _UPDATES[statement.sign](make)


def _add(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        if not agent.believe(make(agent, frame), intention):
            agent.go_on(intention)

    return step


def _add_apart(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        agent.believe(make(agent, frame), None)
        agent.go_on(intention)

    return step


def _replace(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        literal = make(agent, frame)
        held = agent.beliefs.replace(literal)
        if held is not None:
            agent.run.progress += 2
            agent.post("-", held, None)
            agent.post("+", literal, intention)
            return
        _delete_any(agent, literal)
        if not agent.believe(literal, intention):
            agent.go_on(intention)

    return step


def _delete(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> None:
        literal = make(agent, frame)
        if literal.ground:
            changed = agent.disbelieve(literal, intention)
        else:
            changed = _delete_first(agent, intention, frame, literal)
        if not changed:
            agent.go_on(intention)

    return step


def _delete_first(agent: Agent, intention: Intention, frame: Frame, literal: Structure) -> bool:
    """Delete the first belief that matches, if any."""
    solution = first(agent, literal, frame.unifier)
    if solution is None:
        return False
    frame.unifier = solution
    found = agent.value(literal, solution)
    return isinstance(found, Structure) and agent.disbelieve(found, intention)


def _delete_any(agent: Agent, literal: Structure) -> None:
    """For ``-+``: delete the first belief of that predicate and these sources, whatever its arguments."""
    annots = literal.annots
    # Nothing is looked at after the deletion.
    for held in reversed(agent.beliefs.bucket(literal.key).values()):
        if isinstance(held, Structure):
            if held.annots == annots:
                agent.disbelieve(held)
                return
            if all(annot in held.annots for annot in annots):
                agent.disbelieve(held.annotated(annots))
                return


_UPDATES = {"+": _add, "++": _add_apart, "-+": _replace, "-": _delete}
