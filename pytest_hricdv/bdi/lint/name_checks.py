"""Lint's checks of names, which `lint` runs: beliefs, goals and agents without a counterpart, or misspelled."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pytest_hricdv.bdi.language.syntax_tree import functors_of
from pytest_hricdv.bdi.language.terms import Key, Structure, Term, Variable, is_evaluable
from pytest_hricdv.bdi.lint.model import (
    SELF,
    Addition,
    AgentModel,
    Mention,
    Problem,
    System,
    check,
    predicate_text,
    sources_in,
)
from pytest_hricdv.bdi.lint.model_builder import declaration_of
from pytest_hricdv.bdi.logic.substitution import rename_apart
from pytest_hricdv.bdi.logic.unify import unify


@check("unknown-belief", "It never holds: a condition on it always has the same result, and a plan for it never runs.")
def find_unknown_beliefs(system: System) -> Iterator[Problem]:
    """Beliefs in contexts, conditions, test goals and triggers that are never added, told or perceived."""
    for agent in system.agents:
        reported: set[object] = set()
        names = belief_names(system, agent)
        for mention, source in unknown_beliefs(system, agent):
            key = mention.literal.key
            if (key, source) in reported:
                continue
            reported.add((key, source))
            if source is not None:
                yield mention.location, f"{predicate_text(key)} never comes from {source} to {agent.name}"
            elif names.near(mention.literal.functor) is None:
                yield mention.location, f"{predicate_text(key)} is never added to the beliefs of {agent.name}"


def unknown_beliefs(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str | None]]:
    """Tests of beliefs that the agent never holds (None), or never holds from the source in the annotation."""
    held = _by_key(system.possible_beliefs(agent))
    answered = {plan.trigger.key for plan in agent.plans if plan.trigger.sign == "+?"}
    for mention in agent.tests:
        key = mention.literal.key
        if None in answered or ("+?", key) in answered:
            continue
        matching = [*held.get(None, ()), *held.get(key, ())]
        if not matching:
            yield mention, None
            continue
        for source in sorted(filter(None, sources_in(mention.literal))):
            if not any(addition.may_match(key, source) for addition in matching):
                yield mention, source


def _by_key(additions: Iterable[Addition]) -> dict[Key | None, list[Addition]]:
    found: dict[Key | None, list[Addition]] = {}
    for addition in additions:
        found.setdefault(addition.key, []).append(addition)
    return found


def possibly_misspelled(system: System, agent: AgentModel) -> Iterator[tuple[Mention, str]]:
    """Tests of beliefs that no statement adds by name, only perhaps through a variable, with a similar name."""
    named, names = {addition.key for addition in system.possible_beliefs(agent)}, belief_names(system, agent)
    for mention in agent.tests:
        near = None if mention.literal.key in named else names.near(mention.literal.functor)
        if near is not None:
            yield mention, near


def belief_names(system: System, agent: AgentModel) -> KnownNames:
    """The names of the beliefs that an agent may get."""
    return KnownNames(addition.key[1] for addition in system.possible_beliefs(agent) if addition.key is not None)


@check(
    "unmatched-deletion",
    "A deletion removes only beliefs of the source it names, by default the agent itself: this one has no effect.",
)
def find_unmatched_deletions(system: System) -> Iterator[Problem]:
    """Deletions of beliefs that the agent never holds, or never from that source."""
    for agent in system.agents:
        held = _by_key(system.possible_beliefs(agent))
        for mention in agent.deletions:
            key = mention.literal.key
            matching = [*held.get(None, ()), *held.get(key, ())]
            named = sources_in(mention.literal) or frozenset({SELF})
            if not matching:
                yield mention.location, f"{predicate_text(key)} is never added to the beliefs of {agent.name}"
            elif None not in named and not any(a.may_match(key, source) for a in matching for source in named):
                wanted = " or ".join(sorted(filter(None, named)))
                yield (
                    mention.location,
                    f"{predicate_text(key)} comes to {agent.name} from {_sources(matching)}, never from {wanted}",
                )


def _sources(additions: list[Addition]) -> str:
    return " and ".join(sorted({addition.source or "any source" for addition in additions}))


@check(
    "untested-percept",
    "Adding it has no effect: no condition, plan or deletion names it.",
)
def find_untested_percepts(system: System) -> Iterator[Problem]:
    """Declared percepts that no agent tests: what comes from outside, and changes nothing."""
    for percept, file in sorted(system.percepts, key=str):
        agents = [agent for agent in system.agents if file in (None, agent.file)]
        if any(map(_tests_any_belief, agents)):
            continue
        used = {mention.literal.functor for agent in agents for mention in (*agent.tests, *agent.deletions)}
        # Messages and other calls may be questions about beliefs.
        plans = tuple((plan.context, plan.body) for agent in agents for plan in agent.plans)
        if agents and percept not in used and percept not in functors_of(plans):
            near = one_letter_away(percept, used)
            hint = f"; did you mean {near}?" if near else ""
            place = declaration_of(percept, agents[0].file if file is None else file)
            names = " or ".join(sorted(agent.name for agent in agents))
            yield place, f"the percept {percept} is declared, and never tested by {names}{hint}"


def _tests_any_belief(agent: AgentModel) -> bool:
    """Whether a plan or query may be about any belief: its literal is a variable."""
    if any(not isinstance(plan.trigger.literal, Structure) for plan in agent.plans if len(plan.trigger.sign) == 1):
        return True
    return ".add_plan" in agent.actions or ".belief" in agent.actions


@check("goal-without-plan", "The goal always fails, and with it the plan that pursues it.")
def find_goals_without_plan(system: System) -> Iterator[Problem]:
    """Initial goals, goals in plans and goals in messages for which their agent has no plan."""
    for agent in system.agents:
        names = goal_names(agent)
        for mention, fits_by_name in goals_without_plan(system, agent):
            key = mention.literal.key
            if fits_by_name:
                yield (
                    mention.location,
                    f"no plan of {agent.name} for +!{predicate_text(key)} fits {mention.literal}",
                )
            elif names.near(mention.literal.functor) is None:
                yield mention.location, f"{agent.name} has no plan for +!{predicate_text(key)}"
    for mention in system.goals_for_unknown_receivers():
        if system.closed and not any(_has_plan(system, agent, mention, _triggers(agent)) for agent in system.agents):
            yield mention.location, f"no agent has a plan for +!{predicate_text(mention.literal.key)}"


def goals_without_plan(system: System, agent: AgentModel) -> Iterator[tuple[Mention, bool]]:
    """The goals without a plan, and whether there are plans for goals of that name and arity."""
    triggers = _triggers(agent)
    for mention in (*agent.goals, *system.goals_sent_to(agent)):
        if not _has_plan(system, agent, mention, triggers):
            yield mention, mention.literal.key in triggers


def _triggers(agent: AgentModel) -> dict[Key | None, list[Structure]]:
    """The goals that the plans of an agent are for; under None those that are not literals and match any."""
    found: dict[Key | None, list[Structure]] = {}
    for literal in (plan.trigger.literal for plan in agent.plans if plan.trigger.sign == "+!"):
        if isinstance(literal, Structure):
            found.setdefault(literal.key, []).append(literal)
        else:
            found[None] = []
    return found


def _has_plan(system: System, agent: AgentModel, mention: Mention, triggers: dict[Key | None, list[Structure]]) -> bool:
    """Whether some plan of the agent may be relevant for a goal."""
    goal = _generalize(mention.literal)
    return (
        None in triggers
        or any(unify(rename_apart(literal, "_Plan"), goal, {}, []) for literal in triggers.get(mention.literal.key, ()))
        or system.may_receive_plans(agent)
    )


def goal_names(agent: AgentModel) -> KnownNames:
    """The names of the goals for which an agent has plans."""
    return KnownNames(key[1] for key in _triggers(agent) if key is not None)


def _generalize(goal: Structure) -> Structure:
    """The goal with variables in place of computed arguments, from any source."""
    args = tuple(Variable(f"_Any{n}") if is_evaluable(arg) else arg for n, arg in enumerate(goal.args))
    any_source: Term = Structure("source", (Variable("_AnySource"),))
    return Structure(goal.functor, args, (*goal.annots, any_source), goal.negated)


@check("near-name", "A misspelled name is another name: no plan, condition or agent matches it.")
def find_near_names(system: System) -> Iterator[Problem]:
    """Names without a counterpart, while a name that differs by one letter has one."""
    for agent in system.agents:
        beliefs, goals = belief_names(system, agent), goal_names(agent)
        for mention, source in unknown_beliefs(system, agent):
            near = beliefs.near(mention.literal.functor)
            if source is None and near is not None:
                yield mention.location, f"{mention.literal.functor} is never added; did you mean {near}?"
        for mention, near in possibly_misspelled(system, agent):
            yield mention.location, f"no statement adds {mention.literal.functor} by name; did you mean {near}?"
        for mention, fits_by_name in goals_without_plan(system, agent):
            near = goals.near(mention.literal.functor)
            if not fits_by_name and near is not None:
                yield (
                    mention.location,
                    f"{agent.name} has no plan for {mention.literal.functor}; did you mean {near}?",
                )
        yield from _never_used(system, agent)
        yield from _unknown_receivers(system, agent)


def _never_used(system: System, agent: AgentModel) -> Iterator[Problem]:
    mentions = [*agent.tests, *agent.deletions]
    used = {mention.literal.functor for mention in mentions}
    names = KnownNames(used)
    if any(not isinstance(plan.trigger.literal, Structure) for plan in agent.plans if len(plan.trigger.sign) == 1):
        return
    for addition in system.possible_beliefs(agent):
        if addition.key is not None and addition.certain_receiver and addition.key[1] not in used:
            near = names.near(addition.key[1])
            if near is not None:
                yield addition.location, f"{agent.name} never tests {addition.key[1]}; did you mean {near}?"


def _unknown_receivers(system: System, agent: AgentModel) -> Iterator[Problem]:
    names = {other.name for other in system.agents}
    for message in agent.sent:
        for receiver in message.receivers or ():
            near = one_letter_away(receiver, names)
            if system.closed and receiver not in names and near is not None:
                yield message.location, f"there is no agent {receiver}; did you mean {near}?"


@check("unknown-agent", "Sending to an agent that does not exist fails, and with it the plan that sends.")
def find_unknown_agents(system: System) -> Iterator[Problem]:
    """Receivers of messages that are not agents of the project."""
    if not system.closed:
        return
    names = {agent.name for agent in system.agents}
    for agent in system.agents:
        for message in agent.sent:
            for receiver in message.receivers or ():
                if receiver not in (*names, SELF) and one_letter_away(receiver, names) is None:
                    yield message.location, f"there is no agent {receiver}; there are {', '.join(sorted(names))}"


class KnownNames:
    """Names that others may be misspellings of."""

    def __init__(self, names: Iterable[str]) -> None:
        self._by_length: dict[int, list[str]] = {}
        for name in {*names}:
            self._by_length.setdefault(len(name), []).append(name)

    def near(self, name: str) -> str | None:
        """The first that differs by one letter: inserted, deleted, replaced, or swapped with the next one."""
        lengths = (len(name) - 1, len(name), len(name) + 1)
        candidates = (other for length in lengths for other in self._by_length.get(length, ()))
        return min((other for other in candidates if differs_by_one_letter(name, other)), default=None)


def one_letter_away(name: str, candidates: Iterable[str]) -> str | None:
    """A candidate that differs by one letter, as `KnownNames.near`."""
    return KnownNames(candidates).near(name)


def differs_by_one_letter(name: str, other: str) -> bool:
    """Whether two names differ by one typing error; numbered names such as leg1 and leg2 do not."""
    # Shorter names, as ``go`` and ``do``, differ by one letter too often.
    if name == other or min(len(name), len(other)) < 3 or abs(len(name) - len(other)) > 1:
        return False
    start = next((i for i, (a, b) in enumerate(zip(name, other, strict=False)) if a != b), min(len(name), len(other)))
    left, right = name[start:], other[start:]
    if any(rest[:1].isdigit() for rest in (left, right)):
        return False
    # In this order: another letter, one too many, one too few, two that are swapped.
    return (
        left[1:] == right[1:]
        or left[1:] == right
        or left == right[1:]
        or (len(left) > 1 and left[1::-1] == right[:2] and left[2:] == right[2:])
    )
