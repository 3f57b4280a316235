"""Belief updates as statements: ``+b``, ``-b``, ``-+b``, ``++b``."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.syntax import BeliefUpdate
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.logic.inference import first

from .instances import Maker, maker_of
from .intentions import Frame, Intention

if TYPE_CHECKING:
    from .agent import Agent
    from .execution import Step


def believe(statement: BeliefUpdate) -> Step:
    """How to update a belief: a change posts an event that the intention waits for; otherwise it goes on by itself."""
    ready = statement.event_literal
    make: Maker = maker_of(statement.literal) if ready is None else lambda agent, frame: ready
    return _UPDATES[statement.sign](make)


def _add(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        new = agent.beliefs.add(make(agent, frame))
        if new is None:
            return True
        agent.run.progress += 1
        return agent.has_updated("+", new, intention, frame)

    return step


def _add_apart(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        agent.believe(make(agent, frame))
        return True

    return step


def _replace(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        literal = make(agent, frame)
        held = agent.beliefs.replace(literal)
        if held is not None:
            agent.run.progress += 2
            return agent.has_updated("+", literal, intention, frame, held)
        _delete_any(agent, literal)
        new = agent.beliefs.add(literal)
        if new is None:
            return True
        agent.run.progress += 1
        return agent.has_updated("+", new, intention, frame)

    return step


def _delete(make: Maker) -> Step:
    def step(agent: Agent, intention: Intention, frame: Frame) -> bool:
        literal = make(agent, frame)
        found = literal if literal.ground else _first_match(agent, frame, literal)
        if found is None or not agent.beliefs.remove(found):
            return True
        agent.run.progress += 1
        return agent.has_updated("-", found, intention, frame)

    return step


def _first_match(agent: Agent, frame: Frame, literal: Structure) -> Structure | None:
    """The first belief that matches, as that literal; None if there is none."""
    solution = first(agent, literal, frame.unifier)
    if solution is None:
        return None
    frame.unifier = solution
    found = agent.value(literal, solution)
    return found if isinstance(found, Structure) else None


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
                agent.disbelieve(held.with_annotations(annots))
                return


_UPDATES = {"+": _add, "++": _add_apart, "-+": _replace, "-": _delete}
