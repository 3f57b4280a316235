"""Runs tests on several processes, each in a fork of this one.

Each begins from the same state of this process, whatever ran before, so it does the same each time.
"""

from __future__ import annotations

import gc
import os
import threading
from collections import Counter, deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

from pytest_hricdv.execution.process_pool import KILLED, MAX_ATTEMPTS, Line, ProcessPool, Send
from pytest_hricdv.generate.concrete import ConcreteTest

T = TypeVar("T")


def may_fork() -> bool:
    """Whether this process can be copied: the system forks, and Python has no other thread here."""
    return hasattr(os, "fork") and threading.active_count() == 1


@dataclass(frozen=True)
class ForkRunner(Generic[T]):
    """See the module.

    Args:
        execute: runs a test.
        text: what is to be said of the test with a number, in one line: of its result, or, where it has none, of the
            problem; made in the process that ran it.
        processes: so many at a time.
        limit_s: of a run (s of wall time).
    """

    execute: Callable[[ConcreteTest], T]
    text: Callable[[int, T | None, str], str]
    processes: int
    limit_s: float

    def run(self, tests: Sequence[ConcreteTest]) -> Iterator[tuple[int, str]]:
        """Run tests; the number of each with what is said of it, as soon as it is known."""
        if not may_fork():
            yield from ((number, self._executed(number, test)) for number, test in enumerate(tests))
            return
        gc.freeze()  # a collection in a fork would copy all that the forks share
        try:
            yield from self._in_forks(tests)
        finally:
            gc.unfreeze()

    def _in_forks(self, tests: Sequence[ConcreteTest]) -> Iterator[tuple[int, str]]:
        def work(number: int, send: Send) -> None:
            send(self._executed(number, tests[number]))

        longest_first = sorted(range(len(tests)), key=lambda number: -len(tests[number].actions))  # all end together
        done, attempts, queue = set[int](), Counter[int](), deque(longest_first)
        for event in ProcessPool(work, self.processes, self.limit_s).run(queue):
            if isinstance(event, Line):
                done.add(event.item)
                yield event.item, event.text
                continue
            attempts[event.item] += 1
            if event.item not in done and event.problem == KILLED and attempts[event.item] < MAX_ATTEMPTS:
                queue.append(event.item)
            elif event.item not in done:
                problem = f"its process: {event.problem or 'ended without a result'}"
                yield event.item, self.text(event.item, None, problem)

    def _executed(self, number: int, test: ConcreteTest) -> str:
        try:
            return self.text(number, self.execute(test), "")
        except Exception as error:
            cause = error.__cause__ or error  # what a node raised says more than that it failed
            return self.text(number, None, f"{type(cause).__name__}: {cause}")
