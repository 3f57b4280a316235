"""Runs systems on the real middleware: `python -m tests.extra.ros2.differential`, an order a line, and a reply a line.

An order is `{"system": NAME, "domain": NUMBER, "folder": PATH}`; the reply `{"logs": ..., "faults": ...}` has, for each
process, the lines of its log, and what is wrong with how it ended. `rclpy` is imported once: processes are forks.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import struct
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import rclpy

from tests.extra.ros2.differential import system
from tests.extra.ros2.differential.common import Main

LIMIT_S = 60.0
_GRACE_S = 10.0
"""How long a server may take to end after its signal: an executor looks for it at least each 5 s."""

_SET_FLAGS, _UP = 0x8914, 0x1
"""As `SIOCSIFFLAGS` and `IFF_UP` of Linux."""


def _switch_loopback_on() -> None:
    """A new namespace has a loopback that is off; elsewhere it is on, and who may not do this need not."""
    with suppress(PermissionError), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        import fcntl

        fcntl.ioctl(any_socket, _SET_FLAGS, struct.pack("16sH14x", b"lo", _UP))


def _started(name: str, body: Main, folder: Path) -> int:
    """Fork a process that runs it; its number."""
    number = os.fork()
    if number:
        return number
    with (folder / f"{name}.err").open("w", buffering=1) as errors, (folder / name).open("w", buffering=1) as file:
        os.dup2(errors.fileno(), 1)
        os.dup2(errors.fileno(), 2)
        _run(body, lambda *line: print(json.dumps(line or None), file=file))
        sys.exit()  # as a program ends, so that it leaves the graph


def _run(body: Main, log: Callable[..., None]) -> None:
    """Run a process; at the end of its log is a line of its own, as `rclpy` may crash when Python ends."""
    sys.argv[1:] = []
    try:
        body(log)
        rclpy.try_shutdown()
        log()
    except BaseException:
        traceback.print_exc()


def _has_ended(number: int, end_s: float) -> bool:
    """Wait until then for a process to end; one that does not is killed."""
    while time.monotonic() < end_s:
        if os.waitpid(number, os.WNOHANG)[0]:
            return True
        time.sleep(0.01)
    os.kill(number, signal.SIGKILL)
    os.waitpid(number, 0)
    return False


def _obey(order: dict[str, Any]) -> dict[str, Any]:
    """Run a system; the reply."""
    folder, chosen = Path(order["folder"]), system(order["system"])
    os.environ["ROS_DOMAIN_ID"] = str(order["domain"])
    servers = {name: _started(name, body, folder) for name, body in chosen.servers.items()}
    ending = {name: _started(name, body, folder) for name, body in chosen.ending.items()}
    end_s = time.monotonic() + LIMIT_S
    are_over = [_has_ended(number, end_s) for number in ending.values()]
    for number in servers.values():
        os.kill(number, signal.SIGINT)
    are_over += [_has_ended(number, time.monotonic() + _GRACE_S) for number in servers.values()]
    logs, faults = {}, {}
    for name, is_over in zip((*ending, *servers), are_over, strict=True):
        logs[name] = [json.loads(line) for line in (folder / name).read_text().splitlines()]
        if not is_over or logs[name][-1:] != [None]:
            faults[name] = f"{'failed' if is_over else 'did not end'}: {(folder / f'{name}.err').read_text()}"
        logs[name] = [line for line in logs[name] if line is not None]
    return {"logs": logs, "faults": faults}


def main(read: Callable[[], str] = sys.stdin.readline) -> None:
    """Obey until there are no more orders."""
    _switch_loopback_on()
    print("ready", flush=True)
    while line := read():
        print(json.dumps(_obey(json.loads(line))), flush=True)


if __name__ == "__main__":
    main()
