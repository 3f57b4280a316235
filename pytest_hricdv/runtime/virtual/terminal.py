"""Terminals in virtual time: nodes read from standard input what a person types in the run.

A terminal has the line discipline of POSIX (IEEE 1003.1, chapter 11): lines are edited and end with the enter key, or,
once a node has chosen so with `termios` or `tty`, each key is read at once. On top of it are Python's own buffers.
"""

from __future__ import annotations

import io
import os
import termios
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from pytest_hricdv._base.message import nearest
from pytest_hricdv.runtime.kernel import Kernel, Node, current_node
from pytest_hricdv.runtime.node_error import KernelError, TerminalInterrupt
from pytest_hricdv.runtime.redirection import original
from pytest_hricdv.runtime.virtual.terminal_keys import KEYS, default_attributes

__tracebackhide__ = True  # a failing test shows the frames of its author; pytest's --full-trace shows all

SIZE = os.terminal_size((80, 24))
"""Columns and lines of each terminal (those of a VT100)."""

_IFLAG, _LFLAG, _CC = 0, 3, 6
"""Where `termios.tcgetattr` has what."""

_READ = original(os.read)  # also while another one stands for it

_DECISECOND_S = 0.1
"""The unit of `VTIME`."""


class Terminal:
    """A terminal that nodes read, and on whose keyboard somebody types.

    Args:
        name: of the process that has it; empty: of all that have none of their own.
        record: called with what is typed.
    """

    def __init__(self, kernel: Kernel, name: str = "", record: Callable[[str], None] = lambda text: None) -> None:
        self.name = name
        self._kernel = kernel
        self._record = record
        self.attributes = default_attributes()
        self._ready: deque[bytes] = deque()
        """The readable input: lines, or else pieces of any length. An empty one is the end of the input."""
        self._line = bytearray()
        """A line that is being edited."""
        self._is_closed = False
        self.is_blocking = True
        self._waiting: list[Node] = []
        self._listeners: list[Callable[[], None]] = []
        self.owner: Node | None = None
        """The node that Ctrl-C interrupts: the main thread of its process, or else the first that used the terminal."""
        self._interrupts = False
        self.fd, self._mirror = os.pipe()
        """A descriptor that can be read exactly when the terminal can: what only asks for readiness may ask it."""
        os.set_blocking(self.fd, False)
        self._is_mirrored = False
        self.stdin: io.TextIOWrapper = _TerminalText(self)

    def press(self, *keys: str) -> None:
        """Press keys, one after the other, at this instant.

        Args:
            keys: characters as "w" or "W", or names: "enter", "up", "esc", "ctrl-c", ... (`KEYS`).

        Raises:
            KernelError: a text of several characters that is not a name of a key.
        """
        for key in keys:
            if len(key) != 1 and key not in KEYS:
                near = nearest(key, KEYS)
                raise KernelError(
                    f"press({key!r}): expected one character, or the name of a key{near}; type(...) takes a string"
                )
        for key in keys:
            self._record(key)
            self._receive(KEYS.get(key) or key.encode())

    def type(self, text: str) -> None:
        """Type a text at this instant; each end of a line is the enter key."""
        self._record(text)
        self._receive(text.replace("\n", "\r").encode())

    def close(self) -> None:
        """Hang up: whoever reads gets the end of the input."""
        self._is_closed = True
        self._wake()

    def hang_up(self) -> None:
        """Give the descriptor back, when the run is over."""
        os.close(self.fd)
        os.close(self._mirror)

    @property
    def _lflag(self) -> int:
        return int(self.attributes[_LFLAG])

    @property
    def _is_canonical(self) -> bool:
        return bool(self._lflag & termios.ICANON)

    def _character(self, index: int) -> bytes:
        value = self.attributes[_CC][index]
        return value if isinstance(value, bytes) else bytes([value])

    def _receive(self, data: bytes) -> None:
        for number in data:
            self._receive_byte(bytes([number]))
        self._wake()

    def _receive_byte(self, byte: bytes) -> None:
        iflag = int(self.attributes[_IFLAG])
        if self._lflag & termios.ISIG and byte == self._character(termios.VINTR):
            self._line.clear()
            self._ready.clear()
            self._interrupt()
            return
        if byte == b"\r" and iflag & termios.IGNCR:
            return
        if byte == b"\r" and iflag & termios.ICRNL:
            byte = b"\n"
        elif byte == b"\n" and iflag & termios.INLCR:
            byte = b"\r"
        if self._is_canonical:
            self._edit(byte)
        else:
            self._ready.append(byte)

    def _edit(self, byte: bytes) -> None:
        if byte == self._character(termios.VERASE):
            while self._line and self._line.pop() & 0xC0 == 0x80:
                pass  # the bytes of one character
        elif byte == self._character(termios.VKILL):
            self._line.clear()
        else:
            is_end = byte == self._character(termios.VEOF)
            self._line += b"" if is_end else byte
            if is_end or byte == b"\n":
                self._ready.append(bytes(self._line))
                self._line.clear()

    def _interrupt(self) -> None:
        """The signal SIGINT of ctrl-c: raised in the owner, wherever it waits."""
        if self.owner is not None and not self.owner.ended:
            self._interrupts = True
            self._kernel.wake(self.owner)

    def belongs_to(self, node: Node) -> None:
        """Let ctrl-c interrupt this node, unless it interrupts another one."""
        if self.owner is None:
            self.owner = node
            node.leaving.insert(0, lambda: self._go_on)  # the last to be called, as it raises

    def _go_on(self) -> None:
        if self._interrupts:
            self._interrupts = False
            raise TerminalInterrupt

    def _wake(self) -> None:
        self._mirror_readiness()
        for node in self._waiting:
            node.kernel.wake(node)
        for listener in self._listeners if self.is_readable else ():
            listener()

    @contextmanager
    def notify(self, listener: Callable[[], None]) -> Iterator[None]:
        """Call a function whenever something can be read, within the block."""
        self._listeners.append(listener)
        try:
            yield
        finally:
            self._listeners.remove(listener)

    def _mirror_readiness(self) -> None:
        if self.is_readable and not self._is_mirrored:
            os.write(self._mirror, b"x")
        elif self._is_mirrored and not self.is_readable:
            _READ(self.fd, 1)
        self._is_mirrored = self.is_readable

    @property
    def is_readable(self) -> bool:
        """Whether a read would return at once."""
        return bool(self._ready) or self._is_closed

    def wait_readable(self, timeout_s: float | None) -> bool:
        """Wait until it can be read, at most so long; None: as long as it takes. Whether it can."""
        kernel = self._kernel
        if timeout_s is not None and timeout_s <= 0:
            kernel.count_poll()
            return self.is_readable
        end_s = None if timeout_s is None else kernel.now_s + timeout_s
        node = kernel.current()
        self._waiting.append(node)
        try:
            while not self.is_readable:
                left_s = None if end_s is None else end_s - kernel.now_s
                if left_s is not None and left_s <= 0:
                    return False
                kernel.block(left_s)
        finally:
            self._waiting.remove(node)
        return True

    def read(self, size: int) -> bytes | None:
        """Like `read(2)`: some bytes, none at the end of the input; None if it would have to wait, and may not."""
        minimum, ticks = (self.attributes[_CC][index] for index in (termios.VMIN, termios.VTIME))
        is_polling = not self._is_canonical and not _number(minimum)
        if not self.is_blocking:
            if not self.wait_readable(0.0):
                return None
        elif is_polling:
            if not self.wait_readable(_number(ticks) * _DECISECOND_S):
                return b""
        else:
            self.wait_readable(None)
        return self._take(size)

    def _take(self, size: int) -> bytes:
        taken = b""
        while self._ready and len(taken) < size:
            piece = self._ready.popleft()
            room = size - len(taken)
            taken += piece[:room]
            if piece[room:]:
                self._ready.appendleft(piece[room:])
            if self._is_canonical or not piece:
                break  # a line at most
        self._mirror_readiness()
        return taken

    def set_attributes(self, when: int, attributes: list[Any]) -> None:
        """Like `tcsetattr`: with `TCSAFLUSH`, what was typed and not yet read is lost."""
        was_canonical = self._is_canonical
        self.attributes = [*attributes[:_CC], [*attributes[_CC]]]
        if when == termios.TCSAFLUSH:
            self.flush()
        elif was_canonical != self._is_canonical:
            # On Linux, the present input can be read at once in the other mode, as one piece.
            pieces = b"".join(self._ready) + bytes(self._line)
            self.flush()
            if pieces:
                self._ready.append(pieces)
        self._wake()

    def flush(self) -> None:
        """Forget what was typed and not yet read."""
        self._ready.clear()
        self._line.clear()
        self._mirror_readiness()


def _number(value: bytes | int) -> int:
    return value if isinstance(value, int) else value[0]


class _TerminalBytes(io.RawIOBase):
    """A terminal as a file of bytes without a buffer."""

    def __init__(self, terminal: Terminal) -> None:
        self._terminal = terminal

    def readable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._terminal.fd

    def isatty(self) -> bool:
        return True

    def readinto(self, buffer: Any) -> int | None:
        data = self._terminal.read(len(buffer))
        if data is None:
            return None
        buffer[: len(data)] = data
        return len(data)


class _TerminalText(io.TextIOWrapper):
    """A terminal as `sys.stdin`, with the buffers of Python's own."""

    def __init__(self, terminal: Terminal) -> None:
        buffer = io.BufferedReader(_TerminalBytes(terminal))
        super().__init__(buffer, encoding="utf-8", newline="\n", line_buffering=True)
        self._terminal = terminal
        self._reader: Node | None = None

    def _reading(self, read: Any, *arguments: Any) -> Any:
        node, other = current_node(), self._reader
        if node is None or (other is not None and other is not node and not other.ended):
            who = "code outside of a node" if node is None else f"{node.name}, while {other.name if other else ''} does"
            raise KernelError(f"the terminal {self._terminal.name!r} is read by {who}: one node at a time can read it")
        self._reader = node
        try:
            return read(*arguments)
        finally:
            self._reader = None

    def read(self, size: int | None = -1, /) -> str:
        return str(self._reading(super().read, size))

    def readline(self, size: int = -1, /) -> str:  # type: ignore[override]
        return str(self._reading(super().readline, size))

    def __next__(self) -> str:  # type: ignore[override]
        return str(self._reading(super().__next__))


_TERMINALS, _NAME = "terminals", "terminal"


def terminals_of(kernel: Kernel) -> dict[str, Terminal]:
    """The terminals of a run, by name."""
    terminals = kernel.own.setdefault(_TERMINALS, {})
    assert isinstance(terminals, dict)
    return terminals


def terminal_for(kernel: Kernel, name: str, record: Callable[[str], None] = lambda text: None) -> Terminal:
    """The terminal with this name; a new one, if there is none."""
    terminals = terminals_of(kernel)
    if name not in terminals:
        terminals[name] = Terminal(kernel, name, record)
    return terminals[name]


def sits_at(node: Node, name: str, *, is_main: bool) -> None:
    """Let a node be in the process of this name, whose terminal it reads; ctrl-c interrupts its main thread."""
    node.own[_NAME] = name
    terminal = terminals_of(node.kernel).get(name)
    if terminal is not None and is_main:
        terminal.belongs_to(node)


def terminal_of(node: Node) -> Terminal | None:
    """The terminal that a node reads: its process's, the one of its own name, or the one without a name; else None."""
    terminals = terminals_of(node.kernel)
    terminal = next((terminals[name] for name in (node.own.get(_NAME), node.name, "") if name in terminals), None)
    if terminal is not None:
        terminal.belongs_to(node)
    return terminal
