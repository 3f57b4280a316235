"""`Product`: runs the oracle's agent in step with a run under test, and finds where the run deviates from it.

`ConformanceMonitor` gives it each `ObservedEvent`, and gets a `ModelDeviation` if the agent does not expect the event.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field

from pytest_hricdv.bdi import Structure
from pytest_hricdv.bdi.agent.intentions import Event, IntendedMeans, Intention
from pytest_hricdv.bdi.language.terms import SOURCE_SELF, Number
from pytest_hricdv.bdi.logic.unify import unify
from pytest_hricdv.coupling.coupled_agent import MS_PER_S, CoupledAgent, CoupledRun, ReadyAct
from pytest_hricdv.coupling.events import Bindings
from pytest_hricdv.extra.oracle.oracle import Oracle
from pytest_hricdv.monitor import Trigger


class FollowedAgent(CoupledAgent):
    """An agent that stops before each act that corresponds to an event of the run."""

    oracle: Oracle

    def follow(self, oracle: Oracle) -> None:
        """Prepare for following."""
        self.oracle = oracle
        self.couple()

    def react(self, event: Event) -> IntendedMeans | bool:
        """Select a plan, and stop before it if its beginning is an act."""
        reacted = super().react(event)
        if isinstance(reacted, IntendedMeans) and (acts := self.oracle.labels.get(reacted.plan.label)):
            self.stop_before(self.intentions.pop(), f"@{reacted.plan.label}", None, acts)
        return reacted

    def acts_of(self, intention: Intention, literal: Structure) -> tuple[int, ...] | None:
        """The declared acts that this one is; None if it is none."""
        does = self.oracle.actions
        acts = tuple(
            number
            for number in self.oracle.literals.get(literal.key, ())
            if (pattern := does[number].pattern) is not None and unify(pattern, literal, {}, [])
        )
        return acts or None


class ModelFollower:
    """Follows one run with the oracle's agent.

    Args:
        oracle: what it follows.
        limits: belief -> the duration (s) that it believes in this run.
    """

    def __init__(self, oracle: Oracle, limits: Mapping[str, float]) -> None:
        self.run = CoupledRun()
        agent = oracle.agent.agent(self.run, FollowedAgent)
        assert isinstance(agent, FollowedAgent)
        agent.follow(oracle)
        self.agent = agent
        self.run.put([agent], oracle.others)
        for name, limit in limits.items():
            # Whole milliseconds: sums of them are exact, so that a limit is reached when it should be.
            self._set_belief(name, round(limit * MS_PER_S))
        self.run.settle()

    def _set_belief(self, name: str, value: float) -> None:
        beliefs = self.agent.beliefs
        for held in list(beliefs.bucket((False, name, 1)).values()):
            if isinstance(held, Structure):
                beliefs.remove(held)
        beliefs.add(Structure(name, (Number(value),), (SOURCE_SELF,)))

    @property
    def due_s(self) -> float:
        """When the agent's next wait is over (s); infinite if there is none."""
        return self.run.due_s

    def hear(self, literal: Structure, source: str, goal: bool) -> None:
        """Tell the agent something, or give it a goal, now."""
        self.run.tell(self.agent, literal, source, goal)

    def observe(self, act: ReadyAct, succeeded: bool = True) -> None:
        """An act for which the agent is ready has been observed: it continues."""
        self.agent.go_on_after(act, succeeded)
        self.run.settle()

    def wait_until(self, time_s: float) -> None:
        """The clock has reached `time_s`, and no wait is over before it: the agent continues if one is over by now.

        Raises:
            BdiError: as `CoupledRun.wait_until`.
        """
        self.run.wait_until(time_s)


NOTHING = "nothing"


@dataclass(frozen=True)
class ModelPercept:
    """A percept of the agent: a literal, from whom, and whether it is a goal."""

    literal: Structure
    source: str
    goal: bool


@dataclass(frozen=True)
class ObservedEvent:
    """An event of the run that corresponds to something.

    Args:
        time_s: when it happened (s).
        source: the topic of the message, or the signal.
        text: message or signal with its values, for people.
        heard: what the agent hears by it.
        does: the numbers of the acts that it shows, with the values of their variables.
        fails: the numbers of the acts that fail by it, with the values of their variables.
    """

    time_s: float
    source: str
    text: str
    heard: tuple[ModelPercept, ...] = ()
    does: Mapping[int, Bindings] = field(default_factory=dict)
    fails: Mapping[int, Bindings] = field(default_factory=dict)


@dataclass(frozen=True)
class ModelDeviation:
    """A deviation of the run from the agent.

    Args:
        since_s: when the agent became ready for the expected act (s).
        time_s: when the run deviated: the unexpected event, or the end of the time in which one was expected (s).
        expected: the acts that were possible, with their times, for people.
        observed: what happened instead, for people.
        acts: the acts that were possible.
        event: the topic or signal of what happened instead; "nothing" if nothing did.
    """

    since_s: float
    time_s: float
    expected: str
    observed: str
    acts: tuple[str, ...]
    event: str


class Product:
    """The product of an agent and a run, step by step.

    Args:
        limits: belief -> the duration (s) that the agent believes in this run.
        delayed: the numbers of the observed events (from 0) that the agent hears only after the tolerance.
    """

    def __init__(self, oracle: Oracle, limits: Mapping[str, float], delayed: frozenset[int] = frozenset()) -> None:
        self._oracle = oracle
        self._does = oracle.declaration.actions
        self._tolerance_s = oracle.declaration.tolerance_s
        self._delayed = delayed
        self._count = 0
        self._early: deque[ObservedEvent] = deque()
        """Observed before the agent was ready for it, and not yet a deviation."""
        self._hears_later: deque[tuple[float, ModelPercept]] = deque()
        self._end_s = math.inf
        self.follower = ModelFollower(oracle, limits)
        self.deviation: ModelDeviation | None = None
        self.triggers: list[Trigger] = []
        """The acts that have been observed, in order."""
        self.races: list[int] = []
        """The numbers of the observed events that were heard at most the tolerance before a time-out of the agent."""

    def step(self, event: ObservedEvent) -> None:
        """An event has happened; they come in the order of time."""
        self.advance(event.time_s)
        number, self._count = self._count, self._count + 1
        if event.heard and self.follower.due_s <= event.time_s + self._tolerance_s:
            self.races.append(number)
        # Events after an unexpected one wait for their turn. A failure that nobody waits for is none.
        if event.does and (self._early or not self._match(event)):
            self._early.append(event)
        elif not event.does:
            self._match(event)
        if number in self._delayed:
            self._hears_later += ((event.time_s + self._tolerance_s, heard) for heard in event.heard)
        else:
            self._hear(event.heard)

    def advance(self, time_s: float) -> None:
        """The run has reached `time_s` (s), and nothing has happened in between."""
        follower = self.follower
        while self.deviation is None:
            hears_s = self._hears_later[0][0] if self._hears_later else math.inf
            due_s = min(max(follower.due_s, follower.run.now_s), hears_s)
            self._expire(min(due_s, time_s))
            if due_s > time_s or self.deviation is not None:
                break
            follower.wait_until(due_s)
            if hears_s <= due_s:
                self._hear([self._hears_later.popleft()[1]])
            self._match_early()
        if time_s < math.inf:
            follower.wait_until(max(time_s, follower.run.now_s))

    def finish(self, time_s: float) -> None:
        """The run has ended at `time_s` (s): acts that could still come are not expected any more."""
        self.advance(time_s)
        self._end_s = time_s
        if self._early:  # one tolerance until it counts as early, another one for inputs that are heard late
            self.advance(time_s + 2 * self._tolerance_s)

    def _hear(self, heard: Iterable[ModelPercept]) -> None:
        for event in heard:
            self.follower.hear(event.literal, event.source, event.goal)
        self._match_early()

    def _match_early(self) -> None:
        while self._early and self.deviation is None and self._match(self._early[0]):
            self._early.popleft()

    def _match(self, event: ObservedEvent) -> bool:
        """Let the agent do what has been observed; whether it was ready for any of it, or a deviation was found."""
        does, fails = dict(event.does), dict(event.fails)
        matched = False
        while (matching := self._ready_for(does, fails)) is not None:
            act, number, succeeded = matching
            (does if succeeded else fails).pop(number)
            wait_s = max(event.time_s - act.ready_s, 0.0)
            if succeeded and wait_s < self._does[number].within_s[0]:
                self._deviate(event.time_s, [act], f"{event.text} after {wait_s:.1f} s", event.source)
                return True
            self.triggers.append(Trigger(act.ready_s, act.ready_s + wait_s, "passed"))
            self.follower.observe(act, succeeded)
            matched = True
        return matched

    def _ready_for(
        self, does: Mapping[int, Bindings], fails: Mapping[int, Bindings]
    ) -> tuple[ReadyAct, int, bool] | None:
        for act in self.follower.agent.ready_acts.different(does.keys() | fails.keys()):
            for number in act.acts:
                for observed, succeeded in ((does, True), (fails, False)):
                    if number in observed and self._is(act, number, observed[number]):
                        return act, number, succeeded
        return None

    def _is(self, act: ReadyAct, number: int, bindings: Bindings) -> bool:
        pattern = self._oracle.actions[number].pattern
        return act.literal is None or pattern is None or unify(pattern, act.literal, dict(bindings), [])

    def _expire(self, before_s: float) -> None:
        """Find what should have happened before `before_s`, or should not have."""
        ready = self.follower.agent.ready_acts
        # Deadlines increase with the time at which the agent became ready, so the first of equal acts is due.
        overdue = [
            (last_s, act) for act in ready.longest_ready() if (last_s := self._last_s(act)) < min(before_s, self._end_s)
        ]
        # By time alone: acts cannot be compared.
        last_s, late = min(overdue, key=lambda deadline: deadline[0], default=(math.inf, None))
        early = self._early[0] if self._early else None
        if early is not None and early.time_s + self._tolerance_s < before_s and early.time_s <= last_s:
            self._deviate(early.time_s, ready, early.text, early.source)
        elif late is not None:
            self._deviate(last_s, [late], NOTHING, NOTHING)

    def _last_s(self, act: ReadyAct) -> float:
        return act.ready_s + max(self._does[number].within_s[1] for number in act.acts)

    def _deviate(self, time_s: float, acts: Collection[ReadyAct], observed: str, event: str) -> None:
        agent = self._oracle.agent.name
        expected = " or ".join(map(self._expectation, acts)) or f"{NOTHING}, as {agent} waits"
        if self.follower.run.warnings:
            expected += f" ({self.follower.run.warnings[-1]})"
        since_s = min((act.ready_s for act in acts if act.ready_s <= time_s), default=time_s)
        self.deviation = ModelDeviation(since_s, time_s, expected, observed, tuple(act.text for act in acts), event)

    def _expectation(self, act: ReadyAct) -> str:
        declared = [self._does[number] for number in act.acts]
        first_s, last_s = (choose(does.within_s[at] for does in declared) for at, choose in ((0, min), (1, max)))
        when = f"within {last_s:g} s of" if first_s == 0 else f"{first_s:g} to {last_s:g} s after"
        observed_by = " or ".join(dict.fromkeys(does.when for does in declared))
        plan = f"plan @{act.plan} of {self._oracle.agent.name}, " if act.plan else ""
        return f"{act.text} {when} {act.ready_s:.1f} s ({plan}observed by {observed_by})"
