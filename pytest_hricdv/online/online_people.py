"""`OnlinePeople`: several interactive people in one run; each has an agent, and they perceive each other.

The closing loop uses it (`online_strategy`). The agents' clock is simulated time. A free person does the next action
that its agent is ready for. If there is none, the person waits: for a message of another person, an event that its
agent perceives, or the end of a `.wait`. The test made from the run has no agents, so it stores these waits: an action
that waited for another person comes `after` that person's action; any other wait is a pause of fixed length.

A person who waited continues a little later than possible, each person at a different offset. So the order in which
persons notice events does not matter, and the test's run equals the original one bit for bit.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

from pytest_hricdv.bdi import BdiError, Structure
from pytest_hricdv.bdi.agent.agent import Agent
from pytest_hricdv.bdi.agent.intentions import PendingQuestion, PendingWait
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.run.system import AgentTemplate
from pytest_hricdv.bdi.run.tracing import StepRecorder, Trace, TracedAgent
from pytest_hricdv.coupling.coupled_agent import CoupledRun, ReadyAct
from pytest_hricdv.coupling.percept_mapping import CouplingError
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import command_from_action
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization, draw_action
from pytest_hricdv.monitor import Value
from pytest_hricdv.online.decisions import NONE, Choice, Chooser, Decisions, LateBeliefs
from pytest_hricdv.online.declaration import InteractiveAgentError
from pytest_hricdv.online.enacted_lanes import ActionStart, LaneRecord
from pytest_hricdv.online.online_agent import MOST_WAITS, ActingAgent, EventInbox
from pytest_hricdv.online.role import Role
from pytest_hricdv.run import Run
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import US_PER_S, Node


class _PeopleRun(StepRecorder, CoupledRun):
    """A traced run whose time is that of the run under test."""

    def tell(self, receiver: Agent, literal: Structure, source: str, goal: bool) -> None:
        """Record a message from outside, which no agent has caused."""
        step = self.record(source, "message", f"{'achieve' if goal else 'tell'} {literal} to {receiver.name}")
        self.sending_steps[self.messages + 1] = step.number
        super().tell(receiver, literal, source, goal)


class _PersonAgent(ActingAgent, TracedAgent):
    """A traced agent that stops before each external action."""


@dataclass(eq=False)
class _Person:
    """A person who decides: its index, its agent, and its state."""

    place: int
    role: Role
    agent: ActingAgent
    inbox: EventInbox
    is_asked: bool = False
    """Whether it has begun to live: its node has asked for its first action."""
    free_us: int = 0
    """Since when it is free."""
    activity: tuple[int, ReadyAct] | None = None
    """The number of the action that it does, from 1, and what it was ready for."""
    node: Node | None = None
    """Its node, while it waits."""
    waits: int = 0
    """How many waits of its agent have ended since its last action, after which there was nothing to do."""

    @property
    def name(self) -> str:
        return self.role.agent.name

    @property
    def due_ticks(self) -> float:
        """The end of its own wait, on the agents' clock; infinite without one."""
        waiting: list[PendingWait | PendingQuestion] = [*self.agent.waits, *self.agent.questions.values()]
        return min((wait.deadline for wait in waiting if wait.deadline is not None), default=math.inf)


class OnlinePeople:
    """Produces the actions of one run with several actors (see `pytest_hricdv.run.Actions`), and listens to it.

    Args:
        chooser: decides what the model leaves open.
        commands: the commands, with the ranges of their parameters.
    """

    def __init__(self, roles: Sequence[Role], chooser: Chooser, commands: Concretization) -> None:
        self._roles = roles
        self._commands = commands
        self._run = run = _PeopleRun()
        self._decisions = Decisions(roles[0], chooser)
        self._steering = _note(roles[0].steering, run, TracedAgent)
        self._people = {role.agent.name: self._person(place, role) for place, role in enumerate(roles)}
        agents = [person.agent for person in self._people.values()]
        names = {agent.name for agent in agents}
        run.put([self._steering, *agents], [name for name in roles[0].others if name not in names])
        space = roles[0].space
        self._late = LateBeliefs(space, self._steering.name, self._choose, self._believe, self._disbelieve)
        for agent in agents:
            self._late.track(agent.beliefs)
        self._begun = False
        self._kernel: Kernel | None = None
        self._record = LaneRecord()

    def _person(self, place: int, role: Role) -> _Person:
        agent = _note(role.agent, self._run, _PersonAgent)
        assert isinstance(agent, ActingAgent)
        agent.couple()
        return _Person(place, role, agent, EventInbox(role))

    @property
    def choices(self) -> list[Choice]:
        """The choices in order; an empty choice is listed only for beliefs."""
        return self._decisions.choices

    # --- what happens in the run

    def message(self, time_s: float, topic: str, fields: Mapping[str, Value]) -> None:
        """A message has arrived, as for a `MonitorSet`."""
        self._decisions.message(topic, fields)
        for person in self._people.values():
            person.inbox.message(time_s, topic, fields)
        self._wake()

    def signal(self, time_s: float, name: str, value: Value) -> None:
        """A signal has a new value, as for a `MonitorSet`."""
        for person in self._people.values():
            person.inbox.signal(time_s, name, value)
        self._wake()

    def _wake(self) -> None:
        """Let those continue waiting, or do something, who have something to listen to or are ready for something."""
        for person in self._people.values():
            if person.node is not None and (person.inbox.has_events or person.agent.ready_acts):
                node, person.node = person.node, None
                node.kernel.wake(node)

    def _wake_in_time(self) -> None:
        """Wake people after a step of the world: as `_wake`, and those whose wait has ended."""
        now_us = self._here.now_us
        for person in self._people.values():
            if person.node is not None and now_us >= self._patient_until_us(person):
                node, person.node = person.node, None
                node.kernel.wake(node)

    # --- what people do

    def __call__(self, run: Run, actor: str) -> Iterator[ConcreteAction]:
        """The actions of an actor, up to when its agent has nothing to do, and nothing more to expect for a while.

        Raises:
            InteractiveAgentError: an agent cannot continue, or hears what has no value yet.
            GenerateError: its action is not a command.
        """
        if self._kernel is None:
            self._kernel = run.kernel
            run.kernel.after_steps.append(self._wake_in_time)
        person = self._people[actor]
        person.is_asked = True
        while True:
            try:
                ready = self._is_ready(person)
            except (BdiError, CouplingError, GenerateError) as error:
                raise InteractiveAgentError(
                    f"InteractiveAgent: {actor} at {run.kernel.now_s:.3f} s: {error}"
                ) from error
            if not ready:
                self._record.leave(actor, person.free_us, run.kernel.now_us)
                return
            if disturbance := self._decisions.disturbance(self._run.now_s):
                yield draw_action(disturbance, self._commands, run.test.seed, len(run.taken))
            command = self._take(person, len(run.taken) + 1)
            yield draw_action(command, self._commands, run.test.seed, len(run.taken))

    @property
    def _here(self) -> Kernel:
        assert self._kernel is not None, "somebody has asked for an action"
        return self._kernel

    def _is_ready(self, person: _Person) -> bool:
        """The person is free: whether there is something to do, now or after a while."""
        person.free_us, person.waits = self._here.now_us, 0
        self._advance()
        if not self._begun:
            self._begun = True
            self._decisions.begin(self._run, self._steering)
            self._settle()
        if person.activity is not None:
            self._record.end(person.activity[0], self._here.now_us)
            self._late.reopen()
            self._go_on_after(person)
            self._settle()
        self._listen(person)
        goal = self._decisions.goal(person.role.goals, self._run.now_s)
        if goal != NONE:
            self._tell(person, parse_literal(goal), self._steering.name, is_goal=True)
        return bool(person.agent.ready_acts) or self._waits(person)

    def _go_on_after(self, person: _Person) -> None:
        """The agent continues after its action, unless it has given up meanwhile what the action was part of."""
        assert person.activity is not None, "somebody has asked"
        (number, done), person.activity = person.activity, None
        if done in person.agent.ready_acts:
            person.agent.go_on_after(done)
        else:
            self._record.drop(number)

    def _waits(self, person: _Person) -> bool:
        """The person waits: whether there is something to do in the end."""
        kernel = self._here
        while True:
            has_patience = kernel.now_us < self._patient_until_us(person) and person.waits < MOST_WAITS
            if has_patience and not person.agent.ready_acts:
                self._block(person)
                self._listen(person)
                continue
            kernel.sleep((1 + person.place) / US_PER_S)
            self._advance()
            self._listen(person)
            if person.agent.ready_acts or not has_patience:
                return bool(person.agent.ready_acts)

    def _block(self, person: _Person) -> None:
        """Block the person's node until there is something to listen to or to do, or something has ended."""
        kernel, due_ticks = self._here, person.due_ticks
        person.node = kernel.current()
        try:
            if kernel.world is not None:
                kernel.block()  # a time-out would be a step of the world that the test does not have: `_wake_in_time`
            else:
                kernel.block((self._patient_until_us(person) - kernel.now_us) / US_PER_S)
        finally:
            person.node = None
        self._advance()
        person.waits += due_ticks <= self._run.ticks

    def _patient_until_us(self, person: _Person) -> int:
        """The time until which a person waits before it looks again: the next end of a wait, or of its patience."""
        due_s = self._run.due_s
        patient_us = person.free_us + round(person.role.declaration.idle_timeout_s * US_PER_S)
        if due_s == math.inf:
            return patient_us
        due_us = math.ceil(round(due_s * US_PER_S, 3))
        return due_us if person.due_ticks < math.inf else min(due_us, patient_us)

    def _take(self, person: _Person, number: int) -> str:
        act = self._decisions.act(person.agent.ready_acts, self._run.now_s)
        command = command_from_action(act.text, person.name)
        person.activity = number, act
        self._record.begin(ActionStart(number, person.name, person.free_us, self._here.now_us))
        self._decisions.taken.append(command)
        return command

    # --- the agents

    def _listen(self, person: _Person) -> None:
        for heard in person.inbox.listen():
            self._tell(person, heard.literal, heard.source, heard.is_goal)

    def _tell(self, person: _Person, literal: Structure, source: str, is_goal: bool) -> None:
        self._run.tell(person.agent, literal, source, is_goal)
        self._wake()

    def _settle(self) -> None:
        self._run.settle()
        self._wake()

    def _advance(self) -> None:
        """The agents' clock is that of the run: waits end at their times."""
        self._run.advance_to(self._here.now_s)
        self._wake()

    def _choose(self, about: str, options: tuple[str, ...]) -> str:
        return self._decisions.choose(about, options, self._run.now_s)

    def _believe(self, literal: Structure) -> None:
        for person in self._people.values():
            person.agent.believe(literal)
            person.agent.awake = True

    def _disbelieve(self, literal: Structure) -> None:
        for person in self._people.values():
            person.agent.disbelieve(literal)
            person.agent.awake = True

    # --- what the run became

    def as_test(self, test: ConcreteTest, end_s: float) -> ConcreteTest:
        """The test that the run became, which is the same run without the agents.

        Args:
            test: the test, with the actions that were taken.
            end_s: when the run ended (s).
        """
        end_us = round(end_s * US_PER_S)
        for person in self._people.values():
            is_busy = person.activity is not None
            if is_busy:
                self._go_on_after(person)  # so that what led to its action is among the steps, too
            if person.is_asked and not self._record.has_left(person.name):
                since_us = end_us if is_busy else person.free_us
                rest_us = end_us - since_us + round(person.role.declaration.idle_timeout_s * US_PER_S)
                self._record.leave(person.name, since_us, since_us + rest_us)
        with suppress(BdiError):  # an agent cannot continue after its last action, which had not ended
            self._run.settle()
        programs = {role.agent.name: role.agent.program for role in self._roles}
        programs[self._steering.name] = self._roles[0].steering.program
        return self._record.as_test(test, Trace(tuple(self._run.steps)), programs)

    def plans(self, actor: str) -> tuple[str, ...]:
        """The labels of the plans that an actor's agent has executed, sorted, each once."""
        person = self._people[actor]
        return person.role.plans_executed(person.agent)


def _note(template: AgentTemplate, run: _PeopleRun, kind: type[TracedAgent]) -> TracedAgent:
    agent = template.agent(run, kind)
    assert isinstance(agent, TracedAgent)
    return agent
