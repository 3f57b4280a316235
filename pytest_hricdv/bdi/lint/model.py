"""A multi-agent system as lint sees it: the beliefs, tests, goals and messages of each agent.

`model_builder` makes an `AgentModel` of each program. Each check, a function registered by `check`, gets a `System`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax import Plan, Rule
from pytest_hricdv.bdi.language.terms import Key, Structure, Term, Variable

SELF = "self"
PERCEPT = "percept"
"""Sources of beliefs: the agent itself, and what it perceives."""


@dataclass(frozen=True, slots=True)
class Mention:
    """An occurrence of a literal: a belief that is tested or deleted, or a goal."""

    literal: Structure
    location: Location
    plan: Plan | None = None


@dataclass(frozen=True, slots=True)
class Addition:
    """A belief that an agent may get.

    Args:
        key: its predicate; None for any, if a variable stands for the belief.
        source: its source; None for any.
        location: where it is added, sent or declared.
        during_run: whether it is added during a run; initial beliefs are not.
        certain_receiver: whether it is certain that this agent gets it; not if the receiver is a variable.
    """

    key: Key | None
    source: str | None
    location: Location
    during_run: bool = True
    certain_receiver: bool = True

    def may_match(self, key: Key, source: str | None = None) -> bool:
        """Whether it may be a belief of that predicate and source."""
        return self.key in (None, key) and (source is None or self.source in (None, source))


@dataclass(frozen=True, slots=True)
class SentMessage:
    """A message that an agent sends.

    Args:
        force: its illocutionary force, or empty if a variable stands for it.
        receivers: the names of the receivers; None for a variable or a broadcast.
        content: its propositional content.
        location: where it is sent.
        answered: whether the sender waits for the answer.
        broadcast: whether it goes to all others.
    """

    force: str
    receivers: tuple[str, ...] | None
    content: Term
    location: Location
    answered: bool
    broadcast: bool

    @property
    def goals(self) -> list[Mention]:
        """The goals that it delegates to its receivers."""
        items = getattr(self.content, "items", (self.content,)) if self.force == "achieve" else ()
        return [Mention(item, self.location) for item in items if isinstance(item, Structure)]


@dataclass(slots=True)
class AgentModel:
    """The content of one agent's source."""

    name: str
    file: str
    plans: tuple[Plan, ...] = ()
    rules: tuple[Rule, ...] = ()
    additions: list[Addition] = field(default_factory=list)
    tests: list[Mention] = field(default_factory=list)
    deletions: list[Mention] = field(default_factory=list)
    goals: list[Mention] = field(default_factory=list)
    sent: list[SentMessage] = field(default_factory=list)
    actions: set[str] = field(default_factory=set)
    """The internal actions it uses."""


@dataclass(frozen=True, slots=True)
class System:
    """The agents that run together.

    Args:
        agents: the agents, one for each name.
        closed: whether there are no other agents, as in a project; to a single source file, others may send anything.
        percepts: the declared names of percepts, each with the file that declares it, or None.
    """

    agents: tuple[AgentModel, ...]
    closed: bool
    percepts: frozenset[tuple[str, str | None]]

    def possible_beliefs(self, agent: AgentModel) -> list[Addition]:
        """All beliefs that an agent may get: its own, those told by others, and percepts."""
        additions = list(agent.additions)
        for sender in self.agents:
            for message in sender.sent:
                if message.force in ("tell", "signal") and self._reaches(message, sender, agent):
                    additions += _beliefs_told(message, SELF if sender is agent else sender.name)
                elif message.force in ("askOne", "askAll") and sender is agent and not message.answered:
                    additions += _beliefs_told(message, None)
        additions += self._from_environment(agent)
        return additions

    def _from_environment(self, agent: AgentModel) -> list[Addition]:
        additions = []
        mentions = [*agent.tests, *agent.deletions]
        declared = {name for name, file in self.percepts if file in (None, agent.file)}
        for mention in mentions:
            literal, sources = mention.literal, sources_in(mention.literal)
            if literal.functor in declared or PERCEPT in sources:
                additions.append(Addition(literal.key, PERCEPT, mention.location))
            if not self.closed:
                additions += [Addition(literal.key, source, mention.location) for source in sources - {SELF, PERCEPT}]
        return additions

    def goals_sent_to(self, agent: AgentModel) -> list[Mention]:
        """The goals that are sent to an agent by name or by broadcast."""
        return [
            goal
            for sender in self.agents
            for message in sender.sent
            if (message.receivers is not None or message.broadcast) and self._reaches(message, sender, agent)
            for goal in message.goals
        ]

    def goals_for_unknown_receivers(self) -> list[Mention]:
        """The goals in messages whose receiver is a variable."""
        messages = [message for sender in self.agents for message in sender.sent]
        return [goal for m in messages if m.receivers is None and not m.broadcast for goal in m.goals]

    def may_receive_plans(self, agent: AgentModel) -> bool:
        """Whether an agent may get plans that are not in its source."""
        return ".add_plan" in agent.actions or any(
            message.force == "tellHow" and self._reaches(message, sender, agent)
            for sender in self.agents
            for message in sender.sent
        )

    def _reaches(self, message: SentMessage, sender: AgentModel, agent: AgentModel) -> bool:
        if message.receivers is None:
            return not (message.broadcast and sender is agent)
        return agent.name in message.receivers or (SELF in message.receivers and sender is agent)


def _beliefs_told(message: SentMessage, source: str | None) -> list[Addition]:
    content = message.content
    items = getattr(content, "items", (content,))
    certain_receiver = message.receivers is not None or message.broadcast
    return [
        Addition(
            item.key if isinstance(item, Structure) else None,
            source,
            message.location,
            certain_receiver=certain_receiver,
        )
        for item in items
        if isinstance(item, Structure) or not hasattr(item, "value")
    ]


def sources_in(literal: Structure) -> frozenset[str | None]:
    """The sources in a literal's annotations; None for a variable."""
    named: set[str | None] = set()
    for annot in literal.annots:
        if isinstance(annot, Structure) and annot.functor == "source" and len(annot.args) == 1:
            source = annot.args[0]
            named.add(source.functor if isinstance(source, Structure) else None)
            if not isinstance(source, (Structure, Variable)):
                named.discard(None)
    return frozenset(named)


def predicate_text(key: Key) -> str:
    """A predicate as text: ``~p/2``."""
    negated, functor, arity = key
    return f"{'~' if negated else ''}{functor}/{arity}"


Problem = tuple[Location, str]
"""The location and the message of a mistake."""
Find = Callable[[System], Iterator[Problem]]


@dataclass(frozen=True, slots=True)
class Check:
    """Searches models for one type of mistake.

    Args:
        name: shown with its findings; remarks ignore them by it.
        why: the consequence of such a mistake, in one sentence.
        find: gives the mistakes in a system.
    """

    name: str
    why: str
    find: Find


CHECKS: list[Check] = []
"""All checks; a module of checks adds its own."""


def check(name: str, why: str) -> Callable[[Find], Find]:
    """Make a function a check; for the arguments see `Check`."""

    def register(find: Find) -> Find:
        CHECKS.append(Check(name, why, find))
        return find

    return register
