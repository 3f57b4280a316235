"""What the code under test takes away from the process is put back."""

from __future__ import annotations

import builtins
import collections
import gc
import os
import signal
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_hricdv._base.process_state import ProcessState


@pytest.fixture(autouse=True)
def replaced(monkeypatch: pytest.MonkeyPatch) -> None:
    """What these tests replace is of no later run of this process."""
    monkeypatch.setattr("pytest_hricdv._base.process_state._MADE", {})


def test_what_nobody_can_call_is_put_back_and_named() -> None:
    state, kept = ProcessState(), os.getpid
    builtins.open, os.getpid, os.path.join, collections.deque = None, None, None, None  # type: ignore
    try:
        (wrong,) = state.put_back()
    finally:
        os.getpid = kept
    assert all(name in wrong for name in ("builtins.open", "os.getpid", "os.path.join", "collections.deque"))
    assert callable(open)
    assert callable(collections.deque)


def test_what_a_library_replaces_is_there_in_runs_only() -> None:
    state, kept = ProcessState(), os.getpid
    other = lambda: 7  # noqa: E731
    try:
        os.getpid = other
        assert state.put_back() == ()
        assert os.getpid is kept
        state = ProcessState()
        assert os.getpid is other
        assert state.put_back() == ()
        assert os.getpid is kept
    finally:
        os.getpid = kept


def test_what_answers_wrongly_is_put_back_and_named() -> None:
    state, kept = ProcessState(), builtins.isinstance
    builtins.isinstance = lambda *_: True
    try:
        (wrong,) = state.put_back()
        assert builtins.isinstance is kept
    finally:
        builtins.isinstance = kept
    assert "builtins.isinstance of Python's library answer wrongly" in wrong


SETTINGS: dict[str, tuple[Callable[[], object], Callable[[Path], object]]] = {
    "folder": (os.getcwd, os.chdir),
    "variables": (lambda: os.environ.get("PATH"), lambda _: os.environ.clear()),
    "finders": (lambda: [*sys.path], lambda _: sys.path.clear()),
    "signals": (
        lambda: signal.getsignal(signal.SIGTERM),
        lambda _: signal.signal(signal.SIGTERM, signal.SIG_IGN),
    ),
    "recursion": (sys.getrecursionlimit, lambda _: sys.setrecursionlimit(10**6)),
    "memory": (tracemalloc.is_tracing, lambda _: tracemalloc.start()),
    "callbacks": (lambda: [*gc.callbacks], lambda _: gc.callbacks.append(print)),
    "environment": (lambda: os.environ["PATH"], lambda _: setattr(os, "environ", {"PATH": ""})),
    "collector": (gc.get_threshold, lambda _: gc.set_threshold(1)),
    "streams": (lambda: sys.stdout, lambda _: setattr(sys, "stdout", None)),
    "descriptors": (lambda: os.path.exists("/dev/fd/1"), lambda _: os.close(1)),
}
"""What of the process -> how to ask for it, and how code spoils it."""


@pytest.mark.parametrize("name", SETTINGS)
def test_how_the_process_works_is_put_back_without_a_word(name: str, tmp_path: Path) -> None:
    ask, spoil = SETTINGS[name]
    state, before = ProcessState(), ask()
    spoil(tmp_path)
    assert ask() != before
    assert state.put_back() == ()
    assert ask() == before
