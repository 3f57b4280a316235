"""A run in earnest, segment by segment."""

from __future__ import annotations

import math
from typing import Any

from ..compiled import CompiledAgent
from ..environment import Environment
from ..prototype import Prototype
from ..quiet import QUIET_ROUNDS
from ..scheduler import Run
from ..spinning import count_from, make_up
from .diagram import Segment
from .state import MentalState, mental_state, restore
from .watching import Notes, Receiver, WatchedTable

_CUT = "cut"
"""How a run has ended that is at the end of a segment, to go on from there."""
_UNCERTAIN = "uncertain"
"""How a run has ended of which nothing can be said for others."""
_SHORTEST = 3
"""Rounds that a segment takes at least: what begins is often seen beginning in the round after, too."""
_PATIENCE = 100
"""Rounds after which a segment may end in the middle of what the receiver does."""
_MOST_UNSEEN = 20
"""Rounds that an agent that is alone may do before the run is looked at."""
_QUIET_BEFORE = 10
"""Rounds without a change that a segment may begin after."""


class RecordingRun(Run):
    """A run whose segments are noted.

    Args:
        environment: the plain environment.
        seed: of the run's random numbers.
        prototypes: the agents.
        notes: where to note on what it depends.
        states: the states of the agents to go on from; without them, the run is at its beginning.
    """

    watched = True

    def __init__(
        self,
        environment: Environment,
        seed: int,
        prototypes: tuple[Prototype, ...],
        notes: Notes,
        states: tuple[MentalState, ...] | None,
    ) -> None:
        super().__init__(environment, seed, None)
        self.notes = notes
        self._quiet = 0
        """At most so many rounds ago has anything changed."""
        self._looked = 0
        """The round of the last look."""
        self._progress = 0
        """The progress made until then."""
        self._left_out: int | None = None
        """The place of the steering agent's table of what it forwards."""
        for prototype in prototypes:
            receives = prototype.name in notes.forwarding.receivers and prototype.code is not None
            self.agents[prototype.name] = (
                Receiver(prototype.name, self, prototype.code, notes)  # type: ignore[arg-type]
                if receives
                else prototype.agent(self)
            )
        steering = self.agents[notes.forwarding.steering]
        if isinstance(steering, CompiledAgent):
            self._left_out = steering.code.program.tables[notes.forwarding.key]
            steering.tables[self._left_out] = WatchedTable(steering.tables[self._left_out], notes)
        if states is not None:
            self.go_back(notes, states)

    def fits(self, notes: Notes, environment: Environment, seed: int) -> bool:
        """Whether it can go back to a node of a run with this environment and seed, and these notes."""
        same = self.environment is environment and self._seed == seed and self.notes.forwarding is notes.forwarding
        return same and all(isinstance(agent, CompiledAgent) for agent in self.agents.values())

    def go_back(self, notes: Notes, states: tuple[MentalState, ...]) -> None:
        """Go on from other states instead, and with other atoms."""
        self.notes = notes
        self.earliest_deadline = math.inf
        self.spinning.clear()
        for agent, state in zip(self.agents.values(), states, strict=True):
            assert isinstance(agent, CompiledAgent)
            if isinstance(agent, Receiver):
                agent.go_back(notes, state.propositions)
            else:
                agent.p = dict(state.propositions)
            if agent.name != notes.forwarding.steering:
                restore(agent, state)
            elif self._left_out is not None:
                restore(agent, state, self._left_out)
                agent.tables[self._left_out] = WatchedTable({}, notes)
        notes.missing, notes.looks = 0, 1
        self._quiet = _QUIET_BEFORE

    @property
    def plain(self) -> bool:
        """Compiled agents may take part."""
        return True

    def replace(self, agent: Any) -> None:
        """An agent is handed over to the interpreter: nobody knows what it looks at."""
        self.notes.certain = False
        super().replace(agent)

    def record(self, max_rounds: int) -> tuple[Segment, tuple[MentalState, ...] | None] | None:
        """Do the next segment.

        Args:
            max_rounds: the rounds that it may take.

        Returns:
            The segment, and the states of the agents at its end if that is not the end of the run. None if it is not
            certain that other runs in this state with the same answers to the questions have the same segment: then
            the run cannot go on here.

        Raises:
            BdiError: an agent cannot go on.
        """
        ticks = self.ticks
        self.skipped, self.rounds, self._looked = ticks, 0, 0
        self._progress = self.progress
        self.notes.questions = {}
        self._ended = ""
        for agent in self.spinning.values():
            count_from(agent, 0)
        ended = self.go(max_rounds)
        if ended == _CUT:
            self._quiet = _QUIET_BEFORE
            return self._segment(ticks, ""), self._states
        if ended in ("idle", "spin") and self.notes.certain and self.rounds < max_rounds:
            return self._segment(ticks, ended), None
        return None

    def _rounds(self, until: int) -> bool:
        """As in any run, but not so many that it would be unknown when something has changed."""
        return super()._rounds(min(until, self.rounds + _MOST_UNSEEN))

    def look(self) -> bool:
        """After a round: whether the segment ends here, or the run must not go on."""
        done, self._looked = self.rounds - self._looked, self.rounds
        if self._quiet + done >= QUIET_ROUNDS:
            self.notes.certain = False
        if self.progress != self._progress:
            self._progress = self.progress
            self._quiet = done
        else:
            self._quiet += done
        if not self.notes.certain:
            self._ended = _UNCERTAIN
        elif self._may_cut():
            self._ended = _CUT
        return bool(self._ended)

    def _may_cut(self) -> bool:
        """Whether a receiver has just begun with something, or is about to: then it is most often in a known state."""
        if self._quiet > _QUIET_BEFORE or self.rounds < _SHORTEST or not self.notes.forwarded:
            return False
        ready = self._order[self._ready[-1]] if self._ready else None
        if not isinstance(ready, Receiver) or self.ticks >= self.earliest_deadline:
            return False
        return (self.rounds >= _PATIENCE or ready.begins()) and self._find_states()

    def _find_states(self) -> bool:
        """Note the states of all agents before the next round; False if they cannot be compared."""
        now = self.ticks
        states = []
        for name, agent in self.agents.items():
            if not isinstance(agent, CompiledAgent):
                return False
            if isinstance(agent, Receiver):
                states.append(mental_state(agent, now, agent.watched.settled_content()))
            elif name != self.notes.forwarding.steering:
                states.append(mental_state(agent, now, agent.p.items()))
            elif agent.has_work() or agent.waits:
                # It could still be about to forward something.
                return False
            else:
                states.append(mental_state(agent, now, agent.p.items(), self._left_out))
        self._states = tuple(states)
        try:
            hash(self._states)
        except TypeError:
            return False
        return True

    def _segment(self, since: int, ended: str) -> Segment:
        """The segment that ends here; ``since`` is the tick of its beginning."""
        plans = []
        for name, agent in self.agents.items():
            make_up(agent)
            if agent.executed:
                plans.append((name, agent.executed))
                agent.executed = []
        segment = Segment(self.rounds, self.ticks - since, self.prints, self.actions, self.warnings, plans, ended)
        self.prints, self.actions, self.warnings = [], [], []
        return segment
