"""What the watchdog takes for waiting."""

from __future__ import annotations

import _thread
import hashlib
import re
import sys
import threading

import pytest

from pytest_hricdv.runtime.watchdog import Hang, Watch, WatchState, _wants_now

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells what a thread is doing")

BLOCK = bytes(50_000_000)
"""Takes tens of ms to digest, without Python's lock."""


LOOKS = 20
MOST_LOOKS = 100_000
"""On a busy machine, the one that is to wait may get no processor to begin to wait for many looks."""


def looked_at_while(act: str) -> list[bool]:
    """What a thread sees of this one, the only other one, while this one computes, or waits."""
    seen: list[bool] = []
    begun, looked = threading.Event(), threading.Event()

    def look() -> None:
        own = str(threading.get_native_id())
        begun.wait()
        seen.extend(_wants_now(own) for _ in range(LOOKS))
        while act == "waits" and seen[-1] and len(seen) < MOST_LOOKS:
            seen.append(_wants_now(own))
        looked.set()

    _thread.start_new_thread(look, ())
    begun.set()
    if act == "waits":
        looked.wait()
    else:
        while not looked.is_set():
            hashlib.sha256(BLOCK)
    return seen


def test_who_computes_wants_a_processor_whether_it_gets_one_or_not() -> None:
    assert sum(looked_at_while("computes")) > 15  # between two blocks it may wait for Python's lock


def test_who_waits_wants_none() -> None:
    seen = looked_at_while("waits")  # the first looks may come before it waits
    assert not seen[-1]


def test_a_search_that_keeps_pythons_lock_is_ended() -> None:
    def end(hang: Hang, frame: object) -> None:
        raise TimeoutError(hang.kind)

    with Watch(lambda: WatchState(0, 60.0, may_work_s=1.0), end).watch(), pytest.raises(TimeoutError, match="works"):
        re.match("(a+)+$", "a" * 60 + "b")


@pytest.mark.parametrize("puts_back", [False, True])
def test_the_limit_of_recursion_is_as_before_whoever_puts_it_back(puts_back: bool) -> None:
    """The watchdog raises it, as its handler needs room; the session puts back what the code has changed, too."""

    def end(hang: Hang, frame: object) -> None:
        raise TimeoutError(hang.kind)

    before = sys.getrecursionlimit()
    with Watch(lambda: WatchState(0, 60.0, may_work_s=0.1), end).watch():
        with pytest.raises(TimeoutError, match="works"):
            re.match("(a+)+$", "a" * 60 + "b")
        assert sys.getrecursionlimit() > before
        if puts_back:
            sys.setrecursionlimit(before)
    assert sys.getrecursionlimit() == before
