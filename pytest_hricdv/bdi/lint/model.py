"""A multi-agent system as the checks see it: what each agent believes, tests, wants and is told."""

from __future__ import annotations

from dataclasses import dataclass, field

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax import Plan, Rule
from pytest_hricdv.bdi.language.terms import Key, Structure, Term, Variable

SELF = "self"
PERCEPT = "percept"


@dataclass(frozen=True, slots=True)
class Mention:
    """A literal at a place: a belief tested or deleted, or a goal."""

    literal: Structure
    location: Location
    plan: Plan | None = None


@dataclass(frozen=True, slots=True)
class Addition:
    """A belief that an agent comes to hold.

    Args:
        key: its predicate; None for any, when a variable stands for the belief.
        source: who it comes from; None for anybody.
        location: where it is added, told or declared.
        later: whether it comes in the course of a run, not with the agent.
        surely: whether it is meant for this agent, not for one that a variable stands for.
    """

    key: Key | None
    source: str | None
    location: Location
    later: bool = True
    surely: bool = True

    def may_be(self, key: Key, source: str | None = None) -> bool:
        """Whether it may be a belief of that predicate, from that source."""
        return self.key in (None, key) and (source is None or self.source in (None, source))


@dataclass(frozen=True, slots=True)
class Sent:
    """A message that an agent sends.

    Args:
        force: its illocutionary force, or empty if a variable stands for it.
        receivers: who gets it; None if a variable stands for them, or for a broadcast.
        content: what it says.
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
        """The goals that it wants its receivers to achieve."""
        items = getattr(self.content, "items", (self.content,)) if self.force == "achieve" else ()
        return [Mention(item, self.location) for item in items if isinstance(item, Structure)]


@dataclass(slots=True)
class AgentModel:
    """What is written in one agent's source."""

    name: str
    file: str
    plans: tuple[Plan, ...] = ()
    rules: tuple[Rule, ...] = ()
    additions: list[Addition] = field(default_factory=list)
    tests: list[Mention] = field(default_factory=list)
    deletions: list[Mention] = field(default_factory=list)
    goals: list[Mention] = field(default_factory=list)
    sent: list[Sent] = field(default_factory=list)
    actions: set[str] = field(default_factory=set)
    """The internal actions it uses."""


@dataclass(frozen=True, slots=True)
class System:
    """Agents that run together.

    Args:
        agents: the agents, one for each name.
        closed: whether there are no others, as in a project; a source on its own may be told anything by others.
        percepts: the names of what is perceived, as far as declared, each with the file that declares it or None.
    """

    agents: tuple[AgentModel, ...]
    closed: bool
    percepts: frozenset[tuple[str, str | None]]

    def comes_to_hold(self, agent: AgentModel) -> list[Addition]:
        """All beliefs that an agent may come to hold: its own, told by others, and perceived as its plans say."""
        found = list(agent.additions)
        for sender in self.agents:
            for message in sender.sent:
                if message.force in ("tell", "signal") and self._reaches(message, sender, agent):
                    found += _told(message, SELF if sender is agent else sender.name)
                elif message.force in ("askOne", "askAll") and sender is agent and not message.answered:
                    found += _told(message, None)
        found += self._from_outside(agent)
        return found

    def _from_outside(self, agent: AgentModel) -> list[Addition]:
        found = []
        mentions = [*agent.tests, *agent.deletions]
        declared = {name for name, file in self.percepts if file in (None, agent.file)}
        for mention in mentions:
            literal, sources = mention.literal, sources_named(mention.literal)
            if literal.functor in declared or PERCEPT in sources:
                found.append(Addition(literal.key, PERCEPT, mention.location))
            if not self.closed:
                found += [Addition(literal.key, source, mention.location) for source in sources - {SELF, PERCEPT}]
        return found

    def told_goals(self, agent: AgentModel) -> list[Mention]:
        """The goals that others, or itself by message, certainly want an agent to achieve."""
        return [
            goal
            for sender in self.agents
            for message in sender.sent
            if (message.receivers is not None or message.broadcast) and self._reaches(message, sender, agent)
            for goal in message.goals
        ]

    def goals_for_somebody(self) -> list[Mention]:
        """The goals in messages whose receiver is a variable."""
        messages = [message for sender in self.agents for message in sender.sent]
        return [goal for m in messages if m.receivers is None and not m.broadcast for goal in m.goals]

    def learns_plans(self, agent: AgentModel) -> bool:
        """Whether an agent may get plans that are not in its source."""
        return ".add_plan" in agent.actions or any(
            message.force == "tellHow" and self._reaches(message, sender, agent)
            for sender in self.agents
            for message in sender.sent
        )

    def _reaches(self, message: Sent, sender: AgentModel, agent: AgentModel) -> bool:
        if message.receivers is None:
            return not (message.broadcast and sender is agent)
        return agent.name in message.receivers or (SELF in message.receivers and sender is agent)


def _told(message: Sent, source: str | None) -> list[Addition]:
    content = message.content
    items = getattr(content, "items", (content,))
    surely = message.receivers is not None or message.broadcast
    return [
        Addition(item.key if isinstance(item, Structure) else None, source, message.location, surely=surely)
        for item in items
        if isinstance(item, Structure) or not hasattr(item, "value")
    ]


def sources_named(literal: Structure) -> frozenset[str | None]:
    """The sources that a literal's annotations ask for; None for a variable."""
    named: set[str | None] = set()
    for annot in literal.annots:
        if isinstance(annot, Structure) and annot.functor == "source" and len(annot.args) == 1:
            source = annot.args[0]
            named.add(source.functor if isinstance(source, Structure) else None)
            if not isinstance(source, (Structure, Variable)):
                named.discard(None)
    return frozenset(named)


def name_of(key: Key) -> str:
    """A predicate as text: ``~p/2``."""
    negated, functor, arity = key
    return f"{'~' if negated else ''}{functor}/{arity}"
