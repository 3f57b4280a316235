"""`Lanes`: hands the actions of each actor of a run to the node that enacts them, in the order that the test asks for.

`Run.actions` uses it, with `Turns`, which block an actor's node until its next action may begin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Generator, Iterable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from itertools import pairwise

from pytest_hricdv.generate.actors import PAUSE_S, TURN, TURN_WAIT_S, act_of, actor_of, interleave, stay_of
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.kernel import Node


class Turns:
    """The turns of actors: they decide which actions may begin.

    An action may begin when those that caused it are done, and all that precede it in the order have begun. The second
    condition has a time limit: the actor of a preceding action may itself be busy until this action has begun.

    Args:
        actors: who does each action.
        order: the numbers of the actions (from 0) as they are to begin.
        after: number of an action -> those that have to be done before it begins.
        patience_s: how long an actor waits for its turn at most, after what caused the action is done (s).
    """

    def __init__(
        self,
        kernel: Kernel,
        actors: Sequence[str],
        order: Sequence[int],
        after: Mapping[int, Sequence[int]],
        patience_s: float,
    ) -> None:
        self._kernel = kernel
        self._actors = actors
        self._before = {number: frozenset(order[:place]) for place, number in enumerate(order)}
        self._after = {number: frozenset(causes) for number, causes in after.items()}
        self._patience_s = patience_s
        self._settled: set[int] = set()
        """Actions that have begun, or never will."""
        self._done: set[int] = set()
        self._waiting: list[Node] = []

    def wait_for(self, number: int) -> None:
        """Block the calling node until the action may begin."""
        causes, before = self._after.get(number, frozenset()), self._before[number]
        while not causes <= self._done:
            self._wait(None)
        deadline_s = self._kernel.now_s + self._patience_s
        while not before <= self._settled and self._kernel.now_s < deadline_s:
            self._wait(deadline_s - self._kernel.now_s)

    def begin(self, number: int) -> None:
        """An action begins."""
        self._settled.add(number)
        self._wake()

    def end(self, number: int) -> None:
        """An action is done."""
        self._done.add(number)
        self._wake()

    def leave(self, actor: str) -> None:
        """Note that an actor does nothing more, so that nobody waits for its turns."""
        self._settled.update(number for number in self._before if self._actors[number] == actor)
        self._wake()

    def _wait(self, timeout_s: float | None) -> None:
        node = self._kernel.current()
        self._waiting.append(node)
        try:
            self._kernel.block(timeout_s)
        finally:
            if node in self._waiting:
                self._waiting.remove(node)

    def _wake(self) -> None:
        waiting, self._waiting = self._waiting, []
        for node in waiting:
            self._kernel.wake(node)


class Lanes:
    """The lanes of a test, and what of them has begun.

    A line without an actor, which is a disturbance, belongs to the line of an actor that follows it: it begins with
    that one. At the end of the text, it begins when the last action is done.

    Args:
        test: the lines say who acts.
        begin: called with number (from 0) and action when one begins.
    """

    def __init__(self, test: ConcreteTest, kernel: Kernel, begin: Callable[[int, ConcreteAction], None]) -> None:
        self._test = test
        self._kernel = kernel
        self._begin = begin
        lines = [action.command for action in test.actions]
        actors = [actor_of(line) for line in lines]
        self._lanes = {name: [number for number, actor in enumerate(actors) if actor == name] for name in test.actors}
        self._above, self._below = _disturbances(actors)
        turns = [action.parameters.get(TURN, 0.0) for action in test.actions]
        order = [number - 1 for number in interleave(lines, turns, test.after)]
        after = {number - 1: [cause - 1 for cause in causes] for number, causes in test.after.items()}
        self._turns = Turns(kernel, actors, order, after, test.run.get(TURN_WAIT_S, 0.0))
        self._left = set(order)
        self.taken: set[str] = set()
        """The actors whose actions a node takes."""

    @property
    def idle(self) -> tuple[str, ...]:
        """Actors whose actions were never requested."""
        return tuple(actor for actor in self._lanes if actor not in self.taken)

    def actions(self, actor: str) -> Generator[ConcreteAction]:
        """The actions of an actor, each when it may begin; without who does it, and without its turn.

        Whoever asks for the next one has done the last one.
        """
        self.taken.add(actor)
        return self._actions(actor)

    def _actions(self, actor: str) -> Generator[ConcreteAction]:
        turns = self._turns
        try:
            for number in self._lanes.get(actor, ()):
                turns.wait_for(number)
                self._pause(self._test.actions[number].parameters.get(PAUSE_S, 0.0))
                for disturbance in self._above.get(number, ()):
                    self._begin(disturbance, self._test.actions[disturbance])
                action = self._test.actions[number]
                self._begin(number, action)
                turns.begin(number)
                try:
                    yield without_schedule(action)
                finally:
                    self._left.discard(number)
                    turns.end(number)
            self._pause(self._test.run.get(stay_of(actor), 0.0))
            self._disturb_at_the_end()
        finally:
            turns.leave(actor)

    def _pause(self, duration_s: float) -> None:
        if duration_s > 0:
            self._kernel.sleep(duration_s)

    def _disturb_at_the_end(self) -> None:
        if not self._left:
            for disturbance in self._below:
                self._begin(disturbance, self._test.actions[disturbance])


def _disturbances(actors: list[str]) -> tuple[dict[int, list[int]], list[int]]:
    """Lines without an actor: the lines right above each line of an actor, and the lines at the end."""
    above: dict[int, list[int]] = {}
    pending: list[int] = []
    for number, actor in enumerate(actors):
        if not actor:
            pending.append(number)
        elif pending:
            above[number], pending = pending, []
    return above, pending


def without_schedule(action: ConcreteAction) -> ConcreteAction:
    """An action as its node gets it: without who does it, and without when."""
    parameters = {name: value for name, value in action.parameters.items() if name not in (TURN, PAUSE_S)}
    return replace(action, command=act_of(action.command), parameters=parameters)


@dataclass
class _Deed:
    """An act: since when its actor waited for it, when it began, and when it was done (us)."""

    act: str
    waited_us: int
    begun_us: int
    done_us: float = math.inf


class ActorTimes:
    """The times at which several actors waited and acted."""

    def __init__(self) -> None:
        self._deeds: dict[str, list[_Deed]] = {}

    def note_times(self, actor: str, actions: Generator[ConcreteAction], kernel: Kernel) -> Iterator[ConcreteAction]:
        """The actions of an actor, whose times are noted as its node takes them."""
        deeds = self._deeds.setdefault(actor, [])
        with closing(actions):
            while True:
                waited_us = kernel.now_us
                if deeds:
                    deeds[-1].done_us = waited_us
                action = next(actions, None)
                if action is None:
                    return
                deeds.append(_Deed(action.command, waited_us, kernel.now_us))
                yield action

    def overlap_bins(self, waiting: str, other: str) -> tuple[tuple[str, str], ...]:
        """See `Run.overlap_bins`."""
        pairs = [
            (deed.act, another.act)
            for deed in self._deeds.get(waiting, ())
            for another in self._deeds.get(other, ())
            if deed.waited_us < another.done_us and another.begun_us < deed.begun_us
        ]
        return tuple(dict.fromkeys(pairs))


def order_bins(taken: Iterable[ConcreteAction], one: str, other: str) -> tuple[tuple[str, str, str], ...]:
    """See `pytest_hricdv.run.Run.order_bins`; of the actions that have begun, in order."""
    acts = [(actor_of(action.command), act_of(action.command)) for action in taken]
    theirs = [act for act in acts if act[0] in (one, other)]
    met = [(first, second) for first, second in pairwise(theirs) if first[0] != second[0]]
    bins = [(first[1], second[1], one) if first[0] == one else (second[1], first[1], other) for first, second in met]
    return tuple(dict.fromkeys(bins))
