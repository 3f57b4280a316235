"""Code that waits in real time, for what is not simulated, is ended with the place where it waits."""

from __future__ import annotations

import signal
import socket
import threading
import time
from collections.abc import Callable

import pytest

from pytest_hricdv.runtime import Kernel, NodeError

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no timers that interrupt")


def waiting(wait: Callable[[], object]) -> str:
    """How a run ends in which a node waits."""
    kernel = Kernel(stuck_after_s=0.1)
    kernel.spawn("waiter", lambda: (kernel.sleep(1.0), wait()))
    with pytest.raises(NodeError) as raised:
        kernel.run(10.0)
    kernel.close()
    return str(raised.value)


def wait_for_nobody() -> None:
    receiver, other = socket.socketpair()
    with receiver, other:
        receiver.recv(1)


@pytest.mark.parametrize("wait", [threading.Event().wait, lambda: time.sleep(30), wait_for_nobody])
def test_it_is_ended_with_the_place(wait: Callable[[], object]) -> None:
    began_s = time.monotonic()
    said = waiting(wait)
    assert "no time has passed for 0.2 s of real time, at " in said
    assert "such as a lock, a socket or another thread; in waiter" in said
    assert time.monotonic() - began_s < 30


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


def test_who_has_a_use_for_the_alarm_keeps_it() -> None:
    def mine(number: int, frame: object) -> None:
        raise AssertionError

    before = signal.signal(signal.SIGALRM, mine)
    try:
        kernel = Kernel(stuck_after_s=0.05)
        kernel.spawn("waiter", lambda: time.sleep(0.3))
        assert kernel.run(10.0) == "idle"
        assert signal.getsignal(signal.SIGALRM) is mine
    finally:
        signal.signal(signal.SIGALRM, before)


def test_the_alarm_is_given_back() -> None:
    kernel = Kernel(stuck_after_s=10.0)
    kernel.spawn("a", lambda: kernel.sleep(1.0))
    kernel.run(10.0)
    assert signal.getsignal(signal.SIGALRM) is signal.SIG_DFL
    assert signal.getitimer(signal.ITIMER_REAL) == (0.0, 0.0)
