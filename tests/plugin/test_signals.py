"""Signals raise where they may, are kept where they may not, and are never lost between."""

from __future__ import annotations

import faulthandler
import os
import signal
import sys
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.session import signals as module
from pytest_hricdv.session.signals import Signals, Termination


def send(number: signal.Signals = signal.SIGINT) -> None:
    os.kill(os.getpid(), number)


@pytest.fixture
def handled(monkeypatch: pytest.MonkeyPatch) -> Iterator[Signals]:
    """In this process; a second signal may come at once."""
    monkeypatch.setattr(module, "AGAIN_S", 0.0)
    before = {number: signal.getsignal(number) for number in module._REPLACED}
    for number in module._REPLACED:
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    signals = Signals()
    signals.begin()
    try:
        yield signals
    finally:
        signals.end()
        for number, handler in before.items():
            signal.signal(number, handler)


def test_it_raises_where_it_is_let_through_and_at_once_if_it_came_before(handled: Signals) -> None:
    with handled.defer():
        send()
        assert handled.pending
        with pytest.raises(KeyboardInterrupt), handled.let_through():
            pytest.fail("it was let through")
        assert not handled.pending
        with pytest.raises(KeyboardInterrupt), handled.let_through():
            send()
        send()  # not let through: the block has ended, although by what was raised
    assert handled.pending


def test_what_is_held_is_raised_once_it_is_released(handled: Signals) -> None:
    with handled.defer():
        handled.hold()
    send()
    with handled.defer():
        send()
    assert handled.pending
    with pytest.raises(KeyboardInterrupt), handled.release():
        pytest.fail("it was held")
    with pytest.raises(KeyboardInterrupt), handled.release():
        send()


@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGQUIT", "SIGUSR1", "SIGXCPU"])
def test_sigterm_is_raised_wherever_something_would_begin(handled: Signals, name: str) -> None:
    with handled.defer():
        send(getattr(signal, name))
        assert handled.terminated
        for _ in range(2):
            with pytest.raises(Termination), handled.let_through():
                pytest.fail("it was let through")
        handled.hold()
    with pytest.raises(Termination), handled.release():
        pytest.fail("it was held")


@pytest.mark.parametrize("is_reporting", [False, True])
def test_nothing_is_raised_where_the_session_ends(
    handled: Signals, monkeypatch: pytest.MonkeyPatch, is_reporting: bool
) -> None:
    """SIGTERM is raised again and again in code that goes on, but not in what pytest and plugins do afterwards."""
    looks = threading.Semaphore(0)
    monkeypatch.setattr(module, "LOOKS_EACH_S", 0.001)
    monkeypatch.setattr(module, "ENDING_WITHIN_S", 0.1)
    monkeypatch.setattr(handled, "_stuck", looks.release)
    with pytest.raises(Termination):
        send(signal.SIGTERM)
    handled.let_go()
    if is_reporting:
        with handled.defer():
            assert not looks.acquire(timeout=0.2), "a report may take as long as it likes"
    assert looks.acquire(timeout=600)  # up to here it would have been raised a hundred times
    send(signal.SIGTERM)
    assert handled.pending


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux says which signals are caught in C")
def test_what_faulthandler_is_registered_for_stays_its_own(handled: Signals, tmp_path: Path) -> None:
    handled.end()
    with (tmp_path / "stacks").open("w+") as file:
        faulthandler.register(signal.SIGUSR1, file=file)
        try:
            handled.begin()
            send(signal.SIGUSR1)
            assert not handled.terminated
            file.seek(0)
            assert __file__ in file.read()
        finally:
            faulthandler.unregister(signal.SIGUSR1)


@pytest.mark.parametrize("is_of_code", [False, True])
def test_a_signal_that_the_main_thread_handles_ends_nothing(
    handled: Signals, monkeypatch: pytest.MonkeyPatch, is_of_code: bool
) -> None:
    monkeypatch.setattr(module, "LETS_GO_WITHIN_S", 0.0)
    if is_of_code:
        signal.signal(signal.SIGUSR1, lambda number, frame: None)
    hearing = threading.Thread(target=handled._hear, args=(signal.SIGUSR1,))
    hearing.start()
    hearing.join()
    assert not handled.terminated


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there are no forks here")
def test_a_process_that_a_node_has_forked_ends_by_a_signal_as_any(handled: Signals) -> None:
    children = list[int]()

    def node() -> None:
        child = os.fork()
        if not child:
            try:
                send(signal.SIGTERM)
            finally:
                os._exit(0)
        children.append(child)

    kernel = Kernel()
    kernel.spawn("robot", node)
    kernel.run(1.0)
    assert os.waitstatus_to_exitcode(os.waitpid(children[0], 0)[1]) == -signal.SIGTERM
