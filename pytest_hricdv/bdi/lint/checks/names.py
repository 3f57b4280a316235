"""Checks of names: those one letter away from a name in use, and receivers that are not in the project."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.lint.checks import beliefs, goals
from pytest_hricdv.bdi.lint.model import SELF, AgentModel, System
from pytest_hricdv.bdi.lint.spelling import one_letter_away


class NearName:
    """Names without a counterpart, while a name that differs by one letter has one."""

    name = "near-name"
    why = "A misspelled name is another name: no plan, condition or agent matches it."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """Beliefs tested but never added, added but never tested, goals without plans, receivers that do not exist."""
        for agent in system.agents:
            for mention, source in beliefs.unknown_beliefs(system, agent):
                near = beliefs.suggestion(system, agent, mention)
                if source is None and near is not None:
                    yield mention.location, f"{mention.literal.functor} is never added; did you mean {near}?"
            for mention, near in beliefs.possibly_misspelled(system, agent):
                yield mention.location, f"no statement adds {mention.literal.functor} by name; did you mean {near}?"
            for mention, fits_by_name in goals.goals_without_plan(system, agent):
                near = goals.suggestion(agent, mention)
                if not fits_by_name and near is not None:
                    yield (
                        mention.location,
                        f"{agent.name} has no plan for {mention.literal.functor}; did you mean {near}?",
                    )
            yield from _never_used(system, agent)
            yield from _misspelled_receivers(system, agent)


def _never_used(system: System, agent: AgentModel) -> Iterator[tuple[Location, str]]:
    mentions = [*agent.tests, *agent.deletions]
    used = {mention.literal.functor for mention in mentions}
    if any(not isinstance(plan.trigger.literal, Structure) for plan in agent.plans if len(plan.trigger.sign) == 1):
        return
    for addition in system.possible_beliefs(agent):
        if addition.key is not None and addition.certain_receiver and addition.key[1] not in used:
            near = one_letter_away(addition.key[1], used)
            if near is not None:
                yield addition.location, f"{agent.name} never tests {addition.key[1]}; did you mean {near}?"


def _misspelled_receivers(system: System, agent: AgentModel) -> Iterator[tuple[Location, str]]:
    names = {other.name for other in system.agents}
    for message in agent.sent:
        for receiver in message.receivers or ():
            near = one_letter_away(receiver, names)
            if system.closed and receiver not in names and near is not None:
                yield message.location, f"there is no agent {receiver}; did you mean {near}?"


class UnknownAgent:
    """Receivers of messages that are not agents of the project."""

    name = "unknown-agent"
    why = "Sending to an agent that does not exist fails, and with it the plan that sends."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each message; none for a single source file, since other agents are unknown."""
        if not system.closed:
            return
        names = {agent.name for agent in system.agents}
        for agent in system.agents:
            for message in agent.sent:
                for receiver in message.receivers or ():
                    if receiver not in (*names, SELF) and one_letter_away(receiver, names) is None:
                        yield message.location, f"there is no agent {receiver}; there are {', '.join(sorted(names))}"
