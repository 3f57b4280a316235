"""Tracking of what a run depends on: which of the forwarded atoms the agents query."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from pytest_hricdv.bdi.language.terms import Key, Structure
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, Bucket, Content, Entry
from pytest_hricdv.bdi.memo.forwarding import Forwarding


class Dependencies:
    """What the recorded part of a run depends on.

    Args:
        forwarding: how the atoms are forwarded.
        atoms: the atoms.
        arrived: whether they have been forwarded already.
    """

    def __init__(self, forwarding: Forwarding, atoms: frozenset[str], arrived: bool) -> None:
        self.forwarding = forwarding
        self.atoms = atoms
        self.certain = True
        """Whether other runs may rely on what is recorded."""
        self.missing = 0 if arrived else len(atoms) * len(forwarding.receivers)
        """Atoms that are still to arrive."""
        self.looks = int(arrived)
        """How often the steering agent has queried its percepts."""
        self.answers: dict[str, bool] = {}
        """The atoms queried in the current segment, in order, and whether they are among those forwarded."""

    @property
    def forwarded(self) -> bool:
        """Whether the steering agent has done its part."""
        return not self.missing and self.looks == 1

    def note_query(self, atom: str, answer: bool) -> None:
        """A receiver has queried whether it holds an atom that could only have been forwarded to it."""
        if self.missing:
            self.certain = False
        self.answers.setdefault(atom, answer)

    def note_look(self) -> None:
        """The steering agent has queried its percepts."""
        self.looks += 1
        if self.looks > 1:
            self.certain = False


class _TrackedBuckets(dict[Key, Bucket]):
    """Beliefs by predicate; a function is called before each read."""

    def __init__(self, buckets: dict[Key, Bucket], note_read: Callable[[Key], None]) -> None:
        super().__init__(buckets)
        self._note_read = note_read

    def get(self, key: Key, default: Any = None) -> Any:
        """The beliefs of a predicate."""
        self._note_read(key)
        return super().get(key, default)

    def peek(self, key: Key) -> Bucket | None:
        """The beliefs of a predicate, without calling the function."""
        return super().get(key)


class ReceiverBeliefs(BeliefBase):
    """The beliefs of a receiver: a query of an atom that could be forwarded is noted.

    Args:
        content: what it believes for certain; a predicate without entries is certainly not believed.
        dependencies: where to note queries.
        forwarded: the atoms that have been forwarded to it.
    """

    __slots__ = ("_dependencies", "_settled", "_tracked")

    def __init__(
        self, content: Iterable[tuple[Key, tuple[Entry, ...]]], dependencies: Dependencies, forwarded: Iterable[str]
    ) -> None:
        content = tuple(content)
        super().__init__(content)
        self._dependencies = dependencies
        self._settled = {key for key, _ in content}
        """The predicates that do not depend on the forwarded atoms."""
        for atom in forwarded:
            belief = dependencies.forwarding.belief(atom)
            if belief.key not in self._settled:
                self.buckets[belief.key] = {(): belief}
        self.buckets = self._tracked = _TrackedBuckets(self.buckets, self._note_read)

    def _note_read(self, key: Key) -> None:
        if self._depends(key):
            self._dependencies.note_query(key[1], self.holds(key))

    def _depends(self, key: Key) -> bool:
        negated, _, arity = key
        return not arity and not negated and key not in self._settled

    def holds(self, key: Key) -> bool:
        """Whether there is any belief of a predicate; this is not noted."""
        return bool(self._tracked.peek(key))

    def arrive(self, belief: Structure) -> None:
        """Add an atom that has been forwarded; this is not noted."""
        self.buckets[belief.key] = {(): belief}
        self.version += 1

    def add(self, belief: Structure) -> Structure | None:
        """Add a belief: from then on it is certain."""
        new = super().add(belief)
        if new is not None:
            self._settled.add(belief.key)
        return new

    def remove(self, belief: Structure) -> bool:
        """Remove a belief: from then on it is certain."""
        removed = super().remove(belief)
        if removed:
            self._settled.add(belief.key)
        return removed

    def content(self) -> Content:
        """What does not depend on the forwarded atoms."""
        held: dict[Key, tuple[Entry, ...]] = {key: () for key in self._settled if self._is_proposition(key)}
        for key, bucket in self.buckets.items():
            if bucket and not self._depends(key):
                held[key] = tuple(bucket.values())
        return tuple(held.items())

    @staticmethod
    def _is_proposition(key: Key) -> bool:
        return not key[0] and not key[2]


class SteeringBeliefs(BeliefBase):
    """The beliefs of the steering agent, after it has perceived: a query of the percepts to be forwarded is noted.

    Args:
        beliefs: what it believes.
        dependencies: where to note queries.
    """

    __slots__ = ("_dependencies",)

    def __init__(self, beliefs: BeliefBase, dependencies: Dependencies) -> None:
        super().__init__()
        self.open = beliefs.open
        self._dependencies = dependencies
        self.buckets = _TrackedBuckets(beliefs.buckets, self._note_read)

    def _note_read(self, key: Key) -> None:
        if key == self._dependencies.forwarding.key:
            self._dependencies.note_look()

    def content(self) -> Content:
        """What it believes besides the percepts to be forwarded."""
        return tuple([entry for entry in super().content() if entry[0] != self._dependencies.forwarding.key])
