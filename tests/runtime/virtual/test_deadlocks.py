"""Deadlocks of nodes are named, with their lines."""

from __future__ import annotations

from pytest_hricdv.runtime import Kernel, Node
from pytest_hricdv.runtime.virtual.deadlocks import find_deadlocks
from pytest_hricdv.runtime.virtual.locks import Lock, RLock


def sentences(kernel: Kernel, *nodes: Node) -> list[str]:
    kernel.virtual = frozenset({"threading"})
    assert kernel.run(10.0) == "idle"
    found = [*find_deadlocks(nodes)]
    kernel.close()
    return found


def test_two_nodes_that_hold_what_the_other_one_wants() -> None:
    kernel, first, second = Kernel(), Lock(), RLock()

    def move() -> None:
        with first:
            kernel.sleep(1.0)
            with second:
                raise AssertionError

    def log() -> None:
        with second:
            kernel.sleep(1.0)
            with first:
                raise AssertionError

    (sentence,) = sentences(kernel, kernel.spawn("arm", move), kernel.spawn("log", log))
    assert sentence.startswith("deadlock: arm waits at ")
    assert "test_deadlocks.py:24 for a lock that log holds; log waits at " in sentence
    assert sentence.endswith("test_deadlocks.py:30 for a lock that arm holds")


def test_who_waits_for_a_lock_that_somebody_keeps_is_in_no_cycle() -> None:
    kernel, lock, other = Kernel(), Lock(), Lock()
    other.acquire()

    def keep() -> None:
        lock.acquire()
        kernel.block()

    def wait(which: Lock) -> None:
        which.acquire()

    nodes = [
        kernel.spawn("keeper", keep),
        kernel.spawn("a", lambda: wait(lock)),
        kernel.spawn("b", lambda: wait(other)),
    ]
    assert sentences(kernel, *nodes) == []


def test_a_lock_that_was_handed_over_belongs_to_who_got_it() -> None:
    kernel, lock = Kernel(), Lock()

    def work() -> None:
        with lock:
            kernel.sleep(1.0)

    nodes = [kernel.spawn(name, work) for name in "abc"]
    assert sentences(kernel, *nodes) == []
    assert lock.holder is None
