"""A run in earnest that notes on what it depends."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from ..compiled import CompiledAgent
from ..compiled.activity import Slot, Store
from ..compiled.program import Annots
from ..environment import Environment
from ..prototype import Prototype
from ..quiet import QUIET_ROUNDS
from ..scheduler import Run
from ..terms import Structure
from .diagram import Segment
from .forwarding import Forwarding
from .state import mental_state

KNOWN = "known"
"""How a recorded run has ended that has come to where others have been."""
_QUIET_BEFORE = 10
"""Rounds without a change that a segment may begin after."""


class Notes:
    """What a recorded run notes.

    Args:
        forwarding: how the atoms are forwarded.
        atoms: the atoms.
    """

    def __init__(self, forwarding: Forwarding, atoms: frozenset[str]) -> None:
        self.forwarding = forwarding
        self.atoms = atoms
        self.certain = True
        """Whether other runs may rely on what is noted."""
        self.missing = len(atoms) * len(forwarding.receivers)
        """Atoms that are still to arrive."""
        self.looks = 0
        """How often the steering agent has looked at its percepts."""
        self.questions: dict[str, bool] = {}
        """What has been asked in the current segment."""

    def ask(self, atom: str, answer: bool) -> None:
        """A receiver has looked whether it holds an atom that could only have been forwarded to it."""
        if self.missing:
            self.certain = False
        self.questions.setdefault(atom, answer)


class WatchedBeliefs(dict[str, Annots]):
    """A receiver's beliefs without arguments: looking at one that could be forwarded is noted."""

    def __init__(self, beliefs: dict[str, Annots], notes: Notes) -> None:
        super().__init__(beliefs)
        self._notes = notes
        self.settled = set(beliefs)
        """The beliefs that no longer depend on the atoms forwarded."""

    def _look(self, slot: str) -> None:
        if slot not in self.settled:
            self._notes.ask(slot, super().__contains__(slot))

    def __contains__(self, slot: object) -> bool:
        self._look(str(slot))
        return super().__contains__(slot)

    def __getitem__(self, slot: str) -> Annots:
        self._look(slot)
        return super().__getitem__(slot)

    def get(self, slot: str, default: Any = None) -> Any:
        """The annotations of a belief."""
        self._look(slot)
        return super().get(slot, default)

    def __setitem__(self, slot: str, annots: Annots) -> None:
        self._look(slot)
        self.settled.add(slot)
        super().__setitem__(slot, annots)

    def __delitem__(self, slot: str) -> None:
        self._look(slot)
        self.settled.add(slot)
        super().__delitem__(slot)

    def pop(self, slot: str, default: Any = None) -> Any:
        """Take a belief out."""
        self._look(slot)
        self.settled.add(slot)
        return super().pop(slot, default)

    def holds(self, slot: str) -> bool:
        """Whether there is such a belief; nobody else asks."""
        return super().__contains__(slot)

    def arrive(self, atom: str, annots: Annots) -> None:
        """An atom has been forwarded."""
        super().__setitem__(atom, annots)

    def settled_content(self) -> frozenset[Hashable]:
        """What no longer depends on the atoms."""
        held = super().get
        return frozenset((slot, held(slot)) for slot in self.settled)


class WatchedTable(dict[Slot, Annots]):
    """The steering agent's percepts to be forwarded."""

    def __init__(self, table: Store, notes: Notes) -> None:
        super().__init__(table)
        self._notes = notes

    def items(self) -> Any:
        """All of them, as a loop asks for them."""
        self._notes.looks += 1
        if self._notes.looks > 1:
            self._notes.certain = False
        return super().items()


class Receiver(CompiledAgent):
    """An agent to which atoms are forwarded."""

    def __init__(self, prototype: Prototype, run: RecordingRun) -> None:
        assert prototype.code is not None
        super().__init__(prototype.name, run, prototype.code)
        self._notes = run.notes
        self._awaited = set(run.notes.atoms)
        self.watched = WatchedBeliefs(self.p, run.notes)
        self.p = self.watched

    def _believe(self, literal: Structure, annots: Annots) -> None:
        atom = literal.functor
        from_steering = str(annots[0]) == f"source({self._notes.forwarding.steering})"
        if atom not in self._notes.atoms or literal.args or literal.negated or not from_steering:
            super()._believe(literal, annots)
        elif atom in self._awaited and not self.watched.holds(atom):
            self._awaited.remove(atom)
            self._notes.missing -= 1
            self.watched.arrive(atom, annots)
            self.run.progress += 1
        else:
            # It has come twice, or the agent has come to believe it by itself.
            self._notes.certain = False
            super()._believe(literal, annots)


class RecordingRun(Run):
    """A run whose segments are noted.

    Args:
        environment: the plain environment.
        seed: of the run's random numbers.
        prototypes: the agents.
        notes: where to note on what it depends.
        known: the segments from a state on, if they are known; then the run can stop there.
    """

    def __init__(
        self,
        environment: Environment,
        seed: int,
        prototypes: tuple[Prototype, ...],
        notes: Notes,
        known: Callable[[Hashable], list[Segment] | None],
    ) -> None:
        super().__init__(environment, seed, None)
        self._known = known
        self.ahead: list[Segment] = []
        """The known segments at whose beginning the run has stopped."""
        self.notes = notes
        self.segments: list[tuple[Hashable, Segment]] = []
        """The states in which segments end, and the segments."""
        self._marks: tuple[int, int, int, int, int] = (0, 0, 0, 0, 0)
        self._labels: dict[str, int] = {}
        self._quiet = 0
        """At most so many rounds ago has anything changed."""
        self._left_out: int | None = None
        for prototype in prototypes:
            receives = prototype.name in notes.forwarding.receivers
            self.agents[prototype.name] = Receiver(prototype, self) if receives else prototype.agent(self)
        steering = self.agents[notes.forwarding.steering]
        if isinstance(steering, CompiledAgent):
            self._left_out = steering.code.program.tables[notes.forwarding.key]
            steering.tables[self._left_out] = WatchedTable(steering.tables[self._left_out], notes)

    @property
    def plain(self) -> bool:
        """Compiled agents may take part."""
        return True

    def replace(self, agent: Any) -> None:
        """An agent is handed over to the interpreter: nobody knows what it looks at."""
        self.notes.certain = False
        super().replace(agent)

    def _rounds(self, limit: int) -> int:
        if self.notes.certain:
            self._cut()
            if self.ahead:
                self._ended = KNOWN
                return 1
        before = self.progress
        done = super()._rounds(limit)
        if self._quiet + done >= QUIET_ROUNDS:
            self.notes.certain = False
        self._quiet = done if self.progress != before else self._quiet + done
        return done

    def _cut(self) -> None:
        """End a segment here if only a receiver has anything to do: most often it has just been told something."""
        if self.notes.missing or self.notes.looks != 1 or self._quiet > _QUIET_BEFORE:
            return
        if len(self._ready) != 1 or not isinstance(self._order[self._ready[0]], Receiver):
            return
        state = self._state()
        if state is None:
            return
        self._end_segment(state, "")
        self._quiet = _QUIET_BEFORE
        self.ahead = self._known(state) or []

    def _state(self) -> Hashable | None:
        """The state of all agents; None if it cannot be compared."""
        parts: list[Hashable] = []
        for name, agent in self.agents.items():
            if not isinstance(agent, CompiledAgent):
                return None
            if isinstance(agent, Receiver):
                parts.append(mental_state(agent, agent.watched.settled_content()))
            elif name != self.notes.forwarding.steering:
                parts.append(mental_state(agent, frozenset(agent.p.items())))
            elif agent.has_work() or agent.waits:
                # It could still be about to forward something.
                return None
            else:
                parts.append(mental_state(agent, frozenset(agent.p.items()), self._left_out))
        state = tuple(parts)
        try:
            hash(state)
        except TypeError:
            return None
        return state

    def _end_segment(self, state: Hashable, ended: str) -> None:
        rounds, ticks, prints, actions, warnings = self._marks
        plans = []
        for name, agent in self.agents.items():
            seen = self._labels.get(name, 0)
            if len(agent.executed) > seen:
                plans.append((name, tuple(agent.executed[seen:])))
                self._labels[name] = len(agent.executed)
        segment = Segment(
            self.rounds - rounds,
            self.ticks - ticks,
            tuple(self.prints[prints:]),
            tuple(self.actions[actions:]),
            tuple(self.warnings[warnings:]),
            tuple(plans),
            tuple(self.notes.questions.items()),
            ended,
        )
        self._marks = (self.rounds, self.ticks, len(self.prints), len(self.actions), len(self.warnings))
        self.notes.questions = {}
        self.segments.append((state, segment))

    def finish(self, ended: str) -> None:
        """The run has ended by itself: its last segment ends, too."""
        self._end_segment(None, ended)
