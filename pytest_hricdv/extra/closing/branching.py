"""Tests with a common beginning, run as one tree: where they part, the process forks.

A fork copies a run as it stands: the stacks of its nodes, the world, the monitors and the coverage. So what tests have
in common is run once. They part where the person asks for the next action and theirs are different: all alternatives
but the last go to a forked process each, one after the other, while the parent waits; the last one is its own. A run
is a function of its test alone, so a test does in a tree what it does from the start.

Only for a process without other threads: a fork has none of them, and what they had locked stays locked.
"""

from __future__ import annotations

import mmap
import os
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import count
from typing import Generic, TypeVar

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.rng import canonical_json
from pytest_hricdv.run import Actions, Run

T = TypeVar("T")


@dataclass(frozen=True)
class Leaf(Generic[T]):
    """What came of one test of a tree.

    Args:
        number: of the test, from 0, in the order given.
        result: of its run; None if there is none.
        problem: why there is none, in a sentence; empty if there is one.
    """

    number: int
    result: T | None = None
    problem: str = ""


def may_fork() -> bool:
    """Whether this process can be copied: the system forks, and Python has no other thread here."""
    return hasattr(os, "fork") and threading.active_count() == 1


def trees(tests: Sequence[ConcreteTest]) -> list[list[int]]:
    """The numbers of the tests, those of a common beginning together; in the order of their first ones.

    Tests that part at their first action have nothing in common but their world: they are left to other processes.
    """
    groups: dict[str, list[int]] = {}
    for number, test in enumerate(tests):
        first = [[action.command, dict(action.parameters)] for action in test.actions[:1]]
        groups.setdefault(canonical_json([test.seed, dict(test.run), first]), []).append(number)
    return [*groups.values()]


class Tree(Generic[T]):
    """Runs tests; what they have in common at their beginning only once.

    Args:
        tests: of one seed and with the same parameters of the run.
        execute: runs a test, with its actions produced by the function.
        tell: called once for each test, in the process that ran it: it has to write to where all forks can.
        limit_s: a fork that does not part again and has not ended by then (s of wall time) is ended.

    Raises:
        ValueError: seeds or parameters of the run differ.
    """

    def __init__(
        self,
        tests: Sequence[ConcreteTest],
        execute: Callable[[ConcreteTest, Actions], T],
        tell: Callable[[Leaf[T]], None],
        limit_s: float,
    ) -> None:
        if len({canonical_json([test.seed, dict(test.run)]) for test in tests}) > 1:
            raise ValueError("tests of a tree: expected one seed, and the same parameters of the run")
        self._tests = tests
        self._execute = execute
        self._tell = tell
        self._limit_s = limit_s
        self._followed: list[int] = []
        self._reported: bytearray | mmap.mmap = bytearray(len(tests))

    def run(self, *, forking: bool) -> None:
        """Run all tests: with forks, or one after the other from the start. The same comes of both."""
        root = os.getpid()
        if forking and self._tests:
            self._reported = mmap.mmap(-1, len(self._tests))  # shared with all forks
        while left := [number for number in range(len(self._tests)) if not self._reported[number]]:
            self._followed = left if forking else left[:1]
            status = 1
            try:
                self._run_followed()
                status = 0
            finally:
                if os.getpid() != root:
                    os._exit(status)  # what called this goes on in the root only

    def _run_followed(self) -> None:
        """Run what this process follows to the end, and tell what came of it."""
        result, problem = None, ""
        try:
            result = self._execute(self._tests[self._followed[0]], self._actions)
        except Exception as error:
            cause = error.__cause__ or error  # what a node raised says more than that it failed
            problem = f"{type(cause).__name__}: {cause}"
        _pause_limit()
        # Others that would have parted after the end of this run, or that a testbench has taken as a whole, come next:
        # it knows which test it runs, so what it says of another one can differ.
        ran, *others = self._followed
        same = [number for number in others if self._tests[number].actions == self._tests[ran].actions]
        self._report([ran, *same], result, problem)

    def _report(self, numbers: Iterable[int], result: T | None, problem: str) -> None:
        for number in numbers:
            if not self._reported[number]:
                self._tell(Leaf(number, result, problem))
                self._reported[number] = 1

    def _actions(self, run: Run) -> Iterator[ConcreteAction]:
        for place in count():
            self._part(run, place)
            run.test = self._tests[self._followed[0]]
            if place == len(run.test.actions):
                return
            yield run.test.actions[place]

    def _part(self, run: Run, place: int) -> None:
        """Where the tests that this process follows have different actions, leave all but the last to forks."""
        alternatives: dict[str, list[int]] = {}
        for number in self._followed:
            actions = self._tests[number].actions[place : place + 1]
            content = canonical_json([[action.command, dict(action.parameters)] for action in actions])
            alternatives.setdefault(content, []).append(number)
        if not may_fork():  # the run has started a thread: the others are run from the start
            self._followed = next(iter(alternatives.values()))
            return
        *others, self._followed = alternatives.values()
        for alternative in others:
            with run.kernel.unwatched():
                is_fork = self._forked(alternative)
            if is_fork:
                self._followed = alternative
                return

    def _forked(self, alternative: Sequence[int]) -> bool:
        """Whether this is the fork for the alternative; its parent returns when the fork has ended."""
        left_s = _pause_limit()
        pid = os.fork()
        if pid == 0:
            signal.signal(signal.SIGALRM, signal.SIG_DFL)
            signal.setitimer(signal.ITIMER_REAL, self._limit_s)
            return True
        _, status = os.waitpid(pid, 0)
        if status:
            self._report(alternative, None, _problem(os.waitstatus_to_exitcode(status), self._limit_s))
        signal.setitimer(signal.ITIMER_REAL, left_s)
        return False


def _pause_limit() -> float:
    """Stop the timer that ends this process; how much of it is left (s), 0 if it does not run."""
    if not hasattr(signal, "setitimer"):
        return 0.0  # nor are there forks
    left_s, _ = signal.setitimer(signal.ITIMER_REAL, 0.0)
    return left_s


def _problem(code: int, limit_s: float) -> str:
    if code == -signal.SIGALRM:
        return f"its process: no end within {limit_s:g} s"
    return (
        f"its process: ended by {signal.Signals(-code).name}" if code < 0 else f"its process: ended with status {code}"
    )
