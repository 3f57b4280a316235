"""Checks of beliefs: tests of beliefs that are never added, deletions of beliefs that are never held."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.lint.model import SELF, Addition, AgentModel, Mention, System, annotated_sources, predicate_text
from pytest_hricdv.bdi.lint.spelling import one_letter_away


class UnknownBelief:
    """Beliefs in contexts, conditions, test goals and triggers that are never added, told or perceived."""

    name = "unknown-belief"
    why = "It never holds: a condition on it always has the same result, and a plan for it never runs."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each predicate of each agent, and for each source that never adds it."""
        for agent in system.agents:
            reported: set[object] = set()
            for mention, source in unknown_beliefs(system, agent):
                key = mention.literal.key
                if (key, source) in reported:
                    continue
                reported.add((key, source))
                if source is not None:
                    yield mention.location, f"{predicate_text(key)} never comes from {source} to {agent.name}"
                elif suggestion(system, agent, mention) is None:
                    yield mention.location, f"{predicate_text(key)} is never added to the beliefs of {agent.name}"


def unknown_beliefs(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str | None]]:
    """Tests of beliefs that the agent never holds (None), or never holds from the source in the annotation."""
    held = system.possible_beliefs(agent)
    answered = {plan.trigger.key for plan in agent.plans if plan.trigger.sign == "+?"}
    for mention in agent.tests:
        key = mention.literal.key
        if None in answered or ("+?", key) in answered:
            continue
        if not any(addition.may_match(key) for addition in held):
            yield mention, None
            continue
        for source in sorted(filter(None, annotated_sources(mention.literal))):
            if not any(addition.may_match(key, source) for addition in held):
                yield mention, source


def possibly_misspelled(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str]]:
    """Tests of beliefs that no statement adds by name, only perhaps through a variable, with a similar name."""
    named = {addition.key for addition in system.possible_beliefs(agent) if addition.key is not None}
    for mention in agent.tests:
        near = suggestion(system, agent, mention)
        if mention.literal.key not in named and near is not None:
            yield mention, near


def suggestion(system: System, agent: AgentModel, mention: Mention) -> str | None:
    """The name of a belief of the agent that differs by one letter."""
    known = {addition.key[1] for addition in system.possible_beliefs(agent) if addition.key is not None}
    return one_letter_away(mention.literal.functor, known)


class UnmatchedDeletion:
    """Deletions of beliefs that the agent never holds, or never from that source."""

    name = "unmatched-deletion"
    why = "A deletion removes only beliefs of the source it names, by default the agent itself: this one has no effect."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each deletion."""
        for agent in system.agents:
            held = system.possible_beliefs(agent)
            for mention in agent.deletions:
                key = mention.literal.key
                known = [addition for addition in held if addition.may_match(key)]
                named = annotated_sources(mention.literal) or frozenset({SELF})
                if not known:
                    yield mention.location, f"{predicate_text(key)} is never added to the beliefs of {agent.name}"
                elif None not in named and not any(a.may_match(key, source) for a in known for source in named):
                    wanted = " or ".join(sorted(filter(None, named)))
                    yield (
                        mention.location,
                        f"{predicate_text(key)} comes to {agent.name} from {_sources(known)}, never from {wanted}",
                    )


def _sources(known: list[Addition]) -> str:
    return " and ".join(sorted({addition.source or "any source" for addition in known}))
