"""`OnlineAgent` decides during a run what a person does: it perceives events and yields one command at a time.

The closing loop uses it (`online_strategy`). `OnlineActions` makes the actions of a run from its commands;
`online_people` is for several people in one run.
"""

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
    """An event for the agent: its time (s), the literal, the literal's source, and whether it is a goal."""

    time_s: float
    literal: Structure
    source: str
    is_goal: bool


class EventInbox:
    """Collects the events for one agent until it listens."""

    def __init__(self, role: Role) -> None:
        self._role = role
        self._events = Events(
            [event.condition for event in role.percepts],
            [name for event in role.percepts for name in event.sources.values()],
        )
        self._heard: deque[HeardEvent] = deque()
        self._error: CouplingError | None = None
        """Raised when the agent listens. Raised earlier, it would look like an error of the node that is running."""

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        if topic in self._events.topics:
            self._collect(self._events.message(time_s, topic, fields))

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        if name in self._events.signals:
            self._collect(self._events.signal(time_s, name, value))

    @property
    def has_events(self) -> bool:
        """Whether there may be events."""
        return bool(self._heard or self._error) or self._events.has_changes

    def listen(self) -> Iterable[HeardEvent]:
        """All events since the agent listened last, in order.

        Raises:
            CouplingError: a part of an event has no value yet.
        """
        # The changes of an instant are judged when the next instant begins, which may never come.
        self._collect(self._events.flush())
        if self._error is not None:
            raise self._error
        heard, self._heard = self._heard, deque()
        return heard

    def _collect(self, occurrences: Iterable[EventOccurrence]) -> None:
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
"""An agent that has waited this often without an action is polling: it has nothing to do."""


class ActingAgent(CoupledAgent):
    """An agent that stops before each external action; its arguments are those of `Agent`."""

    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """No acts, as external actions are not declared; None for a message."""
        return () if self.is_external(intention) else None


class OnlineAgent:
    """The agent of one run; it receives messages and signals of the run, as monitors do.

    Args:
        chooser: decides what the model leaves open.
    """

    def __init__(self, role: Role, chooser: Chooser) -> None:
        self._role = role
        self._run = CoupledRun()
        self._inbox = EventInbox(role)
        self._decisions = Decisions(role, chooser)
        self._has_begun = False
        self._pending_act: ReadyAct | None = None
        self.events_heard = 0
        """Number of events that the agent has perceived."""
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
        self._inbox.message(time_s, topic, fields)

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        self._inbox.signal(time_s, name, value)

    # --- what the person does

    def next_command(self, time_s: float, waited: bool = False) -> str | None:
        """The next command of a person whose last command has ended; None if there is none yet.

        First, the agent perceives all events up to now.

        Args:
            time_s: now (s).
            waited: whether the person has waited because there was no command. If so, the agent reacts to events only,
                so that the same commands without the wait give the same run.

        Raises:
            InteractiveAgentError: the agent cannot continue, has an action that is not a command, or perceives an event
                with a part that has no value yet.
        """
        try:
            self._resume(time_s)
            if not waited:
                if disturbance := self._decisions.disturbance(self._run.now_s):
                    return disturbance
                self._post_goal()
            return self._take()
        except (BdiError, CouplingError, GenerateError) as error:
            raise self._on_failure(error, time_s) from error

    def let_time_pass(self) -> str | None:
        """The next command, after waits of the agent, if nothing else will happen in the run; None if there is none.

        The agent's clock is then ahead of the run's, in which its waits take no time.

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

    def _resume(self, time_s: float) -> None:
        """Continue the agent after its command, and let it perceive all events up to now."""
        if not self._has_begun:
            self._has_begun = True
            self._decisions.begin(self._run, self._steering)
            self._run.settle()
            self._run.advance_to(time_s)
        elif self._pending_act is not None:
            done, self._pending_act = self._pending_act, None
            self._late.reopen()
            self._agent.go_on_after(done)
            self._run.settle()
        heard = self._inbox.listen()
        for happened_s, literal, source, goal in heard:
            # Waits of the agent end between events, at their own times: a timeout may precede the answer.
            self.events_heard += 1
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
        self._pending_act = self._decisions.act(ready, self._run.now_s)
        command = command_from_action(self._pending_act.text)
        self._decisions.taken.append(command)
        return command

    def _choose(self, about: str, options: tuple[str, ...]) -> str:
        return self._decisions.choose(about, options, self._run.now_s)

    @property
    def plans(self) -> tuple[str, ...]:
        """The labels of the plans that it has executed, sorted and unique."""
        return self._role.plans_executed(self._agent)


class OnlineActions:
    """Produces the actions of one run (see `pytest_hricdv.run.Actions`), with drawn parameters.

    Args:
        agent: the agent of this run, whose messages and signals it has to receive.
        commands: the commands, with the ranges of their parameters.
    """

    def __init__(self, agent: OnlineAgent, commands: Concretization) -> None:
        self._agent = agent
        self._commands = commands

    def __call__(self, run: Run, actor: str = "", /) -> Iterator[ConcreteAction]:
        """The actions, until the agent has no further action and no event to wait for.

        Raises:
            InteractiveAgentError: the agent cannot continue.
            GenerateError: an action of the agent is not a command.
        """
        for place in count():
            command = self._next(run)
            if command is None:
                return
            yield draw_action(command, self._commands, run.test.seed, place)

    def _next(self, run: Run) -> str | None:
        command = self._agent.next_command(run.kernel.now_s)
        while command is None and run.waiting is not None:
            heard = self._agent.events_heard
            run.waiting()
            command = self._agent.next_command(run.kernel.now_s, waited=True)
            if self._agent.events_heard == heard:
                break
        return self._agent.let_time_pass() if command is None else command
