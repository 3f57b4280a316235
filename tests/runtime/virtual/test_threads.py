"""Threads in virtual time do what Python's own do."""

from __future__ import annotations

import concurrent.futures
import copy
import os
import queue
import subprocess
import sys
import threading
import time
import weakref
from collections.abc import Callable
from dataclasses import replace

import pytest

from pytest_hricdv.runtime import Kernel, NodeError
from pytest_hricdv.runtime.virtual import thread_pool, threads
from pytest_hricdv.runtime.virtual.outside import guard_run
from tests.runtime.virtual.programs import PROGRAMS, Library, Program

REAL = Library(threading, queue, concurrent.futures, time)
VIRTUAL = Library(*threads.MODULES[:2], *thread_pool.MODULES, time)


def in_virtual_time(body: Callable[[], object], limit_s: float = 1000.0) -> float:
    """Run a node; returns when it was over (s)."""
    kernel = Kernel()
    kernel.virtual = frozenset(("time", "threading"))

    def robot() -> None:
        body()
        kernel.stop("over")

    kernel.spawn("robot", robot)
    try:
        with guard_run(kernel):
            kernel.run(limit_s)
    finally:
        kernel.close()
    return kernel.now_s


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda program: program.__name__)
def test_as_with_real_threads(program: Program) -> None:
    virtually: list[object] = []
    in_virtual_time(lambda: program(VIRTUAL, virtually.append))
    # On a busy machine real threads are late: they are given more time until their order is the intended one.
    for tick_s in (0.02, 0.1, 0.5):
        really: list[object] = []
        program(replace(REAL, tick_s=tick_s), really.append)
        if really == virtually:
            break
    assert virtually == really


def test_two_nodes_have_threads_of_their_own() -> None:
    virtual, names = VIRTUAL.threading, []

    def body() -> None:
        thread = virtual.Thread(target=lambda: names.append(virtual.current_thread().name))
        thread.start()
        names.append((virtual.active_count(), thread.ident, virtual.get_ident(), virtual.current_thread().name))
        thread.join()

    kernel = Kernel()
    kernel.virtual = frozenset(("threading",))
    kernel.spawn("one", body)
    kernel.spawn("other", body)
    assert kernel.run(1.0) == "idle"
    assert names == [(2, 2, 1, "MainThread")] * 2 + ["Thread-1 (<lambda>)"] * 2


def test_the_world_releases_and_sets_but_does_not_wait() -> None:
    event, kernel = VIRTUAL.threading.Event(), Kernel()
    kernel.virtual = frozenset(("threading",))
    woken_s: list[float] = []

    class World:
        def advance(self, target_us: int) -> int:
            return min(target_us, kernel.now_us + 500_000)

        def observe(self) -> None:
            if kernel.now_us == 1_500_000:
                event.set()

    kernel.world = World()

    def robot() -> None:
        event.wait()
        woken_s.append(kernel.now_s)

    kernel.spawn("robot", robot)
    kernel.run(3.0)
    assert woken_s == [1.5]
    with pytest.raises(Exception, match=r"Event.wait would wait for ever: only a node may wait") as raised:
        VIRTUAL.threading.Event().wait()
    assert __file__ in str(raised.value)


def test_waiting_is_refused_where_it_is_not_asked_for() -> None:
    kernel = Kernel()
    kernel.virtual = frozenset(("time",))
    kernel.spawn("robot", VIRTUAL.queue.Queue().get)
    with pytest.raises(
        NodeError,
        match=r'in node robot is real time.*time=VirtualTime\(apis=\("time", "threading"\)\) to have threading',
    ):
        kernel.run(1.0)


def test_threads_that_are_over_and_waits_for_futures_that_are_not_are_not_kept() -> None:
    lib, names, kept = VIRTUAL, list[object](), list[int]()

    def body() -> None:
        pending = lib.futures.Future()
        for number in range(3_000):
            lib.threading.Timer(0.001, lambda: None).start()
            lib.futures.wait([pending], timeout=0.01)
            if number % 1_000 == 0:
                names.append([thread.name for thread in lib.threading.enumerate()])
        kept.extend((len(pending._done_callbacks), len(lib.threading.current_thread()._node.kernel.nodes)))

    in_virtual_time(body)
    assert names == [["MainThread"]] * 3
    assert kept[0] == 0
    assert kept[1] < 1_500


def test_what_a_callback_of_a_future_raises_is_lost() -> None:
    kernel = Kernel()
    kernel.virtual = frozenset(("time", "threading"))

    def note(future: object) -> None:
        raise ValueError("not noted")

    def robot() -> None:
        with VIRTUAL.futures.ThreadPoolExecutor(1) as pool:
            future = pool.submit(VIRTUAL.time.sleep, 0.5)
            future.add_done_callback(note)
            future.result()
        kernel.stop("over")

    kernel.spawn("robot", robot)
    try:
        kernel.run(10.0)
    finally:
        kernel.close()
    (said,) = kernel.lost_errors
    assert said.startswith(f"a callback of a future raised ValueError: not noted at {__file__}:")


def test_a_wait_that_a_library_does_in_a_thread_is_refused_with_the_line_that_began_it() -> None:
    """No line of the code under test is in the thread."""

    def by_pool() -> None:
        with VIRTUAL.futures.ThreadPoolExecutor(1) as pool:
            pool.submit(subprocess.run, [sys.executable, "-c", "import time; time.sleep(9)"]).result()

    def by_timer() -> None:
        VIRTUAL.threading.Timer(0.5, os.system, ["sleep 1"]).start()
        VIRTUAL.time.sleep(1.0)

    for body in (by_pool, by_timer):
        kernel = Kernel()
        kernel.virtual = frozenset(("time", "threading"))
        kernel.spawn("robot", body)
        with guard_run(kernel), pytest.raises(NodeError, match=rf"{__file__}:\d+: node robot: .* waits in real time"):
            kernel.run(10.0)


@pytest.mark.parametrize("kind", ["SimpleQueue", "local"])
def test_what_python_does_not_copy_is_not_copied(kind: str) -> None:
    module = VIRTUAL.queue if kind == "SimpleQueue" else VIRTUAL.threading

    def body() -> None:
        with pytest.raises(TypeError, match=rf"^cannot pickle '\w+\.\w*{kind}' object$"):
            copy.copy(getattr(module, kind)())

    in_virtual_time(body)


def test_nothing_keeps_a_thread_that_is_over() -> None:
    kept = list[object]()

    def body() -> None:
        thread = VIRTUAL.threading.Thread(target=VIRTUAL.time.sleep, args=(1.0,))
        thread.start()
        thread.join()
        over = weakref.ref(thread)
        del thread
        kept.append(over())

    in_virtual_time(body)
    assert kept == [None]


def test_an_error_of_a_call_without_a_line_names_the_one_that_gave_it_to_the_pool() -> None:
    kernel = Kernel()
    kernel.virtual = frozenset(("time", "threading"))

    def robot() -> None:
        with VIRTUAL.futures.ThreadPoolExecutor(1) as pool:
            pool.submit(int, "x")

    kernel.spawn("robot", robot)
    try:
        kernel.run(10.0)
    finally:
        kernel.close()
    (describe,) = kernel.unclaimed
    assert f" at {__file__}:" in describe()
