"""Late beliefs: groups of beliefs that are decided when the agent first queries one of them."""

from __future__ import annotations

from collections.abc import Callable

from pytest_hricdv.bdi.language.terms import Key, Structure, source
from pytest_hricdv.bdi.logic.beliefs import BeliefBase, TrackedBuckets
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.online.chooser import NONE

Choose = Callable[[str, tuple[str, ...]], str]
"""Chooses one of the options for a group."""


class LateBeliefs:
    """The groups of a space that are open, in one run.

    A group is open as long as the agent believes none of it but a default belief; it is decided when the agent looks
    one of its beliefs up, at most once until `reopen`. In a group without a default belief, none may be chosen.

    Args:
        space: the groups.
        steering: the name of the agent that gives the beliefs.
        choose: decides.
        believe: the agent believes a literal from now on.
        disbelieve: the agent does not believe a literal any more.
    """

    def __init__(
        self,
        space: BeliefSpace,
        steering: str,
        choose: Choose,
        believe: Callable[[Structure], None],
        disbelieve: Callable[[Structure], None],
    ) -> None:
        self._space = space
        self._source = source(steering)
        self._choose, self._believe, self._disbelieve = choose, believe, disbelieve
        self._group_of: dict[Key, str] = {
            _atom(belief).key: name for name, group in space.groups.items() for belief in group
        }
        self._decided: set[str] = set()
        self._buckets: list[TrackedBuckets] = []

    def track(self, beliefs: BeliefBase) -> None:
        """Notice lookups in the belief base of an agent; of several, whoever looks first decides for all."""
        beliefs.buckets = buckets = TrackedBuckets(beliefs.buckets, self._look_up)
        self._buckets.append(buckets)

    def reopen(self) -> None:
        """Groups may be decided anew."""
        self._decided.clear()

    def _look_up(self, key: Key) -> None:
        group = self._group_of.get(key)
        if group is None or group in self._decided:
            return
        self._decided.add(group)  # before it is decided: to believe something looks the group up again
        members = self._space.groups[group]
        default_beliefs = [belief for belief in members if belief in self._space.default_beliefs]
        if any(self._is_held(belief) for belief in members if belief not in default_beliefs):
            return
        chosen = self._choose(group, members if default_beliefs else (NONE, *members))
        if chosen == NONE or self._is_held(chosen):
            return
        for belief in default_beliefs:
            if self._is_held(belief):
                self._disbelieve(self._belief(belief))
        self._believe(self._belief(chosen))

    def _is_held(self, belief: str) -> bool:
        key = _atom(belief).key
        return any(buckets.peek(key) for buckets in self._buckets)

    def _belief(self, belief: str) -> Structure:
        return Structure(belief, (), (self._source,))


def _atom(belief: str) -> Structure:
    return Structure(belief)
