"""A belief that is tested, but that nobody ever adds."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location

from ..model import AgentModel, Mention, System, name_of, sources_named
from ..names import nearest


class UnknownBelief:
    """Beliefs in contexts, conditions, tests and triggers that are never added, told or perceived."""

    name = "unknown-belief"
    why = "What nobody adds is never believed: a condition on it always comes out the same, a plan for it never runs."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each predicate of each agent, and for each source it is never told by."""
        for agent in system.agents:
            reported: set[object] = set()
            for mention, source in unknown(system, agent):
                key = mention.literal.key
                if (key, source) in reported:
                    continue
                reported.add((key, source))
                if source is not None:
                    yield mention.location, f"{name_of(key)} never comes from {source} to {agent.name}"
                elif suggestion(system, agent, mention) is None:
                    yield mention.location, f"nobody ever adds {name_of(key)} to the beliefs of {agent.name}"


def unknown(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str | None]]:
    """The tests of beliefs that the agent never holds, or never holds from the source that is named."""
    held = system.comes_to_hold(agent)
    answered = {plan.trigger.key for plan in agent.plans if plan.trigger.sign == "+?"}
    for mention in agent.tests:
        key = mention.literal.key
        if None in answered or ("+?", key) in answered:
            continue
        if not any(addition.may_be(key) for addition in held):
            yield mention, None
            continue
        for source in sorted(filter(None, sources_named(mention.literal))):
            if not any(addition.may_be(key, source) for addition in held):
                yield mention, source


def misspelt_perhaps(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str]]:
    """The tests of beliefs that only a variable may stand for where they are added, with the name they are near to."""
    named = {addition.key for addition in system.comes_to_hold(agent) if addition.key is not None}
    for mention in agent.tests:
        near = suggestion(system, agent, mention)
        if mention.literal.key not in named and near is not None:
            yield mention, near


def suggestion(system: System, agent: AgentModel, mention: Mention) -> str | None:
    """The name of a belief the agent does come to hold that is one letter away."""
    known = {addition.key[1] for addition in system.comes_to_hold(agent) if addition.key is not None}
    return nearest(mention.literal.functor, known)
