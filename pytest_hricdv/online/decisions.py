"""The decisions of a run with interactive agents: each is made by a chooser and recorded.

A run decides which goal an agent gets, which ready act it performs, and which disturbance comes next.
"""

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
