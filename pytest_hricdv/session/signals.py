"""Signals that end a session: SIGTERM ends it as Ctrl-C does, and neither cuts off the report that is being made."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

AGAIN_S = 1.0
"""A second signal so soon after the first (s) is no second wish: it would cut off what the first one started."""

_REPLACED = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
"""The handlers that are replaced; where somebody else has set another one, this stays."""


class Terminated(KeyboardInterrupt):
    """SIGTERM came; pytest and its plugins treat this as Ctrl-C."""


class Signals:
    """Handles both signals while a session runs its tests.

    `pending` says that one came while none was let through.
    """

    def __init__(self) -> None:
        self.pending = False
        self._deferring = False
        self._raised_s = -AGAIN_S

    @contextmanager
    def handled(self) -> Iterator[None]:
        """Within: a signal raises. Afterwards the handlers are as they were."""
        before = {}
        if threading.current_thread() is threading.main_thread():  # elsewhere Python cannot set handlers
            before = {number: handler for number, handler in _REPLACED.items() if signal.getsignal(number) is handler}
        try:
            for number in before:
                signal.signal(number, self._receive)
            yield
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)

    @contextmanager
    def deferred(self, deferring: bool = True) -> Iterator[None]:
        """Within: signals only set `pending`; or, where `deferring` is false, they raise again."""
        outside, self._deferring = self._deferring, deferring
        try:
            yield
        finally:
            self._deferring = outside

    def _receive(self, number: int, frame: FrameType | None) -> None:
        now_s = time.monotonic()
        if self._deferring or now_s - self._raised_s < AGAIN_S:
            self.pending = True
            return
        self._raised_s = now_s
        raise Terminated("SIGTERM") if number == signal.SIGTERM else KeyboardInterrupt
