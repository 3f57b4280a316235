"""Signals that end a session: SIGTERM is handled like Ctrl-C, and neither interrupts the writing of the report.

SIGHUP, which a closed terminal sends, is handled like SIGTERM, and so are other signals that end Python by default,
such as those of batch systems whose time is up. A session has one `Signals`. It ends the session within 5 s, whatever
the code under test does:

1. SIGTERM raises `Termination` in the main thread, and a node that catches it is abandoned.
2. If the process is still stuck, as in a testbench that catches everything, the report is made from the journal
   (`early_end`), and the process ends.

If the main thread is in C code that does not return, Python calls no handler; a thread then notices the signal by
Python's wake-up descriptor.
"""

from __future__ import annotations

import _thread
import math
import os
import re
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

from pytest_hricdv.runtime.kernel import current_node

LETS_GO_WITHIN_S = 2.0
"""How long code may continue after SIGTERM (s), of the five seconds within which a session ends. The rest is for the
report; Docker kills 10 s after SIGTERM."""

WORKERS_END_WITHIN_S = 0.5
"""How long workers of xdist may take to end after SIGTERM before they are killed (s), of the same five seconds. They
have already sent their results."""

REBUILT_WITHIN_S = 60.0
"""How long making the report from the journal may take (s): enough for 30,000 tests, since 1,000 take 2 s."""

LOOKS_EACH_S = LETS_GO_WITHIN_S / 4
"""Interval (s) of checks whether code has ended after SIGTERM, and whether the parent process still exists."""

ENDING_WITHIN_S = 10.0
"""How long pytest and plugins may take to end the session, besides the report (s): xdist waits as long for workers."""

AGAIN_S = 1.0
"""A second signal within this time (s) interrupts nothing: it would cut off what the first one started."""

_ENDING = {
    getattr(signal, name, signal.SIGTERM) for name in ("SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGUSR2", "SIGXCPU")
}
"""The signals that end the session."""

_REPLACED: dict[signal.Signals, Any] = {
    signal.SIGINT: signal.default_int_handler,
    **dict.fromkeys(sorted(_ENDING), signal.SIG_DFL),
}
"""The handlers that are replaced; where somebody else has set another one, this stays: `nohup` ignores SIGHUP."""


class Termination(KeyboardInterrupt):
    """SIGTERM came; pytest and its plugins treat this as Ctrl-C."""


class Signals:
    """Handles both signals in a session, from before its suites are generated to its report.

    `pending` says that one came while none was let through. `terminated` says that SIGTERM came. `interrupted` says
    that a part ended early and continued with what was reached.

    Args:
        terminating: called at SIGTERM, once, before it is raised.
        stuck: called in another thread when SIGTERM had no effect; it ends the process.
    """

    def __init__(
        self, terminating: Callable[[], None] = lambda: None, stuck: Callable[[], None] = lambda: None
    ) -> None:
        self.pending = False
        self.terminated = False
        self.interrupted = False
        self._terminating = terminating
        self._stuck = stuck
        self._is_heard = self._asks = False
        self._before: dict[signal.Signals, Callable[[int, FrameType | None], Any] | int | None] = {}
        self._listening = ExitStack()
        self._insists = False
        self._deferring = False
        self._holding = False
        self._raised_s = -math.inf
        self._let_go_s: float | None = None
        """Since when nothing runs that SIGTERM should end (by `time.monotonic`); None: something does."""

    def begin(self) -> None:
        """Make signals raise from now on. Without effect if they do already: the first one counts."""
        if self._before or threading.current_thread() is not threading.main_thread():
            return  # in another thread Python cannot set handlers
        self._before = {
            number: handler
            for number, handler in _REPLACED.items()
            if signal.getsignal(number) is handler and (handler is not signal.SIG_DFL or not _is_caught_in_c(number))
        }
        for number in self._before:
            signal.signal(number, self._receive)
        if signal.SIGTERM in self._before:
            self._listening.enter_context(_listen(self._hear))

    def end(self) -> None:
        """The handlers are as they were."""
        self._holding = False
        self._listening.close()
        before, self._before = self._before, {}
        for number, handler in before.items():
            signal.signal(number, handler)

    def hold(self) -> None:
        """Make signals only set `pending` until `released`: the report lacks a new result."""
        self._holding = self._deferring = True

    def release(self) -> AbstractContextManager[None]:
        """Make signals raise within the block, including a held one: from now on the results can be reported."""
        self._holding = False
        return self.let_through()

    def let_go(self) -> None:
        """Note that the error of a signal has left everything that should end: SIGTERM no longer interrupts the
        following work.

        On a busy machine that takes longer than the time after which SIGTERM is raised again.
        """
        self._let_go_s = time.monotonic()

    @contextmanager
    def defer(self, deferring: bool = True) -> Iterator[None]:
        """Within: signals only set `pending`; or, where `deferring` is false, they raise again, also one that is
        pending.
        """
        outside, is_ending = self._deferring, self._let_go_s is not None
        try:
            try:
                self._deferring, self._let_go_s = deferring, None
                if not deferring:
                    self._raise_pending()
                yield
            finally:
                self._deferring = outside or self._holding
        except KeyboardInterrupt:  # it may have been raised in the line above
            self._deferring = outside or self._holding
            raise
        finally:
            if is_ending:
                self.let_go()

    def let_through(self) -> AbstractContextManager[None]:
        """Within: signals raise."""
        return self.defer(False)

    def _raise_pending(self) -> None:
        if self.pending or self.terminated:
            self.pending = False
            self._raised_s = time.monotonic()
            raise Termination("SIGTERM") if self.terminated else KeyboardInterrupt

    def _receive(self, number: int, frame: FrameType | None) -> None:
        if self._asks:
            self._asks = False
            return
        if number in _ENDING and not self.terminated:
            self.terminated = True
            self._terminating()
            _thread.start_new_thread(self._insist, ())
        now_s, insists, self._insists = time.monotonic(), self._insists, False
        is_again = now_s - self._raised_s < AGAIN_S and not insists
        is_late = number in _ENDING and self._let_go_s is not None
        if self._deferring or is_again or is_late:
            self.pending |= number in _ENDING or not is_again
            return
        went_on, self._raised_s = self._raised_s > 0, now_s
        if number not in _ENDING:
            raise KeyboardInterrupt
        node = current_node()
        if node is not None and went_on:
            node.kernel.abandon(Termination("SIGTERM"))
        raise Termination("SIGTERM")

    def _hear(self, number: int) -> None:
        """A signal came, says a thread: whether the main thread will ever handle it is another thing."""
        if number not in _ENDING or self._is_heard:
            return
        self._is_heard = True
        waiting = _thread.allocate_lock()
        waiting.acquire()
        waiting.acquire(timeout=LETS_GO_WITHIN_S)
        if self._before and not self.terminated and self._is_unheard(number, waiting):
            self.terminated = True
            self._terminating()
            self._stuck()
        self._is_heard = False

    def _is_unheard(self, number: int, waiting: _thread.LockType) -> bool:
        """Whether the main thread handles no signals. A handler of the code under test may have taken the last one."""
        main = threading.main_thread().ident
        if main is None or signal.getsignal(number) != self._receive:
            return False
        self._asks = True
        signal.pthread_kill(main, number)
        waiting.acquire(timeout=LOOKS_EACH_S)
        return self._asks

    def _insist(self) -> None:
        """Raise once more in code that ignored SIGTERM, and end the process where nothing helps."""
        received_s, main = time.monotonic(), threading.main_thread()
        waiting = _thread.allocate_lock()
        waiting.acquire()
        while not waiting.acquire(timeout=LOOKS_EACH_S):
            waits_s, let_go_s = time.monotonic() - received_s, self._let_go_s
            if let_go_s is not None and self._before:
                if time.monotonic() - let_go_s > ENDING_WITHIN_S:
                    self._stuck()
                    return
            elif self._deferring and not self._holding:
                received_s = time.monotonic()  # the report is being made: code has let go, and may not be called again
            elif self._holding and waits_s > LETS_GO_WITHIN_S:
                received_s, self._holding, self._deferring = time.monotonic(), False, False
            elif self._holding:
                continue
            elif not self._before:
                return
            elif waits_s > LETS_GO_WITHIN_S:
                self._stuck()
                return
            elif main.ident is not None and hasattr(signal, "pthread_kill"):
                self._insists = True
                signal.pthread_kill(main.ident, signal.SIGTERM)


def _is_caught_in_c(number: int) -> bool:
    """Whether somebody handles it without Python's knowing, as `faulthandler.register` does; only Linux says so."""
    try:
        caught = re.search(r"^SigCgt:\s*(\w+)", Path("/proc/self/status").read_text(encoding="utf-8"), re.MULTILINE)
    except OSError:
        return False
    return caught is not None and bool(int(caught[1], 16) >> (number - 1) & 1)


@contextmanager
def _listen(hear: Callable[[int], None]) -> Iterator[None]:
    """Within: a thread is told the numbers of signals that come. Not on Windows, nor where somebody else is told."""
    before = signal.set_wakeup_fd(-1) if hasattr(signal, "pthread_kill") else None
    if before != -1:
        if before is not None:
            signal.set_wakeup_fd(before)
        yield
        return
    reading, writing = os.pipe()
    os.set_blocking(writing, False)

    def listen() -> None:
        while (number := os.read(reading, 1)) not in (b"", _OVER):
            hear(number[0])
        os.close(reading)

    signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
    _WAKING.add(writing)
    _thread.start_new_thread(listen, ())
    try:
        yield
    finally:
        _WAKING.discard(writing)
        signal.set_wakeup_fd(-1)
        with suppress(BlockingIOError):  # nobody reads any more
            os.write(writing, _OVER)
        os.close(writing)


_OVER = b"\0"
"""No signal has this number."""

_WAKING: set[int] = set()
"""Descriptors of this process that hear of signals."""


def _deaf() -> None:
    """A fork handles signals on its own, unlike the process that it was forked from; a node's fork ends by them."""
    for number in _REPLACED if current_node() is not None else ():
        if str(getattr(signal.getsignal(number), "__module__", None)) == __name__:
            signal.signal(number, _REPLACED[number])
    if _WAKING:
        before = signal.set_wakeup_fd(-1)
        if before not in _WAKING:
            signal.set_wakeup_fd(before)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_deaf)


def end_with_parent() -> None:
    """Let this process end soon after the one that started it, however that ended: nobody needs its results."""
    parent, waiting = os.getppid(), _thread.allocate_lock()
    waiting.acquire()

    def look() -> None:
        while not waiting.acquire(timeout=LOOKS_EACH_S):
            if os.getppid() != parent:
                os._exit(1)

    _thread.start_new_thread(look, ())
