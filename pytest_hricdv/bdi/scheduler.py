"""One run of a multi-agent system: rounds, virtual time, and how a run ends.

In a round every agent does one reasoning cycle, in the order of the project file, so that a run is a
function of the models, the percepts and the seed. A round takes :data:`ROUND_MS` of virtual time; when
nobody has anything to do before some wait is over, time jumps there.
"""

from __future__ import annotations

import math
import random
from typing import TYPE_CHECKING

from .agent import Agent
from .environment import Environment
from .errors import BdiError
from .quiet import Quiet
from .terms import Structure, Variable
from .unify import unify
from .waiting import end_waits

if TYPE_CHECKING:
    pass

ROUND_MS = 0.1
"""Virtual time of a round: what Jason itself takes for one, within a factor of two."""
FIRST_FRESH = 100_000
"""Variables made in a run are numbered from here, those of the sources from 1."""


class Run:
    """The state of a run that its agents share.

    Args:
        environment: what they perceive and act on.
        seed: of the run's one stream of random numbers.
        goal: the agent and the goal with whose achievement the run ends, if any.
    """

    def __init__(self, environment: Environment, seed: int, goal: tuple[str, Structure] | None) -> None:
        self.environment = environment
        self.agents: dict[str, Agent] = {}
        self.prints: list[str] = []
        self.actions: list[tuple[str, str]] = []
        self.warnings: list[str] = []
        self.rounds = 0
        self.time_ms = 0.0
        self.earliest_deadline_ms = math.inf
        """No wait is over before this moment."""
        self.progress = 0
        """Grows with everything an agent does that another, or the user, could notice, or that it could remember."""
        self._seed = seed
        self._random: random.Random | None = None
        self._goal = goal
        self._ended = ""
        self._fresh = FIRST_FRESH
        self._messages = 0

    # --- what agents use

    def print(self, agent: str, text: str) -> None:
        """Note what an agent prints."""
        self.prints.append(f"[{agent}] {text}")
        self.progress += 1

    def warn(self, text: str) -> None:
        """Note what the author of the models should know."""
        self.warnings.append(text)
        self.progress += 1

    def draw(self) -> float:
        """The next random number, from 0 inclusive to 1 exclusive."""
        if self._random is None:
            self._random = random.Random(self._seed)
        self.progress += 1
        return self._random.random()

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        self._fresh += 1
        return Variable(f"_{self._fresh}")

    def is_fresh(self, variable: Variable) -> bool:
        """Whether :meth:`fresh` made the variable."""
        return variable[:1] == "_" and variable[1:].isdigit() and int(variable[1:]) > FIRST_FRESH

    def next_message_number(self) -> str:
        """A number for a message."""
        self._messages += 1
        return f"mid{self._messages}"

    def note_achieved(self, agent: str, goal: Structure) -> None:
        """A plan for a goal has come to its end."""
        if self._goal is not None and self._goal[0] == agent and unify(self._goal[1], goal, {}, []):
            self._ended = "goal"

    def stop(self) -> None:
        """End the run after this round."""
        self._ended = "stopped"

    # --- the rounds

    def go(self, max_rounds: int) -> str:
        """Do rounds until the run ends by itself or has had ``max_rounds``.

        Returns:
            How it ended: "idle", "spin", "goal", "stopped" or "round limit".

        Raises:
            BdiError: an agent cannot go on.
        """
        agents = tuple(self.agents.values())
        quiet = Quiet(self)
        while self.rounds < max_rounds:
            if not self._round(agents):
                if not self._jump():
                    return "idle"
                if quiet.polling():
                    return "spin"
                continue
            self.rounds += 1
            self.time_ms += ROUND_MS
            if self._ended:
                return self._ended
            if self.time_ms >= self.earliest_deadline_ms:
                self._end_waits()
            if quiet.spinning():
                if not self._jump():
                    return "spin"
                if quiet.polling():
                    return "spin"
        return "round limit"

    def _round(self, agents: tuple[Agent, ...]) -> bool:
        """One cycle of every agent that has anything to do; False if none has."""
        busy = False
        for agent in agents:
            if agent.has_work():
                busy = True
                try:
                    agent.cycle()
                except RecursionError:
                    raise BdiError(f"{agent.name}: terms nested too deeply, {agent.doing()}") from None
        return busy

    def note_deadline(self, deadline_ms: float) -> None:
        """An intention has begun to wait until then."""
        self.earliest_deadline_ms = min(self.earliest_deadline_ms, deadline_ms)

    def _jump(self) -> bool:
        """Go to the next moment at which a wait is over; False if there is none."""
        self._find_earliest_deadline()
        if self.earliest_deadline_ms == math.inf:
            return False
        self.time_ms = max(self.time_ms, self.earliest_deadline_ms)
        self._end_waits()
        return True

    def _end_waits(self) -> None:
        for agent in self.agents.values():
            if agent.waits or agent.questions:
                end_waits(agent, self.time_ms)
        self._find_earliest_deadline()

    def _find_earliest_deadline(self) -> None:
        self.earliest_deadline_ms = math.inf
        for agent in self.agents.values():
            for wait in agent.waits:
                self.note_deadline(math.inf if wait.deadline_ms is None else wait.deadline_ms)
            for question in agent.questions.values():
                self.note_deadline(math.inf if question.deadline_ms is None else question.deadline_ms)
