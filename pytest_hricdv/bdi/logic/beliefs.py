"""`BeliefBase`: an agent's beliefs and rules. Percepts, messages and plans change it; contexts and tests query it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

from pytest_hricdv.bdi.language.limits import ITEMS, spend
from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import Key, Structure, Term

Entry = Structure | Rule
Bucket = dict[tuple[Term, ...] | Rule, Entry]
"""The beliefs of one predicate by their arguments, and its rules, the oldest first."""
Content = tuple[tuple[Key, tuple[Entry, ...]], ...]
"""The beliefs and rules of each predicate, the oldest first."""

_EMPTY: Bucket = {}


class BeliefBase:
    """Beliefs with their sources, and rules, indexed by predicate; queries try the newest first.

    Args:
        content: the beliefs and rules at the beginning.
    """

    __slots__ = ("buckets", "open", "version")

    def __init__(self, content: Iterable[tuple[Key, tuple[Entry, ...]]] = ()) -> None:
        self.buckets: dict[Key, Bucket] = {key: _bucket(entries) for key, entries in content}
        """The beliefs and rules of each predicate; read with ``get`` only, and never changed from outside."""
        self.open: set[Key] = {key for key, bucket in self.buckets.items() if not all(map(_is_ground, bucket.values()))}
        """The predicates that may have a rule, or a belief with variables: a lookup by arguments is not enough then."""
        self.version = 0
        """Grows with every change."""

    def bucket(self, key: Key) -> Bucket:
        """The beliefs and rules of a predicate."""
        return self.buckets.get(key, _EMPTY)

    def candidates(self, key: Key) -> Iterable[Entry]:
        """The beliefs and rules of a predicate in query order; the base may be changed while iterating."""
        bucket = self.buckets.get(key)
        if not bucket:
            return ()
        spend(len(bucket) // ITEMS)
        return reversed(list(bucket.values()))

    def content(self) -> Content:
        """The beliefs and rules as a value, from which an equal base can be made."""
        return tuple([(key, tuple(bucket.values())) for key, bucket in self.buckets.items() if bucket])

    def add_rule(self, rule: Rule) -> None:
        """Add a rule."""
        self.buckets.setdefault(rule.head.key, {})[rule] = rule
        self.open.add(rule.head.key)
        self.version += 1

    def remove_rule(self, rule: Rule) -> None:
        """Remove a rule, if it is there."""
        if self.bucket(rule.head.key).pop(rule, None) is not None:
            self.version += 1

    def add(self, belief: Structure) -> Structure | None:
        """Add a belief, or its annotations to the belief already held.

        Returns:
            What is new: the belief, or the belief with those of its annotations that were not held; None
            if nothing is, as when a belief is added again from the same source.
        """
        key, args = belief.key, belief.args
        bucket = self.buckets.get(key)
        if bucket is None:
            bucket = self.buckets[key] = {}
        held = bucket.get(args)
        if held is None:
            bucket[args] = belief
        elif isinstance(held, Structure):
            new = tuple(annot for annot in belief.annots if annot not in held.annots)
            if not new:
                return None
            # Keep its old place: a belief that another source confirms does not become newer.
            bucket[args] = held.with_annotations(held.annots + new)
            belief = belief if len(new) == len(belief.annots) else belief.with_annotations(new)
        if not belief.ground:
            self.open.add(key)
        self.version += 1
        return belief

    def find_last(self, belief: Structure) -> None:
        """Let queries find a belief that is held after the others of its predicate."""
        bucket = self.buckets[belief.key]
        held = bucket.pop(belief.args)
        rest = dict(bucket)
        bucket.clear()  # the same object: others may hold it
        bucket[belief.args] = held
        bucket.update(rest)
        spend(len(bucket) // ITEMS)
        self.version += 1

    def remove(self, belief: Structure) -> bool:
        """Remove the given annotations, sources among them; a belief without any source left is removed.

        Returns:
            Whether anything changed. Nothing does if some given annotation is not held.
        """
        args = belief.args
        bucket = self.buckets.get(belief.key)
        held = bucket.get(args) if bucket else None
        if bucket is None or not isinstance(held, Structure):
            return False
        if held.annots != belief.annots:
            if not all(annot in held.annots for annot in belief.annots):
                return False
            left = held.with_annotations(tuple(annot for annot in held.annots if annot not in belief.annots))
            # Nobody believes a belief without a source, whatever other annotations it has.
            if left.has_source():
                bucket[args] = left
                self.version += 1
                return True
        del bucket[args]
        self.version += 1
        return True

    def with_annotation(self, annot: Term) -> list[Structure]:
        """The beliefs held with an annotation, such as ``source(percept)``, the oldest first."""
        return [
            entry
            for bucket in self.buckets.values()
            for entry in bucket.values()
            if isinstance(entry, Structure) and annot in entry.annots
        ]


def _bucket(entries: tuple[Entry, ...]) -> Bucket:
    return {entry.args if isinstance(entry, Structure) else entry: entry for entry in entries}


def _is_ground(entry: Entry) -> bool:
    return isinstance(entry, Structure) and entry.ground


class TrackedBuckets(dict[Key, Bucket]):
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
