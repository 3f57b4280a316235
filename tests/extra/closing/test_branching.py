"""Trees of tests: each test does in its tree what it does alone, and what goes wrong in one is an error of that one."""

from __future__ import annotations

import math
import os
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from pytest_hricdv.execution.process_pool import End, Line, ProcessPool, Send
from pytest_hricdv.extra.closing.branching import Leaf, Tree, may_fork, trees
from pytest_hricdv.generate.concrete import ConcreteTest
from pytest_hricdv.run import Actions
from tests.extra.closing import toy

COMMON = ("ask", "wait", "look")
PARTING = [
    toy.concrete(*COMMON, "reach", "say"),
    toy.concrete("ask", "leave"),
    toy.concrete(*COMMON, "pull", "say"),
    toy.concrete(*COMMON),
    toy.concrete(*COMMON, "pull", "look", "say"),
    toy.concrete("sit"),
    toy.concrete(*COMMON, "reach", "say"),
]


class Told(msgspec.Struct):
    """A leaf, and what its process had to say of itself."""

    number: int
    result: str | None
    problem: str
    pid: int
    descriptors: int
    executed: int


def tree(
    tests: list[ConcreteTest],
    *,
    forking: bool = True,
    limit_s: float = 30.0,
    execute: Callable[[ConcreteTest, Actions], str] = toy.execute,
) -> list[Told]:
    """The leaves of a tree in the order in which they came."""

    def work(item: str, send: Send) -> None:
        started: list[str] = []

        def counting(test: ConcreteTest, actions: Actions) -> str:
            started.append(test.id)
            return execute(test, actions)

        def tell(leaf: Leaf[str]) -> None:
            open_files = len([*Path("/proc/self/fd").iterdir()]) if Path("/proc/self/fd").is_dir() else 0
            told = Told(leaf.number, leaf.result, leaf.problem, os.getpid(), open_files, len(started))
            send(msgspec.json.encode(told).decode())

        Tree(tests, counting, tell, limit_s).run(forking=forking)
        with pytest.raises(ChildProcessError):
            os.waitpid(-1, os.WNOHANG)
        send(msgspec.json.encode(Told(-1, None, "", os.getpid(), 0, 0)).decode())

    told = [
        msgspec.json.decode(event.text, type=Told) if isinstance(event, Line) else event
        for event in ProcessPool(work, processes=1, silent_s=60.0).run(deque(["tree"]))
    ]
    assert told.pop() == End("tree", "")
    leaves = [each for each in told if isinstance(each, Told)]
    assert leaves.pop().number == -1, "the root came back after its last test, without a child left"
    return leaves


def results(leaves: list[Told]) -> list[str | None]:
    return [each.result or each.problem for each in sorted(leaves, key=lambda each: each.number)]


def test_each_test_of_a_tree_does_what_it_does_alone() -> None:
    leaves = tree(PARTING)
    assert results(leaves) == toy.texts(PARTING)
    assert {each.executed for each in leaves} == {1}, "nothing was run again from the start"
    assert len({each.pid for each in leaves}) == 6, "equal tests are one leaf"


def test_without_forks_the_same_comes_of_it() -> None:
    leaves = tree(PARTING, forking=False)
    assert results(leaves) == toy.texts(PARTING)
    assert {each.pid: each.executed for each in leaves} == {leaves[0].pid: 7}


def test_the_order_is_the_same_each_time_and_no_fork_keeps_what_others_opened() -> None:
    first, second = tree(PARTING), tree(PARTING)
    assert [each.number for each in first] == [each.number for each in second]
    assert len({each.descriptors for each in first}) == 1


def test_tests_that_would_part_after_the_end_of_a_run_are_run_one_by_one() -> None:
    tests = [toy.concrete("ask", "leave", "say"), toy.concrete("ask", "leave", "look"), toy.concrete("ask", "look")]
    leaves = tree(tests)
    assert results(leaves) == toy.texts(tests)
    assert [each.number for each in leaves] == [0, 2, 1]


@pytest.mark.parametrize(
    ("command", "problem"),
    [
        ("die", "its process: ended by SIGKILL"),
        ("exit", "its process: ended with status 3"),
        ("hang", "its process: no end within 0.3 s"),
        ("spin", "its process: no end within 0.3 s"),
        ("fail", "ValueError: tripped over the cable"),
        ("quit", "SystemExit: "),
    ],
)
def test_what_goes_wrong_in_a_leaf_is_an_error_of_that_leaf_only(command: str, problem: str) -> None:
    tests = [
        toy.concrete(*COMMON, command, "say"),
        toy.concrete(*COMMON, command, "look"),
        toy.concrete(*COMMON, "reach"),
        toy.concrete(*COMMON, "pull"),
    ]
    leaves = tree(tests, limit_s=0.3)
    assert results(leaves) == [problem, problem, *toy.texts(tests[2:])]


def test_a_fork_may_work_on_for_its_time_however_long_its_own_forks_took() -> None:
    tests = [
        toy.concrete("ask", "wait", "hang"),
        toy.concrete("ask", "wait", "look", "hang"),
        toy.concrete("ask", "wait", "look", "say"),
        toy.concrete("sit"),
    ]
    assert results(tree(tests, limit_s=0.4)) == [*["its process: no end within 0.4 s"] * 2, *toy.texts(tests[2:])]


def test_a_testbench_that_takes_tests_as_a_whole_runs_each_from_the_start() -> None:
    leaves = tree(PARTING, execute=toy.execute_whole)
    assert results(leaves) == toy.texts(PARTING)
    assert len({each.pid for each in leaves}) == 1


def test_once_a_run_has_a_thread_its_process_is_not_copied() -> None:
    tests = [
        toy.concrete("ask", "thread", "say"),
        toy.concrete("ask", "thread", "look"),
        toy.concrete("ask", "look", "say"),
        toy.concrete("ask", "look", "sit"),
    ]
    leaves = tree(tests)
    assert results(leaves) == results(tree(tests, forking=False))
    first, second, third, fourth = (each.pid for each in sorted(leaves, key=lambda each: each.number))
    assert (second, len({first, third, fourth})) == (fourth, 3), "the second one is run from the start"


def test_the_watchdog_of_the_kernel_holds_in_forks_too() -> None:
    def execute(test: ConcreteTest, actions: Actions) -> str:
        return toy.execute(test, actions, stuck_after_s=0.1)

    spins, looks = toy.concrete("ask", "spin"), toy.concrete("ask", "look")
    first, second = results(tree([spins, looks], execute=execute))
    assert first is not None
    assert "no time has passed for 0.1 s of work" in first
    assert [second] == toy.texts([looks])


def test_tests_with_a_common_beginning_make_a_tree() -> None:
    ask, other_seed = toy.concrete("ask", "say"), toy.concrete("ask", "say", seed=2)
    other_run = replace(ask, run={"outage_turn": 1.0})
    other_value = replace(ask, actions=(replace(ask.actions[0], parameters={"takes_s": 9.0}), *ask.actions[1:]))
    tests = [ask, toy.concrete("sit"), other_seed, toy.concrete("ask", "look"), other_run, other_value, toy.concrete()]
    assert trees(tests) == [[0, 3], [1], [2], [4], [5], [6]]


def test_tests_of_one_tree_have_one_seed() -> None:
    with pytest.raises(ValueError, match="expected one seed"):
        Tree([toy.concrete("ask"), toy.concrete("ask", seed=2)], toy.execute, print, math.inf)


def test_a_process_with_another_thread_is_not_copied(monkeypatch: pytest.MonkeyPatch) -> None:
    assert may_fork()
    done = threading.Event()
    other = threading.Thread(target=done.wait)
    other.start()
    try:
        assert not may_fork()
    finally:
        done.set()
        other.join()
    monkeypatch.delattr(os, "fork")
    assert not may_fork()
