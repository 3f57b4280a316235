"""Turns of the nodes that enact the actions of several actors, in a requested order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pytest_hricdv.runtime.kernel import Kernel, Node


class Turns:
    """The turns of actors: they decide which actions may begin.

    An action may begin when those that caused it are done, and all that precede it in the order have begun. Its actor
    waits only a while for the latter: an actor that comes first may be busy until this action has begun.

    Args:
        kernel: of the run.
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
