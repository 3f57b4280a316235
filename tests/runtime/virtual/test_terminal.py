"""What a person types at a terminal is what nodes read, in virtual time; the terminal of pytest is never touched."""

from __future__ import annotations

import asyncio
import gc
import getpass
import json
import os
import pty
import select
import selectors
import signal
import sys
import termios
import tty
from collections.abc import Callable, Sequence
from typing import Any

import pytest

from pytest_hricdv.runtime import Kernel
from pytest_hricdv.runtime.node_error import KernelError, NodeError
from pytest_hricdv.runtime.virtual import asyncio_functions
from pytest_hricdv.runtime.virtual.outside import guard_run
from pytest_hricdv.runtime.virtual.terminal import Terminal, terminal_for
from tests.runtime.virtual import terminal_program

Typing = Callable[[Terminal], None]


def run(
    *bodies: Callable[[Kernel], object], keys: Sequence[tuple[float, Typing]] = (), name: str | None = ""
) -> Kernel:
    """Run nodes, while somebody does something at their terminal at some times (s); without a terminal for None."""
    kernel = Kernel()
    kernel.virtual = frozenset({"time", "threading", "asyncio"})
    with guard_run(kernel):
        for body in bodies:
            kernel.spawn(body.__name__, lambda body=body: body(kernel))  # type: ignore[misc]
        if name is not None:
            terminal = terminal_for(kernel, name)

            def person() -> None:
                for time_s, act in keys:
                    kernel.sleep(time_s - kernel.now_s)
                    act(terminal)

            kernel.spawn("person", person)
        try:
            kernel.run(100.0)
        finally:
            kernel.close()
    return kernel


def press(*keys: str) -> Typing:
    return lambda terminal: terminal.press(*keys)


def typing(text: str) -> Typing:
    return lambda terminal: terminal.type(text)


def test_input_waits_for_a_line_in_virtual_time(capsys: pytest.CaptureFixture[str]) -> None:
    seen: list[Any] = []

    def node(kernel: Kernel) -> None:
        seen.append((input("name? "), kernel.now_s))
        seen.append((sys.stdin.readline(), kernel.now_s))

    run(node, keys=[(1.0, typing("Ali")), (2.0, press("x", "backspace", "ctrl-u")), (3.0, typing("Eve\nx y\n"))])
    assert seen == [("Eve", 3.0), ("x y\n", 3.0)]
    assert capsys.readouterr().out == "name? "


def test_lines_end_with_the_input() -> None:
    seen: list[Any] = []

    def node(kernel: Kernel) -> None:
        seen.extend((line, kernel.now_s) for line in sys.stdin)
        with pytest.raises(EOFError):
            input()
        seen.append(sys.stdin.read())

    run(node, keys=[(1.0, typing("a\n")), (2.0, typing("b")), (3.0, lambda terminal: terminal.close())])
    assert seen == [("a\n", 1.0), ""]  # a line that is not ended is not there


def getch() -> str:
    """As on the web, in many nodes."""
    settings = termios.tcgetattr(sys.stdin)
    try:
        tty.setraw(sys.stdin.fileno())
        return sys.stdin.read(1)
    finally:
        termios.tcsetattr(sys.stdin, termios.TCSADRAIN, settings)


def test_a_key_is_read_at_once_in_raw_mode() -> None:
    seen: list[Any] = []

    def node(kernel: Kernel) -> None:
        while (key := getch()) != "q":
            seen.append((key, kernel.now_s))

    kernel = run(node, keys=[(0.5, press("w")), (1.0, press("enter")), (2.0, press("ctrl-c")), (3.0, press("é", "q"))])
    assert seen == [("w", 0.5), ("\r", 1.0), ("\x03", 2.0), ("é", 3.0)]
    assert kernel.now_s == 3.0


def test_select_waits_for_a_key_or_for_time() -> None:
    seen: list[Any] = []

    def node(kernel: Kernel) -> None:
        tty.setcbreak(sys.stdin)
        for _ in range(4):
            ready, _, _ = select.select([sys.stdin], [], [], 1.0)
            seen.append((sys.stdin.read(1) if ready else "", kernel.now_s))

    run(node, keys=[(0.5, press("w")), (1.7, press("x"))])
    assert seen == [("w", 0.5), ("", 1.5), ("x", 1.7), ("", 2.7)]


@pytest.mark.parametrize("waiting", ["poll", "DefaultSelector", "SelectSelector", "descriptor"])
def test_other_ways_to_wait_for_a_key(waiting: str) -> None:
    seen: list[Any] = []

    def ready(kernel: Kernel) -> bool:
        if waiting == "poll":
            poll = select.poll()
            poll.register(sys.stdin, select.POLLIN)
            return poll.poll(500) == [(sys.stdin.fileno(), select.POLLIN)]
        if waiting == "descriptor":
            return select.select([0], [], [], 0.5) == ([0], [], [])
        with getattr(selectors, waiting)() as selector:
            selector.register(sys.stdin, selectors.EVENT_READ)
            return bool(selector.select(0.5))

    def node(kernel: Kernel) -> None:
        tty.setcbreak(0)
        seen.append((ready(kernel), kernel.now_s))
        seen.append((ready(kernel), kernel.now_s, os.read(0, 10), os.isatty(0)))

    run(node, keys=[(0.7, press("w"))])
    assert seen == [(False, 0.5), (True, 0.7, b"w", True)]


def test_ctrl_c_interrupts_a_node_where_it_waits_and_ends_it() -> None:
    seen: list[Any] = []

    def node(kernel: Kernel) -> None:
        for wait in (input, lambda: kernel.sleep(10.0)):
            try:
                wait()
            except KeyboardInterrupt:
                seen.append(kernel.now_s)
        input()

    kernel = run(node, keys=[(1.0, press("a", "ctrl-c")), (2.0, press("ctrl-c")), (3.0, press("ctrl-c"))])
    assert (seen, kernel.now_s, kernel.nodes[0].ended) == ([1.0, 2.0], 3.0, True)


@pytest.mark.parametrize(
    ("read", "deed"),
    [
        (input, r"reads standard input \(sys.stdin.(fileno|readline)\)"),
        (lambda: sys.stdin.read(1), r"reads standard input \(sys.stdin.read\)"),
        (lambda: list(sys.stdin), r"reads standard input \(sys.stdin.__iter__\)"),
        (lambda: termios.tcgetattr(sys.stdin), "uses the terminal"),
        (lambda: tty.setraw(0), "uses the terminal"),
        (lambda: select.select([sys.stdin], [], [], 0.1), "uses the terminal"),
        (lambda: os.read(0, 1), "uses the terminal"),
        (getpass.getpass, "reads standard input"),
    ],
)
def test_reading_without_a_terminal_is_refused_with_its_line(read: Callable[[], Any], deed: str) -> None:
    def node(kernel: Kernel) -> None:
        read()

    with pytest.raises(NodeError, match=rf"test_terminal.py:\d+: node node {deed}.*keyboard = run.terminal\('node'\)"):
        run(node, name=None)


def test_two_nodes_that_read_one_terminal_are_told() -> None:
    def one(kernel: Kernel) -> None:
        input()

    def other(kernel: Kernel) -> None:
        input()

    with pytest.raises(NodeError, match="the terminal '' is read by other, while one does"):
        run(one, other)


def test_nothing_is_left_behind(monkeypatch: pytest.MonkeyPatch) -> None:
    before = (sys.stdin, select.select, termios.tcgetattr, vars(tty)["tcgetattr"], os.read, getpass.getpass)
    gc.collect()  # descriptors that earlier tests forgot would be closed in between
    descriptors = len(os.listdir("/proc/self/fd")) if os.path.isdir("/proc/self/fd") else 0
    run(lambda kernel: getch(), keys=[(1.0, press("a"))])
    assert (sys.stdin, select.select, termios.tcgetattr, vars(tty)["tcgetattr"], os.read, getpass.getpass) == before
    assert not descriptors or len(os.listdir("/proc/self/fd")) <= descriptors


def test_outside_of_nodes_everything_is_the_real_one() -> None:
    kernel = Kernel()
    with guard_run(kernel):
        reading, writing = os.pipe()
        os.write(writing, b"a")
        assert select.select([reading], [], [], 0) == ([reading], [], [])
        assert os.read(reading, 1) == b"a"
        os.close(reading)
        os.close(writing)
        with pytest.raises(KernelError):
            kernel.sleep(1.0)


def test_an_event_loop_reads_keys() -> None:
    seen: list[Any] = []

    async def reading(kernel: Kernel) -> None:
        loop = asyncio.get_running_loop()
        came: asyncio.Queue[str] = asyncio.Queue()
        loop.add_reader(sys.stdin, lambda: came.put_nowait(sys.stdin.readline()))
        seen.append((await came.get(), kernel.now_s))
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(came.get(), 1.0)
        seen.append(kernel.now_s)
        loop.remove_reader(sys.stdin)
        seen.append((await loop.run_in_executor(None, input), kernel.now_s))
        reader = asyncio.StreamReader()
        transport, _ = await loop.connect_read_pipe(lambda: asyncio.StreamReaderProtocol(reader), sys.stdin)
        seen.append((await reader.readline(), kernel.now_s))
        transport.close()

    def node(kernel: Kernel) -> None:
        asyncio_functions.run(reading(kernel))

    run(node, keys=[(1.0, typing("a\n")), (3.0, typing("b\n")), (4.0, typing("c\n"))])
    assert seen == [("a\n", 1.0), 2.0, ("b", 3.0), (b"c\n", 4.0)]


def at_a_real_terminal() -> list[Any]:
    """What the program reads at a terminal of the system."""
    child, master = pty.fork()
    if child == 0:
        signal.signal(signal.SIGINT, signal.SIG_DFL)  # what a shell starts in the background ignores it
        os.execv(sys.executable, [sys.executable, terminal_program.__file__])
    output, typed = b"", 0
    try:
        while b"RESULT" not in output or not output.endswith(b"\n"):
            ready, _, _ = select.select([master], [], [], 60.0)
            assert ready, f"nothing came after {output!r}"
            output += os.read(master, 4096)
            while output.count(b"READY") > typed:
                os.write(master, terminal_program.KEYS[typed])
                typed += 1
    finally:
        os.close(master)
        os.waitpid(child, 0)
    return list(json.loads(output.partition(b"RESULT")[2]))


@pytest.mark.slow
def test_programs_read_what_they_read_at_a_real_terminal() -> None:
    seen: list[Any] = []
    keys = iter(terminal_program.KEYS)

    def node(kernel: Kernel) -> None:
        terminal = terminal_for(kernel, "")

        def announce() -> None:
            def person() -> None:
                kernel.sleep(0.5)
                terminal._receive(next(keys))

            kernel.spawn("typist", person)

        seen.extend(terminal_program.read(announce))

    run(node)
    assert seen == at_a_real_terminal()
    assert seen[2:4] == ["ac", "yz\n"]
