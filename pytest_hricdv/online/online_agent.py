"""The agent of a person in one run: it perceives events, and gives one command after the other."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from itertools import count
from typing import NamedTuple

from pytest_hricdv.bdi import BdiError, Structure
from pytest_hricdv.bdi.agent.intentions import Intention
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.coupling.coupled_agent import CoupledAgent, CoupledRun, ReadyAct
from pytest_hricdv.coupling.events import EventOccurrence, Events
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import command_from_action
from pytest_hricdv.generate.concrete import ConcreteAction, Concretization, draw_action
from pytest_hricdv.monitor import Value
from pytest_hricdv.online.decisions import NONE, Choice, Chooser, Decisions, LateBeliefs
from pytest_hricdv.online.declaration import InteractiveAgentError
from pytest_hricdv.online.role import Role
from pytest_hricdv.run import Run


class HeardEvent(NamedTuple):
    """Something that has happened: when (s), what the agent hears, who says so, and whether it is a goal."""

    time_s: float
    literal: Structure
    source: str
    is_goal: bool


class EventInbox:
    """Collects what one agent is to hear, up to when it listens.

    Args:
        role: of the agent.
    """

    def __init__(self, role: Role) -> None:
        self._role = role
        self._events = Events(
            [event.condition for event in role.percepts],
            [name for event in role.percepts for name in event.sources.values()],
        )
        self._heard: deque[HeardEvent] = deque()
        self._error: CouplingError | None = None
        """Raised when the agent listens, not when it occurs: then it would look like an error of the running node."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        if topic in self._events.topics:
            self._note(self._events.message(time_s, topic, fields))

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        if name in self._events.signals:
            self._note(self._events.signal(time_s, name, value))

    @property
    def has_news(self) -> bool:
        """Whether there may be something to listen to."""
        return bool(self._heard or self._error) or self._events.has_changes

    def listen(self) -> Iterable[HeardEvent]:
        """All events since the agent listened last, in order.

        Raises:
            CouplingError: a part of an event has no value yet.
        """
        # Signals change at instants that are judged when the next one begins: the last one would wait for ever.
        self._note(self._events.flush())
        if self._error is not None:
            raise self._error
        heard, self._heard = self._heard, deque()
        return heard

    def _note(self, occurrences: Iterable[EventOccurrence]) -> None:
        for occurrence in occurrences:
            for number in occurrence.numbers:
                event, declared = self._role.percepts[number], self._role.declaration.percepts[number]
                try:
                    literal = event.literal(event.bindings(self._events.values))
                except CouplingError as error:
                    self._error = self._error or error
                else:
                    self._heard.append(HeardEvent(occurrence.time_s, literal, declared.source, declared.is_goal))


MOST_WAITS = 1000
"""An agent that has waited so often without doing anything has nothing to do: it polls."""


class ActingAgent(CoupledAgent):
    """An agent that stops before each external action; takes what an agent takes."""

    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """No acts, as external actions are not declared; None for a message."""
        return () if self.is_external(intention) else None


class OnlineAgent:
    """The agent of one run; it listens to the run, as the monitors do.

    Args:
        role: what all runs share.
        chooser: decides what the model leaves open.
    """

    def __init__(self, role: Role, chooser: Chooser) -> None:
        self._role = role
        self._run = CoupledRun()
        self._hearing = EventInbox(role)
        self._decisions = Decisions(role, chooser)
        self._begun = False
        self._doing: ReadyAct | None = None
        self.heard = 0
        """How often it has heard something."""
        agent = role.agent.agent(self._run, ActingAgent)
        assert isinstance(agent, ActingAgent)
        agent.couple()
        self._agent, self._steering = agent, role.steering.agent(self._run)
        self._run.put([self._steering, agent], role.others)
        self._late = LateBeliefs(role.space, role.steering.name, self._choose, agent.believe, agent.disbelieve)
        self._late.track(agent.beliefs)

    @property
    def choices(self) -> list[Choice]:
        """The choices in order; an empty choice is listed only for beliefs."""
        return self._decisions.choices

    @property
    def commands(self) -> list[str]:
        """The commands so far."""
        return self._decisions.taken

    # --- what happens in the run

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        self._decisions.message(topic, fields)
        self._hearing.message(time_s, topic, fields)

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        self._hearing.signal(time_s, name, value)

    # --- what the person does

    def next_command(self, time_s: float, waited: bool = False) -> str | None:
        """The person is free at `time_s` (s): what to do next; None for nothing yet.

        The last command has been done; after that the agent perceives all that has happened by now.

        Args:
            time_s: now.
            waited: whether the person has waited because there was nothing to do: then the agent does only what
                follows from what it has heard meanwhile, so that the same commands without the waiting are the same
                run.

        Raises:
            InteractiveAgentError: the agent cannot continue, has an action that is no command, or hears what has no
                value yet.
        """
        try:
            self._go_on(time_s)
            if not waited:
                if disturbance := self._decisions.disturbance(self._run.now_s):
                    return disturbance
                self._post_goal()
            return self._take()
        except (BdiError, CouplingError, GenerateError) as error:
            raise self._on_failure(error, time_s) from error

    def let_time_pass(self) -> str | None:
        """The next command if nothing more will happen in the run, once the agent's next waits are over; None for none.

        The agent's clock is then ahead of the run's: its waits take no time there.

        Raises:
            InteractiveAgentError: as `next_command`.
        """
        run = self._run
        try:
            for _ in range(MOST_WAITS):
                if self._agent.ready_acts or run.due_s == math.inf:
                    break
                run.wait_until(max(run.due_s, run.now_s))
            return self._take()
        except (BdiError, GenerateError) as error:
            raise self._on_failure(error, run.now_s) from error

    def _on_failure(self, error: Exception, time_s: float) -> InteractiveAgentError:
        return InteractiveAgentError(f"InteractiveAgent: {self._agent.name} at {time_s:.3f} s: {error}")

    def _go_on(self, time_s: float) -> None:
        """The agent goes on after its command, and hears what has happened until now."""
        if not self._begun:
            self._begun = True
            self._decisions.begin(self._run, self._steering)
            self._run.settle()
            self._run.advance_to(time_s)
        elif self._doing is not None:
            done, self._doing = self._doing, None
            self._late.reopen()
            self._agent.go_on_after(done)
            self._run.settle()
        heard = self._hearing.listen()
        for happened_s, literal, source, goal in heard:
            # Its waits end at their times between what it hears: one may be over before the answer comes.
            self.heard += 1
            self._run.advance_to(happened_s)
            self._run.tell(self._agent, literal, source, goal)
        self._run.advance_to(time_s)

    def _post_goal(self) -> None:
        goal = self._decisions.goal(self._role.goals, self._run.now_s)
        if goal != NONE:
            self._run.tell(self._agent, parse_literal(goal), self._steering.name, goal=True)

    def _take(self) -> str | None:
        ready = self._agent.ready_acts
        if not ready:
            return None
        self._doing = self._decisions.act(ready, self._run.now_s)
        command = command_from_action(self._doing.text)
        self._decisions.taken.append(command)
        return command

    def _choose(self, about: str, options: tuple[str, ...]) -> str:
        return self._decisions.choose(about, options, self._run.now_s)

    @property
    def plans(self) -> tuple[str, ...]:
        """The labels of the plans that it has executed, sorted, each once."""
        return self._role.plans_executed(self._agent)


class OnlineActions:
    """Produces the actions of one run (see `pytest_hricdv.run.Actions`); their parameters are drawn.

    Args:
        agent: of this run; it has to listen to it.
        commands: with the ranges of their parameters.
    """

    def __init__(self, agent: OnlineAgent, commands: Concretization) -> None:
        self._agent = agent
        self._commands = commands

    def __call__(self, run: Run, actor: str = "", /) -> Iterator[ConcreteAction]:
        """The actions, up to when the agent has nothing to do and nothing more to expect.

        Raises:
            InteractiveAgentError: the agent cannot continue.
            GenerateError: it does what is no command.
        """
        for place in count():
            command = self._next(run)
            if command is None:
                return
            yield draw_action(command, self._commands, run.test.seed, place)

    def _next(self, run: Run) -> str | None:
        command = self._agent.next_command(run.kernel.now_s)
        while command is None and run.waiting is not None:
            heard = self._agent.heard
            run.waiting()
            command = self._agent.next_command(run.kernel.now_s, waited=True)
            if self._agent.heard == heard:
                break
        return self._agent.let_time_pass() if command is None else command
