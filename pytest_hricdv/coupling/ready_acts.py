"""Ready acts: acts that an agent is about to do, possibly several at a time."""

from __future__ import annotations

import heapq
from collections import OrderedDict
from collections.abc import Collection, Iterator, Set
from dataclasses import dataclass, field
from itertools import count
from operator import attrgetter

from pytest_hricdv.bdi import Structure
from pytest_hricdv.bdi.agent.intentions import Intention

_in_order = attrgetter("number")


@dataclass(eq=False)  # two intentions before the same act are two: to remove one has to find this one
class ReadyAct:
    """Something that the agent is ready to do, and does not do until it is told to.

    Args:
        text: the act, as AgentSpeak.
        literal: its literal; None for a plan's beginning.
        plan: the label of the plan that it belongs to.
        ready_s: when the agent became ready for it (s).
        acts: the numbers of the declared acts that it is, where acts are declared.
        number: counts what the agent has been ready for.
    """

    text: str
    literal: Structure | None
    plan: str
    ready_s: float
    intention: Intention = field(repr=False)
    acts: tuple[int, ...] = ()
    number: int = 0


# Ordered, because to remove the first and to find the next first takes constant time only then.
_Acts = OrderedDict[ReadyAct, None]


class _Kind:
    """The open acts that are the same declared ones: all of them, and by their text, in order."""

    def __init__(self) -> None:
        self.all: _Acts = OrderedDict()
        self.by_text: dict[str, _Acts] = {}

    def different(self) -> Iterator[ReadyAct]:
        """The first act of each text, in order."""
        yield next(iter(self.all))  # most often the one that is looked for
        yield from sorted((next(iter(acts)) for acts in self.by_text.values()), key=_in_order)[1:]


class ReadyActs(Collection[ReadyAct]):
    """The ready acts of an agent, in the order in which they became ready.

    Equal acts differ only in when they became ready, so an event looks only at the first of each sort, however many are
    open.
    """

    def __init__(self) -> None:
        self._acts: _Acts = OrderedDict()
        self._kinds: dict[tuple[int, ...], _Kind] = {}
        self._numbers = count()

    def __contains__(self, act: object) -> bool:
        """Whether the agent is ready for this act."""
        return act in self._acts

    def __iter__(self) -> Iterator[ReadyAct]:
        """All acts, in order."""
        return iter(self._acts)

    def __len__(self) -> int:
        """How many there are."""
        return len(self._acts)

    def add(self, act: ReadyAct) -> None:
        """The agent has become ready for an act."""
        act.number = next(self._numbers)
        kind = self._kinds.setdefault(act.acts, _Kind())
        for acts in (self._acts, kind.all, kind.by_text.setdefault(act.text, OrderedDict())):
            acts[act] = None

    def remove(self, act: ReadyAct) -> None:
        """The agent is not ready for an act any more."""
        kind = self._kinds[act.acts]
        for acts in (self._acts, kind.all, kind.by_text[act.text]):
            del acts[act]
        if not kind.by_text[act.text]:
            del kind.by_text[act.text]
        if not kind.all:
            del self._kinds[act.acts]

    def different(self, numbers: Set[int]) -> Iterator[ReadyAct]:
        """The acts that are one of these declared ones; of equal acts the first, in order."""
        kinds = [kind.different() for acts, kind in self._kinds.items() if any(number in numbers for number in acts)]
        return heapq.merge(*kinds, key=_in_order)

    def longest_ready(self) -> list[ReadyAct]:
        """The act that became ready first, for each group of equal declared acts; in order."""
        return sorted((next(iter(kind.all)) for kind in self._kinds.values()), key=_in_order)
