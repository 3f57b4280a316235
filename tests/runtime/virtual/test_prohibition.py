"""Waits for processes are refused in a run only where they would wait."""

from __future__ import annotations

import os
from collections.abc import Callable

import pytest

from pytest_hricdv.runtime.virtual.prohibition import is_harmless

pytestmark = pytest.mark.skipif(not hasattr(os, "waitid"), reason="nobody can look at processes here")

WAITS: dict[str, Callable[[int], tuple[int, ...]]] = {
    "os.waitpid": lambda pid: (pid, 0),
    "os.wait4": lambda pid: (pid, 0),
    "os.waitid": lambda pid: (os.P_PID, pid, os.WEXITED) if hasattr(os, "P_PID") else (),
}


@pytest.mark.parametrize("name", WAITS)
def test_a_wait_is_harmless_once_the_process_has_ended(name: str) -> None:
    reading, writing = os.pipe()
    pid = os.fork()
    if not pid:
        os.close(writing)
        os.read(reading, 1)
        os._exit(3)
    os.close(reading)
    args = WAITS[name](pid)
    assert not is_harmless(name, args)
    assert is_harmless("os.waitpid", (pid, os.WNOHANG))
    assert is_harmless("os.wait3", (os.WNOHANG,))
    os.close(writing)
    os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)
    assert is_harmless(name, args)
    assert os.waitpid(pid, 0)[0] == pid, "it was only looked at"
    assert is_harmless("os.waitpid", (pid, 0)), "there is no such process"


def test_where_nobody_can_look_a_wait_is_refused_unless_it_only_asks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pytest_hricdv.runtime.virtual.prohibition._PEEK", 0)
    monkeypatch.delattr("os.waitid")
    assert not is_harmless("os.waitpid", (1, 0))
    assert is_harmless("os.waitpid", (1, os.WNOHANG))
