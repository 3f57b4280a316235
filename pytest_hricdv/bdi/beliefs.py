"""An agent's belief base."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from pytest_hricdv.bdi.language.syntax import Rule
from pytest_hricdv.bdi.language.terms import Key, Structure, Term

Entry = Structure | Rule
Bucket = dict[tuple[Term, ...] | Rule, Entry]
"""The beliefs of one predicate by their arguments, and its rules, the oldest first."""

_EMPTY: Bucket = {}


class BeliefBase:
    """Beliefs with their sources, and rules, found by predicate; queries look at the newest first."""

    __slots__ = ("buckets", "held", "open", "version")

    def __init__(self) -> None:
        self.buckets: dict[Key, Bucket] = {}
        """The beliefs and rules of each predicate; for reading only."""
        self.held: set[Key] = set()
        """The predicates of which there is any belief or rule."""
        self.open: set[Key] = set()
        """The predicates that may have a rule, or a belief with variables: those have answers that are not looked up by
        arguments."""
        self.version = 0
        """Grows with every change."""

    def copy(self) -> BeliefBase:
        """An independent base with the same content: beliefs themselves are immutable."""
        other = BeliefBase()
        other.buckets = {key: dict(bucket) for key, bucket in self.buckets.items()}
        other.held = set(self.held)
        other.open = set(self.open)
        return other

    def bucket(self, key: Key) -> Bucket:
        """The beliefs and rules of a predicate."""
        return self.buckets.get(key, _EMPTY)

    def candidates(self, key: Key) -> Iterable[Entry]:
        """The beliefs and rules of a predicate in query order, safe against changes on the way."""
        bucket = self.buckets.get(key)
        return reversed(list(bucket.values())) if bucket else ()

    def add_rule(self, rule: Rule) -> None:
        """Add a rule."""
        self.buckets.setdefault(rule.head.key, {})[rule] = rule
        self.held.add(rule.head.key)
        self.open.add(rule.head.key)

    def add(self, belief: Structure) -> Structure | None:
        """Add a ground belief, or its annotations to the belief already held.

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
            self.held.add(key)
        elif isinstance(held, Structure):
            new = tuple(annot for annot in belief.annots if annot not in held.annots)
            if not new:
                return None
            bucket[args] = held.with_annotations(held.annots + new)
            belief = belief if len(new) == len(belief.annots) else belief.with_annotations(new)
        if not belief.ground:
            self.open.add(key)
        self.version += 1
        return belief

    def replace(self, belief: Structure) -> Structure | None:
        """Put a ground belief in the place of the only one of its predicate, if that has the same annotations.

        Returns:
            The belief that goes; None if nothing is done.
        """
        bucket = self.buckets.get(belief.key)
        if bucket is None or len(bucket) != 1 or not belief.ground:
            return None
        (held,) = bucket.values()
        if not isinstance(held, Structure) or held.annots != belief.annots:
            return None
        bucket.clear()
        bucket[belief.args] = belief
        self.version += 1
        return held

    def remove(self, belief: Structure) -> bool:
        """Remove the annotations given, sources among them; without any source left the belief goes.

        Returns:
            Whether anything changed. Nothing does if some annotation given is not held.
        """
        args = belief.args
        bucket = self.buckets.get(belief.key, _EMPTY)
        held = bucket.get(args)
        if not isinstance(held, Structure):
            return False
        if held.annots != belief.annots:
            if not all(annot in held.annots for annot in belief.annots):
                return False
            left = held.with_annotations(tuple(annot for annot in held.annots if annot not in belief.annots))
            if left.has_source():
                bucket[args] = left
                self.version += 1
                return True
        del bucket[args]
        if not bucket:
            self.held.discard(belief.key)
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

    def __iter__(self) -> Iterator[Entry]:
        for bucket in self.buckets.values():
            yield from bucket.values()
