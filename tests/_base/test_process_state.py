"""What the code under test takes away from the process is put back."""

from __future__ import annotations

import builtins
import os
import sys

from pytest_hricdv._base.process_state import ProcessState, complaint


def test_what_nobody_can_call_is_put_back_and_named() -> None:
    state, kept = ProcessState(), os.getpid
    builtins.open, os.getpid = None, None  # type: ignore[assignment]
    try:
        lost = state.put_back()
    finally:
        os.getpid = kept
    assert lost == ("builtins.open", "os.getpid")
    assert "builtins.open, os.getpid" in complaint(lost)
    assert callable(open)


def test_what_a_library_replaces_stays() -> None:
    state, kept = ProcessState(), os.getpid
    os.getpid = lambda: 7
    try:
        assert state.put_back() == ()
        assert os.getpid() == 7
    finally:
        os.getpid = kept


def test_modules_that_the_session_imports_come_back() -> None:
    state, kept = ProcessState(), dict(sys.modules)
    del sys.modules["zlib"]
    assert state.put_back() == ("sys.modules['zlib']",)
    sys.modules.clear()
    assert state.put_back() == ("sys.modules",)
    assert sys.modules == kept


def test_a_recursion_limit_is_raised_again() -> None:
    state, before = ProcessState(), sys.getrecursionlimit()
    sys.setrecursionlimit(before - 100)
    assert state.put_back() == ()
    assert sys.getrecursionlimit() == before
