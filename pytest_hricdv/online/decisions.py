"""What is decided in a run in which agents live: asked of a chooser, with where the run stands, and noted."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.coupling.coupled_run import CoupledRun
from pytest_hricdv.coupling.ready_acts import ReadyAct, ReadyActs
from pytest_hricdv.generate.beliefs import START
from pytest_hricdv.monitor import Value
from pytest_hricdv.online.chooser import ACT, DISTURBANCE, GOAL, NONE, Choice, ChoicePoint, Chooser, Situation
from pytest_hricdv.online.declaration import InteractiveAgentError
from pytest_hricdv.online.role import Role

MOST_GOALS = 8
"""So many goals can be given to agents in a run. Each leads to commands, between which there can be the next one: a
run would have no end."""


class Decisions:
    """The decisions of one run.

    Args:
        role: of an agent in it; what it says of the run is the same for all.
        chooser: decides.
    """

    def __init__(self, role: Role, chooser: Chooser) -> None:
        self._role = role
        self._chooser = chooser
        self._state_topic, _, self._state_field = role.state.partition(".")
        self._state = ""
        self._goals_left = MOST_GOALS
        self.taken: list[str] = []
        """The commands so far."""
        self.choices: list[Choice] = []
        """What was chosen, in order; that nothing was, only of beliefs."""

    def message(self, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived: it may name the state of the code under test."""
        if topic == self._state_topic:
            self._state = str(fields[self._state_field])

    def choose(self, about: str, options: tuple[str, ...], now_s: float) -> str:
        """One of the options. Raises InteractiveAgentError: the chooser chose something else."""
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
        """The line of a disturbance, if one is chosen; at most one between two commands."""
        lines = self._role.disturbances
        if not lines or (self.taken and self.taken[-1] in lines):
            return NONE
        chosen = self.choose(DISTURBANCE, (NONE, *lines), now_s)
        self.taken += [chosen] if chosen else []
        return chosen

    def goal(self, goals: tuple[str, ...], now_s: float) -> str:
        """One of these goals to give to an agent, if one is chosen."""
        if self._goals_left <= 0:
            return NONE
        goal = self.choose(GOAL, (NONE, *goals), now_s)
        self._goals_left -= goal != NONE
        return goal

    def act(self, ready: ReadyActs, now_s: float) -> ReadyAct:
        """One of the acts that an agent is ready for; of equal ones the first."""
        acts: dict[str, ReadyAct] = {}
        for act in ready:
            acts.setdefault(act.text, act)
        options = tuple(acts)
        return acts[options[0] if len(options) == 1 else self.choose(ACT, options, now_s)]

    def begin(self, run: CoupledRun, steering: Agent) -> None:
        """Let the steering agent begin, with one start belief chosen."""
        model = self._role.model
        chosen = self.choose(START, self._role.space.start, run.now_s)
        run.environment.show(model.steering_agent, [f"{model.chosen}({chosen})"])
        steering.awake = True

    def _situation(self, now_s: float) -> Situation:
        commands = [line for line in self.taken if line not in self._role.disturbances]
        interaction = max((len([*planned(commands)]) for planned in self._role.planned), default=0)
        return Situation(now_s, self._state, interaction, tuple(self.taken))
