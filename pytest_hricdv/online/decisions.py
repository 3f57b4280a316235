"""`Decisions` of a run with interactive agents: each is made by a `Chooser` and recorded.

A run decides which goal an agent gets, which ready act it performs, which disturbance comes next, and which belief
of a group holds when an agent first queries one of them (`LateBeliefs`). `OnlineAgent` and `OnlinePeople` ask for them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from random import Random
from typing import NamedTuple, Protocol

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.language.terms import Key, Structure, source
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, TrackedBuckets
from pytest_hricdv.coupling.coupled_agent import CoupledRun, ReadyAct, ReadyActs
from pytest_hricdv.generate.beliefs import START, BeliefSpace
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.monitor import Value
from pytest_hricdv.online.declaration import InteractiveAgentError
from pytest_hricdv.online.role import Role

GOAL = "goal"  # what a decision is about; besides, the name of a group of beliefs
DISTURBANCE = "disturbance"
ACT = "act"
NONE = ""
"""The option to choose no belief of a group, no goal, or no disturbance."""

RARE_WEIGHT = 0.01
"""Weight of a goal or disturbance that experience gives no weight; the option NONE has weight 1. With the 27
disturbances of the case study, an agent without experience disturbs at one decision in five."""


@dataclass(frozen=True)
class Situation:
    """The state of a run at a decision.

    Args:
        time_s: simulated time.
        state: the state that the code under test has reported last; empty if there is none.
        interaction: its number, from 1; 0 before the first one, and if interactions cannot be distinguished.
        taken: the commands so far, disturbances among them.
    """

    time_s: float
    state: str
    interaction: int
    taken: tuple[str, ...]


@dataclass(frozen=True)
class ChoicePoint:
    """Something to decide.

    Args:
        about: "start", the name of a group of beliefs, "goal", "disturbance", or "act".
        options: at least one; NONE where it may be left.
        situation: where the run stands.
    """

    about: str
    options: tuple[str, ...]
    situation: Situation


class Choice(NamedTuple):
    """A choice: after how many commands, in which state of code and interaction, about which subject, and its value."""

    taken: int
    state: str
    interaction: int
    about: str
    option: str


class Chooser(Protocol):
    """Decides what the model leaves open."""

    def choose(self, decision: ChoicePoint) -> str:
        """Choose one of the options."""


ANY_INTERACTION = -1
ANY_STATE = ""

Weight = tuple[str, int, str, str, float]
"""State of the code, interaction, what is decided, option, and how much likelier it is than an option of weight 1."""


class WeightedChooser:
    """Chooses at random by weights.

    Options that have none have weight 1; goals and disturbances have RARE_WEIGHT, and of several acts the agent does
    the one that it was ready for first.

    Args:
        seed: the seed of its random stream.
        weights: the weights of options; those for state and interaction come before those for the interaction, and
            these before those for any.
    """

    def __init__(self, seed: int, weights: Iterable[Weight] = ()) -> None:
        self._rng: Random = make_rng("online", seed)
        self._weights = {tuple(key): weight for *key, weight in weights}

    def choose(self, decision: ChoicePoint) -> str:
        """See `Chooser`."""
        weights = [self._weight(decision, option) for option in decision.options]
        left = self._rng.random() * sum(weights)
        for option, weight in zip(decision.options, weights, strict=True):
            left -= weight
            if left < 0:
                return option
        return decision.options[0]  # all weights are 0, or rounding left a little over

    def _weight(self, decision: ChoicePoint, option: str) -> float:
        situation = decision.situation
        number = situation.interaction
        for place in ((situation.state, number), (ANY_STATE, number), (ANY_STATE, ANY_INTERACTION)):
            if (weight := self._weights.get((*place, decision.about, option))) is not None:
                return weight
        if decision.about == ACT:
            return float(option == decision.options[0])
        return RARE_WEIGHT if decision.about in (GOAL, DISTURBANCE) and option != NONE else 1.0


MAX_GOALS = 8
"""Goals given to agents in one run. Without a limit, a run would not end: the commands of each goal leave room for the
next one."""


class Decisions:
    """The decisions of one run.

    Args:
        role: the role of any agent in the run; only what it has in common with the others is used.
        chooser: makes the decisions.
    """

    def __init__(self, role: Role, chooser: Chooser) -> None:
        self._role = role
        self._chooser = chooser
        self._state_topic, _, self._state_field = role.state.partition(".")
        self._state = ""
        self._goals_left = MAX_GOALS
        self.taken: list[str] = []
        """The commands so far, including disturbances."""
        self.choices: list[Choice] = []
        """The choices in order, without decisions against a goal or a disturbance."""

    def message(self, topic: str, fields: Mapping[str, Value]) -> None:
        """Take the state of the code under test from a message, if it names one."""
        if topic == self._state_topic:
            self._state = str(fields[self._state_field])

    def choose(self, about: str, options: tuple[str, ...], now_s: float) -> str:
        """Let the chooser choose one of the options. Raises InteractiveAgentError if it chooses anything else."""
        situation = self._situation(now_s)
        chosen = self._chooser.choose(ChoicePoint(about, options, situation))
        if chosen not in options:
            alternatives = ", ".join(map(repr, options))
            raise InteractiveAgentError(
                f"InteractiveAgent: {chosen!r} was chosen for {about}; expected one of {alternatives}"
            )
        if chosen != NONE or about not in (GOAL, DISTURBANCE):
            self.choices.append(Choice(len(self.taken), situation.state, situation.interaction, about, chosen))
        return chosen

    def disturbance(self, now_s: float) -> str:
        """Choose a disturbance or none, at most one between two commands. Returns its line."""
        lines = self._role.disturbances
        if not lines or (self.taken and self.taken[-1] in lines):
            return NONE
        chosen = self.choose(DISTURBANCE, (NONE, *lines), now_s)
        self.taken += [chosen] if chosen else []
        return chosen

    def goal(self, goals: tuple[str, ...], now_s: float) -> str:
        """Choose a goal to give to an agent, or none."""
        if self._goals_left <= 0:
            return NONE
        goal = self.choose(GOAL, (NONE, *goals), now_s)
        self._goals_left -= goal != NONE
        return goal

    def act(self, ready: ReadyActs, now_s: float) -> ReadyAct:
        """Choose an act that an agent is ready for; equal acts are one option, the first of them."""
        acts: dict[str, ReadyAct] = {}
        for act in ready:
            acts.setdefault(act.text, act)
        options = tuple(acts)
        return acts[options[0] if len(options) == 1 else self.choose(ACT, options, now_s)]

    def begin(self, run: CoupledRun, steering: Agent) -> None:
        """Choose a start belief, and start the steering agent with it."""
        model = self._role.model
        chosen = self.choose(START, self._role.space.start, run.now_s)
        run.environment.show(model.steering_agent, [f"{model.chosen}({chosen})"])
        steering.awake = True

    def _situation(self, now_s: float) -> Situation:
        commands = [line for line in self.taken if line not in self._role.disturbances]
        interaction = max((len([*planned(commands)]) for planned in self._role.planned), default=0)
        return Situation(now_s, self._state, interaction, tuple(self.taken))


Choose = Callable[[str, tuple[str, ...]], str]
"""Chooses one of the options for a group."""


class LateBeliefs:
    """The groups of a space that are open, in one run.

    A group is open as long as the agent believes none of it but a default belief; it is decided when the agent looks
    one of its beliefs up, at most once until `reopen`. In a group without a default belief, none may be chosen.

    Args:
        space: the groups.
        steering: the name of the agent that gives the beliefs.
        choose: decides.
        believe: the agent believes a literal from now on.
        disbelieve: the agent does not believe a literal any more.
    """

    def __init__(
        self,
        space: BeliefSpace,
        steering: str,
        choose: Choose,
        believe: Callable[[Structure], None],
        disbelieve: Callable[[Structure], None],
    ) -> None:
        self._space = space
        self._source = source(steering)
        self._choose, self._believe, self._disbelieve = choose, believe, disbelieve
        self._group_of: dict[Key, str] = {
            _atom(belief).key: name for name, group in space.groups.items() for belief in group
        }
        self._decided: set[str] = set()
        self._buckets: list[TrackedBuckets] = []

    def track(self, beliefs: BeliefBase) -> None:
        """Notice lookups in the belief base of an agent; of several, whoever looks first decides for all."""
        beliefs.buckets = buckets = TrackedBuckets(beliefs.buckets, self._look_up)
        self._buckets.append(buckets)

    def reopen(self) -> None:
        """Groups may be decided again."""
        self._decided.clear()

    def _look_up(self, key: Key) -> None:
        group = self._group_of.get(key)
        if group is None or group in self._decided:
            return
        self._decided.add(group)  # before it is decided: to believe something looks the group up again
        members = self._space.groups[group]
        default_beliefs = [belief for belief in members if belief in self._space.default_beliefs]
        if any(self._is_held(belief) for belief in members if belief not in default_beliefs):
            return
        chosen = self._choose(group, members if default_beliefs else (NONE, *members))
        if chosen == NONE or self._is_held(chosen):
            return
        for belief in default_beliefs:
            if self._is_held(belief):
                self._disbelieve(self._belief(belief))
        self._believe(self._belief(chosen))

    def _is_held(self, belief: str) -> bool:
        key = _atom(belief).key
        return any(buckets.peek(key) for buckets in self._buckets)

    def _belief(self, belief: str) -> Structure:
        return Structure(belief, (), (self._source,))


def _atom(belief: str) -> Structure:
    return Structure(belief)
