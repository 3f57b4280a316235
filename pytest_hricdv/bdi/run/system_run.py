"""`SystemRun`: one run of a multi-agent system, with its rounds and virtual time, until it ends.

`MultiAgentSystem.run` makes one for each run. In a round every agent does one reasoning cycle, in the order of the
project file, so that a run is a function of the models, the percepts and the seed. A round takes one tick of virtual
time; when no agent has anything to do before some wait is over, time jumps there.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Iterable

from pytest_hricdv.bdi.agent.agent import Agent, count_waiting, limit_text
from pytest_hricdv.bdi.agent.directory import Directory
from pytest_hricdv.bdi.agent.intentions import TICKS_PER_MS, PerceptSource, SpeechAct, ticks_of
from pytest_hricdv.bdi.language.errors import BdiError, EvaluationError, Location
from pytest_hricdv.bdi.language.limits import (
    CHARACTERS,
    MAX_HELD,
    MAX_WORK,
    ROUNDS_BETWEEN_COUNTS,
    WORK,
    WORK_PER_CYCLE,
    LimitError,
    count_work,
    spend,
    too_much_work,
)
from pytest_hricdv.bdi.language.project import MAX_AGENTS
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan
from pytest_hricdv.bdi.language.terms import Structure, Variable
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.run.environment import Environment
from pytest_hricdv.bdi.run.livelock import LivelockDetector, name_endless_plans

FRESH_OF_MESSAGES = 16
"""Variables that Jason 1.4.2 numbers for each agent's plans for messages; the run's own variables come after them."""


class SystemRun:
    """A run of a system: its agents, clock, messages and output.

    Args:
        environment: what the agents perceive and act on.
        seed: the seed of the run's one stream of random numbers.
    """

    def __init__(self, environment: Environment, seed: int) -> None:
        self.environment = environment
        self.agents: dict[str, Agent] = {}
        """The agents by name, in the order in which they act."""
        self.killed: dict[str, Agent] = {}
        """Agents that took part, by name."""
        self.new_agent: Callable[[SystemRun, str, str, Location], Agent] | None = None
        """Makes an agent of a name, a source and the place that asks for it."""
        self.prints: list[str] = []
        self.actions: list[tuple[str, str]] = []
        self.warnings: list[str] = []
        self.endless: list[str] = []
        """The plans that had not ended when the run was ended, see `name_endless_plans`."""
        self.rounds = 0
        self.skipped = 0
        """The ticks of the virtual clock in which no agent had anything to do."""
        self.progress = 0
        """Grows with everything an agent does that another, or the user, could notice, or that it could remember."""
        self.directory = Directory()
        """The directory of services."""
        self.messages = 0
        """The number of messages sent so far."""
        self.work_left = MAX_WORK
        """The work left, besides one statement per cycle; see `pytest_hricdv.bdi.language.limits`."""
        self._seed = seed
        self._random: random.Random | None = None
        self._first_fresh = self._fresh = 0
        self.order: Iterable[Agent] = ()
        """The agents in the order in which they act in the next round."""
        self.earliest_deadline = math.inf
        """No wait is over before this tick."""
        self.ended = ""
        """How the run ends after this round, if it does."""
        self.busy_waiting = False
        """Whether an agent has waited busily in the last round."""
        self._seen_changes = environment.changes

    # --- what agents use

    @property
    def ticks(self) -> int:
        """The virtual clock."""
        return self.rounds + self.skipped

    @property
    def time_ms(self) -> float:
        """Virtual time."""
        return self.ticks / TICKS_PER_MS

    def deadline(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over."""
        return self.ticks + ticks_of(wait_ms)

    def percepts_of(self, agent: str) -> PerceptSource:
        """The percepts of an agent, now and later."""
        return self.environment.percepts_of(agent)

    def print(self, agent: str, text: str) -> None:
        """Record what an agent prints."""
        spend(len(text) // CHARACTERS)
        self.prints.append(f"[{agent}] {text}")
        self.progress += 1

    def warn(self, text: str) -> None:
        """Record what the author of the models should know."""
        spend(len(text) // CHARACTERS)
        self.warnings.append(text)
        self.progress += 1

    def draw(self) -> float:
        """The next random number, from 0 inclusive to 1 exclusive."""
        if self._random is None:  # only for models that draw: learning makes thousands of runs of others
            self._random = random.Random(self._seed)
        self.progress += 1
        return self._random.random()

    def note_variables(self, last_number: int) -> None:
        """Reserve the first numbers for an agent's source; numbers made in the run come after them, as in Jason."""
        self._fresh += FRESH_OF_MESSAGES + last_number
        self._first_fresh = self._fresh

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        self._fresh += 1
        return Variable(f"_{self._fresh}")

    def is_fresh(self, variable: Variable) -> bool:
        """Whether :meth:`fresh` made the variable."""
        return variable[:1] == "_" and variable[1:].isdigit() and int(variable[1:]) > self._first_fresh

    def deliver(self, receiver: str, message: SpeechAct) -> None:
        """Put a message into its receiver's mailbox."""
        spend(1)
        agent = self.agents.get(receiver)
        if agent is None:  # killed while the message was under way
            return
        agent.mailbox.append(message)
        agent.awake = True
        self.progress += 1

    def create_agent(self, name: str, source: str, place: Location) -> None:
        """Let a new agent take part from the next round on, with what a source file says."""
        self._check_name(name, place)
        if self.new_agent is None:
            raise BdiError(f"{place}: agents cannot be created in this run")
        self.agents[name] = self.new_agent(self, name, source, place)
        self._note_agents_changed()

    def clone_agent(self, original: str, name: str, place: Location) -> None:
        """Let a new agent take part from the next round on, with what another one believes and its plans."""
        self._check_name(name, place)
        agent = self.agents[original]
        beliefs = BeliefBase(agent.beliefs.content())
        self.agents[name] = type(agent)(name, self, agent.actions, beliefs, agent.library, [])
        self._note_agents_changed()

    def _check_name(self, name: str, place: Location) -> None:
        if name in self.agents:
            raise EvaluationError(f"there is an agent {name} already", "internal_action")
        if len(self.agents) >= MAX_AGENTS:
            raise BdiError(f"{place}: more than {MAX_AGENTS:,} agents: {name} cannot be created")

    def kill_agent(self, name: str) -> bool:
        """Let an agent take part no longer; whether there was one of that name."""
        if name not in self.agents:
            return False
        killed = self.killed[name] = self.agents.pop(name)
        killed.awake = False  # it may come later in this round
        self.directory.remove(name)
        self._note_agents_changed()
        return True

    def _note_agents_changed(self) -> None:
        self.order = tuple(self.agents.values())
        self.progress += 1

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """Let the environment execute an action; whether it succeeded. Raises BdiError if the environment raises."""
        self.actions.append((agent, str(action)))
        self.progress += 1
        try:
            success = self.environment.execute(agent, action)
        except Exception as error:
            place = f"plan @{plan.label} ({statement.location})"
            problem = f"action {action} raised {type(error).__name__}: {error}"
            raise BdiError(f"agent {agent}, {place}: {problem}") from error
        # Within a run only actions change percepts: agents are woken here, and need not look in each round.
        if self.environment.changes != self._seen_changes:
            self._seen_changes = self.environment.changes
            for other in self.agents.values():
                other.awake = other.awake or other.has_work()
        return bool(success)

    def stop(self) -> None:
        """End the run after this round."""
        self.ended = "stopped"

    def note_deadline(self, deadline: float) -> None:
        """An intention has begun to wait until then."""
        if deadline < self.earliest_deadline:
            self.earliest_deadline = deadline

    # --- the rounds

    def go(self, max_rounds: int) -> str:
        """Do rounds until the run ends by itself or has had ``max_rounds``.

        Returns:
            How it ended: "idle", "spin", "stopped" or "round limit".

        Raises:
            BdiError: an agent cannot continue.
        """
        with count_work(self):
            try:
                ended = self._do_rounds(max_rounds)
            except LimitError as error:  # of the comparison of states; what agents do has a place
                most = max(self.agents.values(), key=count_waiting)
                waiting = f"the plans that wait for others, most of them of {most.name}, {most.activity()}"
                raise BdiError(f"{waiting}: comparing them {error}") from None
        if ended in ("idle", "spin"):
            for agent in self.agents.values():
                agent.warn_of_standstill()
        if ended in ("spin", "round limit"):
            self.endless = name_endless_plans(self.agents.values(), repeats=ended == "spin")
        return ended

    def _do_rounds(self, max_rounds: int) -> str:
        self.order = tuple(self.agents.values())
        livelock = LivelockDetector(self.agents)
        while self.rounds < max_rounds:
            # Between parts of the run things are counted: within them, even a comparison in each round would show.
            ended = self._do_part(livelock, min(max_rounds, self.rounds + ROUNDS_BETWEEN_COUNTS))
            if ended:
                return ended
            self._count_held()
        return "round limit"

    def _do_part(self, livelock: LivelockDetector, until: int) -> str:
        """Do rounds until the run ends by itself, as `go`, or has done this many: then empty."""
        while self.rounds < until:
            if not self.do_round():
                if not self._jump():
                    return "idle"
                if livelock.repeats_after_jump(self.ticks, self.progress):
                    return "spin"
                continue
            if self.ended:
                return self.ended
            if self.busy_waiting and self.only_busy_waiting():
                return "spin"
            rounds = self.rounds
            if rounds + self.skipped >= self.earliest_deadline:
                self._end_waits()
            if (
                rounds >= livelock.due
                and livelock.repeats(rounds, self.progress)
                and (not self._jump() or livelock.repeats_after_jump(self.ticks, self.progress))
            ):
                return "spin"
        return ""

    def do_round(self) -> bool:
        """Let every agent do a reasoning cycle that has anything to do; False if there is none."""
        acted = self.busy_waiting = False
        for agent in self.order:
            if agent.awake:
                acted = True
                try:
                    agent.cycle()
                except (RecursionError, MemoryError, LimitError) as error:
                    raise BdiError(f"{agent.name}: {limit_text(error, agent)}") from None
        if acted:
            self.rounds += 1
        return acted

    def _count_held(self) -> None:
        """See that beliefs, plans and what waits do not grow without end. Raises BdiError: they do."""
        if WORK.left < 0:
            raise too_much_work()
        agents = self.agents.values()
        WORK.left += WORK_PER_CYCLE * ROUNDS_BETWEEN_COUNTS * len(agents)
        for kind, count in (
            ("beliefs", lambda agent: sum(map(len, agent.beliefs.buckets.values()))),
            ("plans", lambda agent: len(agent.library.plans)),
            ("messages, events and intentions", count_waiting),
        ):
            held = {agent.name: count(agent) for agent in agents}
            if sum(held.values()) > MAX_HELD:
                most = max(agents, key=lambda agent: held[agent.name])
                problem = f"agents have more than {MAX_HELD:,} {kind}, most of them {most.name}: {most.activity()}"
                raise BdiError(f"after {self.rounds} rounds, {problem}")

    def only_busy_waiting(self) -> bool:
        """Whether no agent can do anything that ends busy waiting, after a round with it."""
        return not any(agent.may_change() for agent in self.agents.values())

    def close(self) -> None:
        """Release the agents after the run: they refer to it, too, and would wait for the garbage collector."""
        self.agents, self.order = {}, ()

    # --- waiting

    def _jump(self) -> bool:
        """Advance the clock to the next moment at which a wait is over; False if there is none."""
        # An awaited event may have come before the deadline.
        self._find_earliest_deadline()
        if self.earliest_deadline == math.inf:
            return False
        self.skipped = max(self.skipped, int(self.earliest_deadline) - self.rounds)
        self._end_waits()
        return True

    def _end_waits(self) -> None:
        now = self.ticks
        for agent in self.agents.values():
            if agent.waits or agent.questions or agent.deadlines:
                agent.end_waits(now)
                agent.awake = agent.awake or agent.has_work()
        self._find_earliest_deadline()

    def _find_earliest_deadline(self) -> None:
        deadlines: list[float | None] = []
        for agent in self.agents.values():
            if agent.waits or agent.questions or agent.deadlines:
                deadlines += [wait.deadline for wait in agent.waits]
                deadlines += [question.deadline for question in agent.questions.values()]
                deadlines += [open_one.deadline for open_one in agent.open_deadlines()]
        self.earliest_deadline = min((deadline for deadline in deadlines if deadline is not None), default=math.inf)
