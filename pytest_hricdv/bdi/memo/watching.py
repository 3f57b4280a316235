"""Noting on what a run depends: who looks at which of the atoms forwarded."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pytest_hricdv.bdi.language.terms import Structure, source

from ..compiled import CompiledAgent
from ..compiled.code import AgentCode
from ..compiled.program import Annots, Slot, Store
from ..scheduler import Run
from .forwarding import Forwarding

Settled = Iterable[tuple[str, Annots | None]]


class Notes:
    """What is noted.

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

    @property
    def forwarded(self) -> bool:
        """Whether the steering agent has done its part."""
        return not self.missing and self.looks == 1

    def ask(self, atom: str, answer: bool) -> None:
        """A receiver has looked whether it holds an atom that could only have been forwarded to it."""
        if self.missing:
            self.certain = False
        self.questions.setdefault(atom, answer)


class WatchedBeliefs(dict[str, Annots]):
    """A receiver's beliefs without arguments: looking at one that could be forwarded is noted.

    Args:
        beliefs: what it holds.
        notes: where to note it.
        settled: what it holds, or holds not (None), whatever has been forwarded.
    """

    def __init__(self, beliefs: dict[str, Annots], notes: Notes, settled: Settled) -> None:
        super().__init__(beliefs)
        self._notes = notes
        self.settled: set[str] = set()
        """The beliefs that no longer depend on the atoms forwarded."""
        for slot, annots in settled:
            self.settled.add(slot)
            if annots is not None:
                super().__setitem__(slot, annots)
            else:
                super().pop(slot, None)

    def _look(self, slot: str) -> None:
        if slot not in self.settled:
            self._notes.ask(slot, super().__contains__(slot))

    def __contains__(self, slot: object) -> bool:
        held = dict.__contains__(self, slot)
        if slot not in self.settled:
            self._notes.ask(str(slot), held)
        return held

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

    def settled_content(self) -> list[tuple[str, Annots | None]]:
        """What no longer depends on the atoms; None for what is not held."""
        held = super().get
        return [(slot, held(slot)) for slot in self.settled]


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
    """An agent to which atoms are forwarded.

    Args:
        name: its name.
        run: the run it takes part in.
        code: its program and how it begins.
        notes: where to note at what it looks.
    """

    __slots__ = ("_annots", "_awaited", "_notes", "watched")

    def __init__(self, name: str, run: Run, code: AgentCode, notes: Notes) -> None:
        super().__init__(name, run, code)
        self.is_watched = True
        self._notes = notes
        self._annots: Annots = (source(notes.forwarding.steering),)
        self._awaited = set(notes.atoms)
        self.watched = WatchedBeliefs({}, notes, self.p.items())
        self.p = self.watched

    def _believe(self, literal: Structure, annots: Annots) -> None:
        atom = literal.functor
        if atom not in self._notes.atoms or literal.args or literal.negated or annots != self._annots:
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

    def go_back(self, notes: Notes, settled: Settled) -> None:
        """Hold other atoms, all of which have been forwarded, and of other beliefs without arguments these."""
        self._notes = notes
        self._awaited = set()
        self.p = self.watched = WatchedBeliefs(dict.fromkeys(notes.atoms, self._annots), notes, settled)

    def begins(self) -> bool:
        """Whether it is in the middle of nothing: it only looked again and again, or no plan of it pursues a goal."""
        if self.feedback:
            return False
        if self.spin is not None:
            return True
        waiting = [activity for _, activity in self.events if activity is not None]
        return not any(activity.below for activity in waiting) and not any(
            activity.below or activity.goal[0].is_goal for activity in self.intentions
        )
