"""Calls of nodes that read a terminal: standard input, `termios`, `tty`, `select`, `getpass`, descriptor 0.

The functions here replace those of Python's library during a run. Outside of nodes they call the real ones. A node
never reads or sets the terminal that pytest was started in: it has the terminal that its testbench gives it
(`run.terminal`), or reading is refused.
"""

from __future__ import annotations

import fcntl
import getpass
import os
import select
import sys
import termios
from collections.abc import Callable, Iterable
from functools import wraps
from typing import Any, NoReturn

from pytest_hricdv.runtime.blocking_calls import real_wait
from pytest_hricdv.runtime.kernel import Node, current_node
from pytest_hricdv.runtime.redirection import original, replace_in_class
from pytest_hricdv.runtime.source_location import place_of
from pytest_hricdv.runtime.virtual import clocks
from pytest_hricdv.runtime.virtual.real_time import RealTimeError
from pytest_hricdv.runtime.virtual.terminal import SIZE, Terminal, terminal_of, terminals_of

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

_MS_PER_S = 1000.0


def _refuse(node: Node, deed: str) -> NoReturn:
    others = ", ".join(repr(name) for name in terminals_of(node.kernel))
    there_are = f"; the run has terminals for {others}" if others else ""
    name = node.own.get("terminal") or node.name
    raise RealTimeError(
        f"{place_of(sys._getframe(1))}: node {node.name} {deed}, but nobody sits at its terminal: give it one before "
        f"run.go, keyboard = run.terminal({name!r}), and let a person press keys, keyboard.press('w'){there_are}"
    )


_READING = frozenset(
    (
        "read",
        "readline",
        "readlines",
        "buffer",
        "fileno",
        "detach",
        "__iter__",
        "__next__",
        "__enter__",
        "_checkReadable",
    )
)
"""The members of standard input that read; all others, such as its encoding, are harmless."""


class _Nobody:
    """Standard input without a person: it is not a terminal."""

    def __init__(self, outside: Any) -> None:
        self._outside = outside

    def __getattr__(self, name: str) -> Any:
        return getattr(self._outside, name)

    def isatty(self) -> bool:
        return False


class NodeStdin:
    """`sys.stdin` during a run: in a node its terminal, elsewhere what it was before."""

    outside: Any = None
    """Its previous value."""

    def _stream(self, name: str) -> Any:
        node = current_node()
        if node is None:
            return self.outside
        terminal = terminal_of(node)
        if terminal is not None:
            return terminal.stdin
        if name in _READING:
            _refuse(node, f"reads standard input (sys.stdin.{name})")
        return _Nobody(self.outside)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self._stream(name), name)

    def __iter__(self) -> Any:
        return iter(self._stream("__iter__"))

    def __next__(self) -> Any:
        return next(self._stream("__next__"))

    def __enter__(self) -> Any:
        return self._stream("__enter__")

    def __exit__(self, *_: object) -> None:
        """A terminal stays open: others of its process may read it."""


STDIN = NodeStdin()
"""One for the process: code that was imported in one run keeps it in the next."""


def _find_terminal(file: Any, refuses: bool = True) -> tuple[Node, Terminal] | None:
    """The running node and its terminal, if a file or descriptor is that terminal's; None for others."""
    node = current_node()
    if node is None:
        return None
    # Anything else that has a descriptor is a file of its own.
    is_input = file is STDIN or (isinstance(file, int) and not isinstance(file, bool) and file == 0)
    terminal = terminal_of(node) if is_input or terminals_of(node.kernel) else None
    if is_input and terminal is None and refuses:
        _refuse(node, "uses the terminal")
    if terminal is None or not (is_input or file in (terminal.fd, terminal.stdin, terminal.stdin.buffer)):
        return None
    return node, terminal


def _make_terminal_call(real: Callable[..., Any], virtual: Callable[..., Any]) -> Callable[..., Any]:
    """A function whose first argument is a file: of the terminal of a node, or a real one."""

    refuses, real = real is not os.isatty, original(real)

    @wraps(real)
    def call(file: Any = None, *arguments: Any, **keywords: Any) -> Any:
        if file is None:
            return real(*arguments, **keywords)  # os.get_terminal_size(): of the output
        meant = _find_terminal(file, refuses)
        if meant is None and not refuses and current_node() is not None and file == 0:
            return False
        return real(file, *arguments, **keywords) if meant is None else virtual(meant[1], *arguments, **keywords)

    return call


def _tcsetattr(terminal: Terminal, when: int, attributes: list[Any]) -> None:
    terminal.set_attributes(when, attributes)


def _tcgetattr(terminal: Terminal) -> list[Any]:
    *flags, characters = terminal.attributes
    return [*flags, [*characters]]


def _tcflush(terminal: Terminal, queue: int) -> None:
    if queue in (termios.TCIFLUSH, termios.TCIOFLUSH):
        terminal.flush()


def _read(terminal: Terminal, size: int) -> bytes:
    data = terminal.read(size)
    if data is None:
        raise BlockingIOError(11, "Resource temporarily unavailable")
    return data


def _set_blocking(terminal: Terminal, blocking: bool) -> None:
    terminal.is_blocking = blocking


def _fcntl(terminal: Terminal, command: int, argument: Any = 0) -> int:
    if command == fcntl.F_SETFL:
        terminal.is_blocking = not argument & os.O_NONBLOCK
        return 0
    if command == fcntl.F_GETFL:
        return os.O_RDWR | (0 if terminal.is_blocking else os.O_NONBLOCK)
    raise RealTimeError(
        f"{place_of(sys._getframe(1))}: fcntl({command}) of the terminal of a simulated run; expected F_GETFL or "
        "F_SETFL"
    )


def _ioctl(terminal: Terminal, request: int, *_: Any) -> Any:
    raise RealTimeError(
        f"{place_of(sys._getframe(1))}: ioctl({request}) of the terminal of a simulated run: use termios, tty or select"
    )


_REAL_SELECT = original(select.select)


def _select_others(files: tuple[list[Any], list[Any], list[Any]], timeout: float | None) -> Any:
    """The other files that are ready; without any, `select` is a way to sleep."""
    if not any(files) and timeout is not None and timeout > 0:
        clocks.sleep(timeout)
    ready = _REAL_SELECT(*files, 0)
    node = current_node()
    if any(ready) or (timeout is not None and (timeout <= 0 or not any(files))) or node is None:
        return ready
    kernel, frame = node.kernel, sys._getframe(2)
    raise RealTimeError(real_wait(frame, f"node {node.name}", kernel.code, kernel.virtual, "select.select"))


@wraps(_REAL_SELECT)
def _select(read: Iterable[Any], write: Iterable[Any], other: Iterable[Any], timeout: float | None = None, /) -> Any:
    files = ([*read], [*write], [*other])
    if current_node() is None:
        return _REAL_SELECT(*files, timeout)
    terminals = [meant for file in files[0] if (meant := _find_terminal(file)) is not None]
    if not terminals:
        return _select_others(files, timeout)
    node, terminal = terminals[0]
    if len(files[0]) > 1 or files[1] or files[2]:
        raise RealTimeError(
            f"{place_of(sys._getframe(1))}: node {node.name} waits with select for its terminal and for other files, "
            "which a simulated run does not have: select the terminal alone"
        )
    return (files[0] if terminal.wait_readable(timeout) else [], [], [])


def _poll_at_once(poll: Any, timeout: float | None, *limit: int) -> list[tuple[int, int]]:
    """What is ready: in a node, nothing is waited for."""
    node = current_node()
    ready = list(poll(timeout if node is None else 0, *limit))
    if ready or node is None or timeout == 0:
        return ready
    kernel, frame = node.kernel, sys._getframe(2)
    kind = f"select.{type(poll.__self__).__name__}.poll"
    raise RealTimeError(real_wait(frame, f"node {node.name}", kernel.code, kernel.virtual, kind))


def _epoll(self: Any, timeout: float | None = None, maxevents: int = -1) -> list[tuple[int, int]]:
    return _poll_at_once(_EPOLL.__get__(self), timeout, maxevents)


_EPOLL: Any = replace_in_class(select.epoll, "poll", _epoll) if hasattr(select, "epoll") else None


class _Poll:
    """Like `select.poll()` in a node, which may have a terminal."""

    def __init__(self, real: Any) -> None:
        self._real = real
        self._terminal: Terminal | None = None
        self._wanted: dict[int, int] = {}

    def register(self, file: Any, events: int = select.POLLIN | select.POLLPRI | select.POLLOUT) -> None:
        meant = _find_terminal(file)
        if meant is None:
            self._real.register(file, events)
            return
        self._terminal = meant[1]
        self._wanted[meant[1].fd] = events

    modify = register

    def unregister(self, file: Any) -> None:
        meant = _find_terminal(file)
        if meant is None:
            self._real.unregister(file)
        else:
            del self._wanted[meant[1].fd]

    def poll(self, timeout: float | None = None, *limit: int) -> list[tuple[int, int]]:
        if not self._wanted or self._terminal is None:
            return _poll_at_once(self._real.poll, timeout)
        wait_s = None if timeout is None or timeout < 0 else timeout / _MS_PER_S
        ready = self._terminal.wait_readable(wait_s)
        return [(self._terminal.fd, select.POLLIN)] if ready and self._wanted[self._terminal.fd] & select.POLLIN else []


def _make_poll(real: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(real)
    def poll(*args: Any, **keywords: Any) -> Any:
        made = real(*args, **keywords)
        return made if current_node() is None else _Poll(made)

    return poll


def _make_ask(real: Callable[..., str]) -> Callable[..., str]:
    @wraps(real)
    def ask(prompt: str = "Password: ", *arguments: Any, **keywords: Any) -> str:
        node = current_node()
        if node is None:
            return real(prompt, *arguments, **keywords)
        print(prompt, end="", file=sys.stderr)
        line = STDIN.readline()
        if not line:
            raise EOFError
        return str(line.removesuffix("\n"))

    return ask


def _do_nothing(terminal: Terminal, *_: Any) -> None:
    """Ignore a call about the output of a terminal."""


_VIRTUAL: tuple[tuple[Any, str, Callable[..., Any]], ...] = (
    (termios, "tcgetattr", _tcgetattr),
    (termios, "tcsetattr", _tcsetattr),
    (termios, "tcflush", _tcflush),
    (termios, "tcdrain", _do_nothing),
    (termios, "tcflow", _do_nothing),
    (termios, "tcsendbreak", _do_nothing),
    (termios, "tcgetwinsize", lambda terminal: (SIZE.lines, SIZE.columns)),
    (fcntl, "fcntl", _fcntl),
    (fcntl, "ioctl", _ioctl),
    (os, "read", _read),
    (os, "isatty", lambda terminal: True),
    (os, "get_terminal_size", lambda terminal: SIZE),
    (os, "ttyname", lambda terminal: "/dev/pts/0"),
    (os, "set_blocking", _set_blocking),
    (os, "get_blocking", lambda terminal: terminal.is_blocking),
)

REPLACED: tuple[tuple[Any, Callable[..., Any]], ...] = (
    *(
        (real, _make_terminal_call(real, virtual))
        for module, name, virtual in _VIRTUAL
        if (real := getattr(module, name, None)) is not None
    ),
    (select.select, _select),
    (getpass.getpass, _make_ask(original(getpass.getpass))),
    *([(select.poll, _make_poll(original(select.poll)))] if hasattr(select, "poll") else []),
)
"""Functions that read or wait, and what takes the place of each in runs."""


def is_of_session(stream: Any) -> bool:
    """Whether a standard input is that of the process or of pytest; otherwise somebody has put it there for the run."""
    return stream is None or stream is sys.__stdin__ or type(stream).__module__ == "_pytest.capture"
