"""One run of a multi-agent system: rounds, virtual time, and how a run ends.

In a round every agent does one reasoning cycle, in the order of the project file, so that a run is a
function of the models, the percepts and the seed. A round takes one tick of virtual time; when nobody has
anything to do before some wait is over, time jumps there. Agents with nothing to do are not looked at, and
an agent that is alone in having something to do may do several cycles at once, up to the next round in
which something else could happen.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.logic.unify import unify

from .agent import Agent
from .books import Books
from .environment import Environment
from .intentions import Message
from .participant import Participant
from .quiet import Quiet
from .spinning import is_busy, make_up


class Run(Books):
    """A run of a system.

    Args:
        environment: what the agents perceive and act on.
        seed: of the run's one stream of random numbers.
        goal: the agent and the goal with whose achievement the run ends, if any.
    """

    watched = False
    """Whether :meth:`look` is asked after each round, when an agent that is alone begins to act and when it ends."""
    leaves_alone = True
    """Whether agents that only look again and again are left alone until something comes to them."""

    def __init__(self, environment: Environment, seed: int, goal: tuple[str, Structure] | None) -> None:
        super().__init__(environment, seed)
        self.agents: dict[str, Participant] = {}
        self.earliest_deadline = math.inf
        """No wait is over before this tick."""
        self._goal = goal
        self._ended = ""
        self._seen_changes = environment.changes
        self._until = 0
        """The round that the agents may go on to by themselves."""
        self._order: list[Participant] = []
        """The agents in the order in which they act."""
        self._ready: list[int] = []
        """The places in that order of the agents that are awake, ascending."""
        self._compiled = False
        """Whether all agents are compiled."""
        self.held: Participant | None = None
        """The agent that has gone ahead of others and waits for them to catch up, if there is one."""
        self._furthest = 0
        """The rounds that any agent has done."""
        self._held_until = 0
        self.spinning: dict[str, Participant] = {}
        """The agents that are left alone because they only look again and again."""

    @property
    def plain(self) -> bool:
        """Whether nothing is asked of the run that only interpreted agents give: steps one by one, goals noted."""
        return self._goal is None

    # --- what agents use

    def something_else_can_happen(self) -> bool:
        """While one agent was alone: whether by the next round another has something to do, a wait or the run ends."""
        return len(self._ready) > 1 or self.rounds + 1 >= self._until

    def wake(self, agent: Participant) -> None:
        """An agent has something to do: in this round if it is yet to act in it, else in the next."""
        if not agent.awake:
            agent.awake = True
            ready, place = self._ready, agent.place
            if ready:
                insort(ready, place)
            else:
                ready.append(place)

    def deliver(self, to: Participant, message: Message) -> None:
        """Put a message into its receiver's mailbox."""
        to.mailbox.append(message)
        self.wake(to)
        self.progress += 1

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """Let the environment execute an action; whether it succeeded.

        Raises:
            BdiError: the environment raised an exception.
        """
        self.actions.append((agent, str(action)))
        self.progress += 1
        try:
            success = self.environment.execute(agent, action)
        except Exception as error:
            place = f"plan @{plan.label} ({statement.location})"
            what = f"action {action} raised {type(error).__name__}: {error}"
            raise BdiError(f"agent {agent}, {place}: {what}") from error
        if self.environment.changes != self._seen_changes:
            self._seen_changes = self.environment.changes
            for other in self.agents.values():
                if other.has_work():
                    self.wake(other)
        return bool(success)

    def note_achieved(self, agent: str, goal: Structure) -> None:
        """A plan for a goal has come to its end."""
        if self._goal is not None and self._goal[0] == agent and unify(self._goal[1], goal, {}, []):
            self._end("goal")

    def stop(self) -> None:
        """End the run after this round."""
        self._end("stopped")

    def _end(self, how: str) -> None:
        self._ended, self._until = how, self.rounds

    # --- the rounds

    def go(self, max_rounds: int) -> str:
        """Do rounds until the run ends by itself or has had ``max_rounds``.

        Returns:
            How it ended: "idle", "spin", "goal", "stopped" or "round limit".

        Raises:
            BdiError: an agent cannot go on.
        """
        ended = self._go(max_rounds)
        for agent in self.spinning.values():
            make_up(agent)
        return ended

    def _go(self, max_rounds: int) -> str:
        quiet = Quiet(self)
        self._order = list(self.agents.values())
        self._ready = []
        self._compiled = True
        for place, agent in enumerate(self._order):
            agent.place = place
            self._compiled = self._compiled and agent.takes_letters
            if agent.awake:
                self._ready.append(place)
        while self.rounds < max_rounds:
            if not self._rounds(quiet.due if quiet.due < max_rounds else max_rounds):
                if not self._jump():
                    return "idle"
                if quiet.polling():
                    return "spin"
                continue
            if self._ended:
                return self._ended
            if self.spinning and self.stands_still():
                return "spin"
            if self.rounds + self.skipped >= self.earliest_deadline:
                self._end_waits()
            if self.rounds >= quiet.due and quiet.spinning() and (not self._jump() or quiet.polling()):
                return "spin"
        return "round limit"

    def _rounds(self, until: int) -> bool:
        """Do rounds while any agent has something to do, until that round or the end of a wait or of the run.

        In each round those act that are ready. One that is the only one, or the only one left, may do several
        cycles.

        Returns:
            Whether any was done.
        """
        ready, order, watched = self._ready, self._order, self.watched
        self._set_until(until)
        if not ready:
            if not self.spinning and self.held is None:
                return False
            # Nobody acts until some wait is over, or until the one is caught up with that has gone ahead.
            self.rounds = self._until
            if (watched and self.look()) or not self._release(until):
                return True
        place = 0
        try:
            while True:
                index, in_turn = 0, watched and len(ready) > 1
                while index < len(ready):
                    place = ready[index]
                    if len(ready) > 1 or in_turn:
                        order[place].work(1)
                    else:
                        # It may in the last of its rounds give others something to do.
                        # An agent that waits for no time at all leaves no round but this one.
                        done = order[place].work(self._until - self.rounds or 1)
                        if done > 1:
                            self.rounds += done - 1
                        in_turn = watched
                    if ready[index] != place:
                        # Others before it have been woken: they act in the next round.
                        index = bisect_left(ready, place)
                    if order[place].awake:
                        index += 1
                    else:
                        del ready[index]
                self.rounds += 1
                if not ready:
                    self.rounds = max(self.rounds, min(self._furthest, self._until))
                if watched and self.look():
                    return True
                if (not ready or self.rounds >= self._until) and not self._release(until):
                    return True
        except RecursionError:
            acting = order[place]
            raise BdiError(f"{acting.name}: terms nested too deeply, {acting.doing()}") from None

    def _set_until(self, until: int) -> None:
        """The agents may go on by themselves until that round, if no wait is over before and nobody is held."""
        self._until = until if self.held is None else min(until, self._held_until)
        self.note_deadline(self.earliest_deadline)

    def hold(self, agent: Participant, done: int) -> None:
        """An agent has gone ahead of others, and has done all cycles until that round: they have to catch up."""
        if done > self._furthest:
            self._furthest = done
        if agent.awake:
            agent.awake = False
            self.held = agent
            self._until = self._held_until = done

    def _release(self, until: int) -> bool:
        """Let the agent act that is held, if it has been caught up with; whether agents go on before ``until``."""
        held = self.held
        if held is None or self.rounds < self._held_until:
            return False
        self.held = None
        self.wake(held)
        self._set_until(until)
        return self.rounds < self._until

    def look(self) -> bool:
        """After a round of a watched run: whether to stop here, for the reason that is noted then."""
        return False

    def stands_still(self) -> bool:
        """After a round: whether all agents that have anything to do only look again and again."""
        return self.held is None and not any(map(is_busy, self.agents.values()))

    def replace(self, agent: Agent) -> None:
        """Let an agent take the place of the one of its name."""
        before = self.agents[agent.name]
        self.agents[agent.name] = agent
        agent.place = before.place
        self._order[agent.place] = agent
        self._compiled = False
        agent.awake = before.awake

    def dissolve(self) -> None:
        """Let go of the agents after the run: they know it, too, and would wait for Python's garbage collector."""
        self.agents = {}
        self._order = []

    def interpreted(self) -> dict[str, Agent]:
        """The agents, all in the form that the interpreter runs: from now on they are interpreted."""
        return {name: agent.interpreted() for name, agent in list(self.agents.items())}

    # --- waiting

    def note_deadline(self, deadline: float) -> None:
        """An intention has begun to wait until then."""
        if deadline < self.earliest_deadline:
            self.earliest_deadline = deadline
        if deadline - self.skipped < self._until:
            self._until = int(deadline) - self.skipped

    def _jump(self) -> bool:
        """Go to the next moment at which a wait is over; False if there is none."""
        if not self._compiled:
            # What an interpreted agent waits for may have come before its time.
            self.earliest_deadline = min(map(_earliest_deadline, self._order))
        if self.earliest_deadline == math.inf:
            return False
        self.skipped = max(self.skipped, int(self.earliest_deadline) - self.rounds)
        self._end_waits()
        return True

    def _end_waits(self) -> None:
        now, earliest = self.rounds + self.skipped, math.inf
        for agent in self._order:
            if agent.waits or agent.questions:
                agent.end_waits(now)
                if not agent.awake and agent.has_work():
                    self.wake(agent)
                if agent.waits or agent.questions:
                    earliest = min(earliest, _earliest_deadline(agent))
        self.earliest_deadline = earliest


def _earliest_deadline(agent: Participant) -> float:
    earliest = math.inf
    for wait in agent.waits:
        if wait.deadline is not None and wait.deadline < earliest:
            earliest = wait.deadline
    if agent.questions:
        deadlines = [question.deadline for question in agent.questions.values()]
        earliest = min([earliest, *(deadline for deadline in deadlines if deadline is not None)])
    return earliest
