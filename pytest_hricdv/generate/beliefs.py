"""The belief space: all beliefs that the steering agent can be given, in groups."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.suggestion import nearest

_ATOM = re.compile(r"[a-z]\w*\Z", re.ASCII)
START = "start"


@dataclass(frozen=True)
class BeliefSpace:
    """All beliefs that belief subsets consist of.

    Args:
        start: the beliefs that begin an interaction; every subset that a method draws has one of them.
        groups: the other beliefs, by the name of their group; a balanced subset has one of each group.
        naming: groups whose chosen belief appears in a test's id next to the start belief.
        neutral: beliefs that mean "none of this group", as `not_bored` does: the model need not mention them.

    Raises:
        GenerateError: no start belief, an empty group, a belief listed twice, a belief that is no AgentSpeak atom,
            a name in `naming` that is no group, or one in `neutral` that is no belief of the space.
    """

    start: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]] = field(hash=False)
    naming: tuple[str, ...] = ()
    neutral: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "start", tuple(self.start))
        object.__setattr__(self, "groups", {name: tuple(group) for name, group in self.groups.items()})
        object.__setattr__(self, "naming", tuple(self.naming))
        object.__setattr__(self, "neutral", tuple(self.neutral))
        if START in self.groups:
            raise GenerateError(f"group {START!r}: the start beliefs have this name already; expected another one")
        group_of: dict[str, str] = {}
        for name, group in {START: self.start, **self.groups}.items():
            if not group:
                raise GenerateError(f"group {name!r} of beliefs is empty; expected at least one belief")
            for belief in group:
                _add_belief(belief, name, group_of)
        for name in self.naming:
            if name not in self.groups:
                raise GenerateError(f"naming group {name!r} is no group of this space{nearest(name, self.groups)}")
        for belief in self.neutral:
            if belief not in group_of:
                raise GenerateError(f"neutral belief {belief!r} is not in the belief space{nearest(belief, group_of)}")

    @property
    def beliefs(self) -> tuple[str, ...]:
        """Every belief, in declared order: start beliefs first, then group by group."""
        return (*self.start, *self.others)

    @property
    def others(self) -> tuple[str, ...]:
        """The beliefs outside the start group, in declared order."""
        return tuple(belief for group in self.groups.values() for belief in group)

    @cached_property
    def bits(self) -> dict[str, int]:
        """Belief -> its bit in a set of beliefs that is kept as a number."""
        return {belief: 1 << place for place, belief in enumerate(self.beliefs)}

    @cached_property
    def _rank(self) -> dict[str, int]:
        return {belief: rank for rank, belief in enumerate(self.beliefs)}

    def subset(self, beliefs: Iterable[str]) -> tuple[str, ...]:
        """The subset in declared order, so that each set of beliefs has exactly one run of the model.

        Raises:
            GenerateError: a belief is not of this space, or is given twice.
        """
        rank = self._rank
        given = list(beliefs)
        for belief in given:
            if belief not in rank:
                raise GenerateError(f"belief {belief!r} is not in the belief space{nearest(belief, rank)}")
        if len(set(given)) != len(given):
            twice = sorted({belief for belief in given if given.count(belief) > 1})
            raise GenerateError(f"belief {twice[0]!r} is given twice in one subset")
        return tuple(sorted(given, key=rank.__getitem__))

    def target(self, beliefs: Iterable[str]) -> str:
        """A subset in a few words: its start belief and its beliefs of the naming groups, as in `leg1-bored`."""
        subset = self.subset(beliefs)
        starts = [belief for belief in subset if belief in self.start] or ["no-start"]
        shown = {belief for name in self.naming for belief in self.groups[name]}
        return "-".join([*starts, *(belief for belief in subset if belief in shown)])


def _add_belief(belief: str, group: str, group_of: dict[str, str]) -> None:
    """Note the belief's group. Raises GenerateError if the belief is malformed or already in a group."""
    if not _ATOM.match(belief):
        raise GenerateError(
            f"group {group!r}: {belief!r} is no belief; expected an AgentSpeak atom: a lower-case letter, then "
            "letters, digits or underscores"
        )
    if belief in group_of:
        first = group_of[belief]
        raise GenerateError(f"belief {belief!r} is in group {first!r} and in group {group!r}; expected it once")
    group_of[belief] = group
