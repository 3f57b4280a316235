"""The bytes that the keys of a terminal send, and the attributes of a new terminal, for `terminal`."""

from __future__ import annotations

import termios
from typing import Any

KEYS = {
    "enter": b"\r",
    "tab": b"\t",
    "space": b" ",
    "backspace": b"\x7f",
    "esc": b"\x1b",
    "up": b"\x1b[A",
    "down": b"\x1b[B",
    "right": b"\x1b[C",
    "left": b"\x1b[D",
    "home": b"\x1b[H",
    "end": b"\x1b[F",
    "insert": b"\x1b[2~",
    "delete": b"\x1b[3~",
    "page-up": b"\x1b[5~",
    "page-down": b"\x1b[6~",
    **{f"f{number}": b"\x1bO" + bytes([ord("O") + number]) for number in range(1, 5)},
    **{f"ctrl-{chr(ord('a') + number)}": bytes([number + 1]) for number in range(26)},
}
"""Name of a key -> what a terminal like xterm sends for it."""


def default_attributes() -> list[Any]:
    """The attributes of a new terminal on Linux."""
    characters: list[Any] = [b"\x00"] * 32
    for index, value in (
        (termios.VINTR, b"\x03"),
        (termios.VQUIT, b"\x1c"),
        (termios.VERASE, b"\x7f"),
        (termios.VKILL, b"\x15"),
        (termios.VEOF, b"\x04"),
        (termios.VSUSP, b"\x1a"),
        (termios.VMIN, 1),
        (termios.VTIME, 0),
    ):
        characters[index] = value
    return [
        termios.ICRNL | termios.IXON,
        termios.OPOST | termios.ONLCR,
        termios.CS8 | termios.CREAD,
        termios.ISIG | termios.ICANON | termios.ECHO | termios.ECHOE | termios.ECHOK | termios.IEXTEN,
        termios.B38400,
        termios.B38400,
        characters,
    ]
