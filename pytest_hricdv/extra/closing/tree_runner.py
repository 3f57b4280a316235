"""Runs tests on several processes, those with a common beginning as one tree, or each from the start.

Each begins in a fork from the same state of this process, whatever ran before, so it does the same each time.
"""

from __future__ import annotations

import gc
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

from pytest_hricdv.execution.process_pool import Line, ProcessPool, Send
from pytest_hricdv.extra.closing.branching import Leaf, Tree, may_fork, trees
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.run import Actions

T = TypeVar("T")

PATIENCE = 2.0
"""A process is ended after so many times the limit of a fork: only then is it sure that the fork itself was not.
Chosen: the least whole number that leaves the fork time to be ended first."""


@dataclass(frozen=True)
class TreeRunner(Generic[T]):
    """See the module.

    Args:
        execute: runs a test, with its actions produced by the function.
        text: what is told of a test, in one line; made in the process that ran it.
        processes: so many at a time.
        limit_s: of a run (s of wall time).
    """

    execute: Callable[[ConcreteTest, Actions], T]
    text: Callable[[Leaf[T]], str]
    processes: int
    limit_s: float

    def run(self, tests: Sequence[ConcreteTest], *, from_the_start: bool = False) -> Iterator[tuple[int, str]]:
        """Run tests; the number of each with what is told of it, as soon as it is known.

        Args:
            from_the_start: each test is run alone, whatever it has in common with others.
        """
        if not may_fork():
            yield from self._here(tests)
            return
        gc.freeze()  # a collection in a fork would copy all that the forks share
        groups = [[number] for number in range(len(tests))] if from_the_start else trees(tests)
        groups.sort(key=lambda group: -sum(len(tests[number].actions) for number in group))  # so that all end together
        try:
            yield from self._in_forks(tests, groups)
        finally:
            gc.unfreeze()

    def _here(self, tests: Sequence[ConcreteTest]) -> Iterator[tuple[int, str]]:
        for number, test in enumerate(tests):
            leaves: list[Leaf[T]] = []
            Tree([test], self.execute, leaves.append, self.limit_s).run(forking=False)
            yield number, self.text(replace(leaves[0], number=number))

    def _in_forks(self, tests: Sequence[ConcreteTest], groups: list[list[int]]) -> Iterator[tuple[int, str]]:
        def work(group: list[int], send: Send) -> None:
            def tell(leaf: Leaf[T]) -> None:
                leaf = replace(leaf, number=group[leaf.number])
                send(f"{leaf.number} {self.text(leaf)}")

            Tree([tests[number] for number in group], self.execute, tell, self.limit_s).run(forking=True)

        reported: set[int] = set()
        for event in ProcessPool(work, self.processes, PATIENCE * self.limit_s).run(deque(groups)):
            if isinstance(event, Line):
                number, _, text = event.text.partition(" ")
                reported.add(int(number))
                yield int(number), text
            else:
                left = (number for number in event.item if number not in reported)
                problem = f"its process: {event.problem or 'ended without a result'}"
                yield from ((number, self.text(Leaf(number, None, problem))) for number in left)
