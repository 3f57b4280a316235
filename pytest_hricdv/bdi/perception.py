"""Belief update from percepts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

if TYPE_CHECKING:
    from .agent import Agent


def perceive(agent: Agent) -> None:
    """Make what the agent believes as percepts what its environment lists.

    Called only when that list has changed: a percept the agent itself has deleted stays deleted until then.
    """
    agent.run.progress += 1
    listed = agent.run.environment.percepts(agent.name)
    before, agent.listed = agent.listed, listed
    believed = [belief.without_annotations() for belief in agent.beliefs.with_annotation(SOURCE_PERCEPT)]
    if believed:
        _forget(agent, believed, before, listed)
    for percept in listed:
        agent.believe(percept)


def _forget(
    agent: Agent, believed: list[Structure], before: tuple[Structure, ...], listed: tuple[Structure, ...]
) -> None:
    """Believe no longer as percepts what is not listed any more.

    In the order in which they were listed before; last what the agent itself has taken for a percept.
    """
    still_perceived = {percept.without_annotations() for percept in listed}
    listed_before = {percept.without_annotations(): place for place, percept in enumerate(before)}
    for plain in sorted(believed, key=lambda plain: listed_before.get(plain, len(listed_before))):
        if plain not in still_perceived:
            agent.disbelieve(Structure(plain.functor, plain.args, (SOURCE_PERCEPT,), plain.negated))
