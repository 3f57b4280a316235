"""What a program reads from its terminal in all modes: run at a real terminal, and at a simulated one."""

from __future__ import annotations

import json
import os
import select
import sys
import termios
import tty
from collections.abc import Callable
from typing import Any

KEYS = [
    b"ab\x7fc\r",
    b"x\x15yz\r",
    b"\x1b[A",
    b"\r\x03\x04",
    b"q\x04",
    b"\x04",
    b"zz\r",
    b"one\rtwo\r",
    b"x\x7fe\r",
    b"gone\x03",
    b"after\r",
]
"""What is typed at each announcement."""


def read(announce: Callable[[], None]) -> list[Any]:
    """What is read; `announce` is called before each reading, and then keys come."""
    seen: list[Any] = []
    cooked = termios.tcgetattr(0)
    seen.append([bool(cooked[3] & flag) for flag in (termios.ICANON, termios.ISIG, termios.ECHO)])
    seen.append([bool(cooked[0] & flag) for flag in (termios.ICRNL, termios.INLCR, termios.IGNCR)])
    announce()
    seen.append(input())
    announce()
    seen.append(sys.stdin.readline())
    tty.setcbreak(0)
    announce()
    seen.append(sys.stdin.read(1))
    seen.append([len(ready) for ready in select.select([sys.stdin], [], [], 0)])
    seen.append(sys.stdin.read(2))
    tty.setraw(0)
    announce()
    seen.append(os.read(0, 10).hex())
    waits = termios.tcgetattr(0)
    waits[6][termios.VMIN], waits[6][termios.VTIME] = 0, 1
    termios.tcsetattr(0, termios.TCSANOW, waits)
    seen.append(os.read(0, 1).hex())
    termios.tcsetattr(0, termios.TCSANOW, cooked)
    for _ in range(2):
        announce()
        seen.append(os.read(0, 10).hex())
    announce()
    seen.append(len(select.select([0], [], [], None)[0]))
    tty.setraw(0)  # forgets what was typed
    seen.append(len(select.select([0], [], [], 0)[0]))
    termios.tcsetattr(0, termios.TCSANOW, cooked)
    announce()
    while len(seen) < 15:
        seen.append(os.read(0, 100).hex())  # a line at a time
    announce()
    seen.append(sys.stdin.readline())
    announce()
    try:
        seen.append(sys.stdin.readline())
    except KeyboardInterrupt:
        seen.append("interrupted")
    announce()
    seen.append(sys.stdin.readline())
    return seen


if __name__ == "__main__":
    result = read(lambda: print("READY", flush=True))
    print("RESULT", json.dumps(result), flush=True)
