"""The search for a violation: from the tests that came nearest, downhill on the margin.

A (1+1) evolution strategy with the 1/5 success rule for the width of its steps (I. Rechenberg: Evolutionsstrategie,
1973) on each of a few starting tests; when one has not come nearer for a while, the next one has its turn.

Why not `hypothesis.target`: Hypothesis runs its own loop around a test function, draws from a stream that changes with
its version, and would have to be installed to run a suite. Here a seed means the same search for years.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from random import Random

from pytest_hricdv.generate.concrete import ConcreteTest, Concretization

from .budget import Budget, Ended, SpentError
from .mutate import mutated

_PATIENCE = 8
_WIDER, _NARROWER = 1.5, 1.5**-0.25  # one success in five keeps the width
_WIDTHS = (0.01, 0.5)


@dataclass(frozen=True)
class Reached:
    """How near a run came: its margin (None: nothing was compared), and whether it was a violation."""

    margin: float | None
    violated: bool

    @property
    def height(self) -> float:
        """What is climbed down."""
        if self.violated:
            return -math.inf
        return math.inf if self.margin is None else self.margin


@dataclass(frozen=True)
class Found:
    """The nearest that a search came: the test, how near, the start it came from, the runs it took (s of wall time)."""

    test: ConcreteTest
    reached: Reached
    start: int
    runs: int
    wall_s: float
    ended: Ended


@dataclass
class _Slot:
    place: int
    test: ConcreteTest
    reached: Reached
    width: float = 0.1
    stale: int = 0


def climb(
    starts: Sequence[tuple[ConcreteTest, Reached]],
    space: Concretization,
    run: Callable[[ConcreteTest], Reached],
    budget: Budget,
    random: Random,
) -> Found:
    """Search for a violation; ends at the first one.

    Args:
        starts: at least one test that was run, with how near it came.
        space: the ranges of the parameters.
        run: runs a test and says how near it came.
        budget: of runs and seconds.
        random: a private stream.

    Returns:
        The nearest test, one of the starts if none came nearer; also where Ctrl-C was pressed on the way.
    """
    slots = [_Slot(place, test, reached) for place, (test, reached) in enumerate(starts)]
    ended: Ended = "done"
    try:
        while not any(slot.reached.violated for slot in slots):
            budget.spend()  # also for a step that leads nowhere, so that it ends where nothing can be varied
            _step(min(slots, key=_turn), space, run, random)
    except SpentError as spent:
        ended = spent.ended
    except KeyboardInterrupt:
        ended = "interrupted"
    best = min(slots, key=lambda slot: (slot.reached.height, slot.place))
    return Found(best.test, best.reached, best.place, budget.used, budget.elapsed_s, ended)


def _turn(slot: _Slot) -> tuple[int, float, int]:
    """The nearest slot first, until it has been tried in vain for a while."""
    return slot.stale // _PATIENCE, slot.reached.height, slot.place


def _step(slot: _Slot, space: Concretization, run: Callable[[ConcreteTest], Reached], random: Random) -> None:
    test = mutated(slot.test, space, slot.width, random)
    reached = run(test) if test != slot.test else slot.reached
    nearer = reached.height < slot.reached.height
    if reached.height <= slot.reached.height:  # on a plateau it moves on, or it would never leave it
        slot.test, slot.reached = test, reached
    slot.stale = 0 if nearer else slot.stale + 1
    slot.width = min(max(slot.width * (_WIDER if nearer else _NARROWER), _WIDTHS[0]), _WIDTHS[1])
