"""A name that is one letter away from the one that was probably meant."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.terms import Structure

from ..model import AgentModel, System
from ..names import nearest
from . import goal_without_plan, unknown_belief


class NearName:
    """Names that nothing answers to, while a name that differs by one letter is in use."""

    name = "near-name"
    why = "A misspelt name is a name of its own: whatever is said with it reaches nobody."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """Beliefs tested but never added, added but never used, goals without plans, agents that there are not."""
        for agent in system.agents:
            for mention, source in unknown_belief.unknown(system, agent):
                near = unknown_belief.suggestion(system, agent, mention)
                if source is None and near is not None:
                    yield mention.location, f"nobody ever adds {mention.literal.functor}: is it {near}?"
            for mention, near in unknown_belief.misspelt_perhaps(system, agent):
                yield mention.location, f"nobody names {mention.literal.functor} when adding a belief: is it {near}?"
            for mention, fits_by_name in goal_without_plan.without_plan(system, agent):
                near = goal_without_plan.suggestion(agent, mention)
                if not fits_by_name and near is not None:
                    yield mention.location, f"{agent.name} has no plan for {mention.literal.functor}: is it {near}?"
            yield from _never_used(system, agent)
            yield from _nobody(system, agent)


def _never_used(system: System, agent: AgentModel) -> Iterator[tuple[Location, str]]:
    mentions = [*agent.tests, *agent.deletions]
    used = {mention.literal.functor for mention in mentions}
    if any(not isinstance(plan.trigger.literal, Structure) for plan in agent.plans if len(plan.trigger.sign) == 1):
        return
    for addition in system.comes_to_hold(agent):
        if addition.key is not None and addition.surely and addition.key[1] not in used:
            near = nearest(addition.key[1], used)
            if near is not None:
                yield addition.location, f"{agent.name} never looks at {addition.key[1]}: is it {near}?"


def _nobody(system: System, agent: AgentModel) -> Iterator[tuple[Location, str]]:
    names = {other.name for other in system.agents}
    for message in agent.sent:
        for receiver in message.receivers or ():
            near = nearest(receiver, names)
            if system.closed and receiver not in names and near is not None:
                yield message.location, f"there is no agent {receiver}: is it {near}?"
