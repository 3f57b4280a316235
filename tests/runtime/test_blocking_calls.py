"""Code that waits in real time, for what is not simulated, is ended with the place where it waits."""

from __future__ import annotations

import _thread
import contextlib
import multiprocessing
import os
import queue
import select
import signal
import socket
import threading
import time
from collections.abc import Callable

import pytest

from pytest_hricdv.runtime import Kernel, KernelError, NodeError
from pytest_hricdv.runtime.virtual.outside import guard_run

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that interrupt")


def _wait_after_1_s(kernel: Kernel, wait: Callable[[], object]) -> None:
    kernel.sleep(1.0)
    wait()


def waiting(wait: Callable[[], object]) -> str:
    """How a run ends in which a node waits."""
    kernel = Kernel(stuck_after_s=0.1)
    kernel.spawn("waiter", lambda: _wait_after_1_s(kernel, wait))
    with pytest.raises(NodeError) as raised:
        kernel.run(10.0)
    kernel.close()
    return str(raised.value)


def wait_for_nobody() -> None:
    ends = socket.socketpair()
    with ends[0], ends[1]:
        ends[0].recv(1)


@pytest.mark.parametrize("wait", [threading.Event().wait, lambda: time.sleep(30), wait_for_nobody])
def test_it_is_ended_with_the_place(wait: Callable[[], object]) -> None:
    began_s = time.monotonic()
    said = waiting(wait)
    assert "test_blocking_calls.py:" in said
    assert ": node waiter waits in real time" in said
    assert time.monotonic() - began_s < 30


def at_a_pipe() -> None:
    reading, writing = os.pipe()
    try:
        os.read(reading, 1)
    finally:
        os.close(reading)
        os.close(writing)


def at_a_lock() -> None:
    lock = threading.Lock()
    lock.acquire()
    lock.acquire()


def at_a_queue_in_c() -> None:
    waiting = queue.SimpleQueue[int]()
    waiting.get()


def at_another_processs_lock() -> None:
    semaphore = multiprocessing.Semaphore(0)
    semaphore.acquire()


@pytest.mark.parametrize(
    ("wait", "said", "advice"),
    [
        (at_a_pipe, "in os.read", "nothing outside of a run can be waited for"),
        (lambda: select.select([], [], [], 30), "in select.select", "nothing outside of a run can be waited for"),
        (wait_for_nobody, "in ends[0].recv", "nothing outside of a run can be waited for"),
        (at_another_processs_lock, "in semaphore.acquire", "nothing outside of a run can be waited for"),
        (at_a_lock, "in lock.acquire", 'with time=VirtualTime(apis=("threading",))'),
        (at_a_queue_in_c, "in waiting.get", 'with time=VirtualTime(apis=("threading",))'),
    ],
)
def test_a_function_in_c_is_named_as_it_is_called_with_what_to_do(
    wait: Callable[[], object], said: str, advice: str
) -> None:
    message = waiting(wait)
    assert f"waits in real time, {said}, which" in message
    assert advice in message


def refusing(wait: Callable[[], object]) -> str:
    """How a run ends in which a node waits, with what refuses it."""
    kernel = Kernel(stuck_after_s=30.0)
    kernel.spawn("waiter", lambda: _wait_after_1_s(kernel, wait))
    with guard_run(kernel), pytest.raises(NodeError) as raised:
        kernel.run(10.0)
    kernel.close()
    return str(raised.value)


@pytest.mark.parametrize(
    ("wait", "said"),
    [
        (lambda: signal.sigwait({signal.SIGUSR1}), "signal.sigwait"),  # nothing would interrupt it
        (lambda: signal.pause(), "signal.pause"),
        (lambda: signal.sigtimedwait({signal.SIGUSR1}, 30.0), "signal.sigtimedwait"),
        (lambda: os.system("exit 3"), "os.system"),
        (lambda: time.sleep(30), "time.sleep"),
        (lambda: multiprocessing.Event().wait(0.05), "multiprocessing.synchronize.SemLock.acquire"),
    ],
)
def test_waiting_for_a_signal_or_a_process_is_refused_at_once(wait: Callable[[], object], said: str) -> None:
    message = refusing(wait)
    place = f"test_blocking_calls.py:{wait.__code__.co_firstlineno}"
    assert f"{place}: node waiter waits in real time, in {said}," in message


def test_what_does_not_wait_and_what_is_no_node_is_let_through() -> None:
    ended: list[object] = []
    kernel = Kernel(stuck_after_s=30.0)
    kernel.spawn("polling", lambda: ended.append(signal.sigtimedwait(set(), 0)))
    with guard_run(kernel):
        assert os.system("exit 0") == 0
        assert kernel.run(10.0) == "idle"
    assert ended == [None]
    assert os.system("exit 0") == 0


def test_a_slow_world_is_no_wait() -> None:
    class World:
        def advance(self, target_us: int) -> int:
            time.sleep(0.3)  # each step is far from the limit, and together they are above it
            return min(target_us, kernel.now_us + 1000)

        def observe(self) -> None:
            pass

    kernel = Kernel(stuck_after_s=0.5)
    kernel.world = World()
    kernel.spawn("sleeper", lambda: kernel.sleep(0.004))
    assert kernel.run(0.004) in ("idle", "limit")


def test_who_catches_what_is_raised_is_left_where_it_is_and_the_other_nodes_end() -> None:
    ended: list[object] = []

    def stubborn() -> None:
        while True:
            with contextlib.suppress(BaseException):
                threading.Event().wait()

    def other() -> None:
        try:
            kernel.sleep(100.0)
        finally:
            ended.append("other")

    kernel = Kernel(stuck_after_s=0.1)
    kernel.spawn("other", other)
    kernel.spawn("stubborn", stubborn)
    with pytest.raises(NodeError, match=r"stubborn catches whatever is raised in it: .*waits in real time"):
        kernel.run(10.0)
    kernel.close()
    assert ended == ["other"]


def test_a_node_that_does_not_end_is_said_and_the_others_end() -> None:
    ended: list[object] = []

    def cleaning(name: str, clean: Callable[[], None]) -> None:
        try:
            kernel.sleep(100.0)
        finally:
            clean()
            ended.append(name)

    def never() -> None:
        while True:
            sum(range(1000))

    kernel = Kernel(stuck_after_s=0.1)
    kernel.spawn("first", lambda: cleaning("first", never))
    kernel.spawn("second", lambda: cleaning("second", lambda: None))
    assert kernel.run(10.0) == "limit"
    stuck = r"no time has passed for 0.1 s of work, at .*test_blocking_calls.py:\d+; in first"
    with pytest.raises(KernelError, match=stuck):
        kernel.close()
    assert ended == ["second"]


def test_no_thread_is_left() -> None:
    kernel = Kernel(stuck_after_s=10.0)
    kernel.spawn("a", lambda: kernel.sleep(1.0))
    before = signal.getsignal(signal.SIGVTALRM)
    threads = _thread._count()
    kernel.run(10.0)
    assert signal.getsignal(signal.SIGVTALRM) is before
    assert _thread._count() == threads


def test_a_second_of_simulated_time_may_not_take_for_ever() -> None:
    def polls() -> None:
        while True:
            kernel.sleep(1e-5)
            sum(range(10_000))

    kernel = Kernel(stuck_after_s=0.1)
    kernel.spawn("polling", polls)
    # Some of the time is the kernel's own, so that may be where it is ended, and no node is at work then.
    with pytest.raises(KernelError, match=r"a second of simulated time takes more than 1 s of work, now at .*"):
        kernel.run(10.0)
    kernel.close()
