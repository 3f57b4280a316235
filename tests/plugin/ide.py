"""An IDE's debugger, as a debug adapter sees it."""

from __future__ import annotations

import json
import os
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

PATIENCE_S = 60
"""For each thing that an IDE's debugger is asked."""


class Client:
    """An IDE as a debug adapter sees it (Debug Adapter Protocol): counts where the program stops, and goes on."""

    def __init__(self, connection: socket.socket) -> None:
        self._stream = connection.makefile("rwb")
        self._number = 0

    def ask(self, command: str, **arguments: Any) -> None:
        """Send a request."""
        self._number += 1
        body = {"seq": self._number, "type": "request", "command": command, "arguments": arguments}
        text = json.dumps(body).encode()
        self._stream.write(b"Content-Length: %d\r\n\r\n%s" % (len(text), text))
        self._stream.flush()

    def told(self) -> Iterator[dict[str, Any]]:
        """What the adapter says, to the end of the program."""
        while header := self._stream.readline():
            if header.startswith(b"Content-Length"):
                self._stream.readline()
                yield json.loads(self._stream.read(int(header.split()[1])))


def under_an_ide(
    command: tuple[str, ...],
    folder: Path,
    endpoints: Path,
    converse: Callable[[Client], None],
    environment: Mapping[str, str] | None = None,
) -> str:
    """What Python prints that runs this under debugpy, while a client converses with the adapter.

    Args:
        command: of Python.
        folder: to run in.
        endpoints: a file in which the adapter says where it is.
        converse: returns when the program has ended.
        environment: variables beside those there are.
    """
    told = {"DEBUGPY_ADAPTER_ENDPOINTS": str(endpoints), "DEBUGPY_PROCESS_SPAWN_TIMEOUT": str(PATIENCE_S)}
    arguments = (sys.executable, "-Xfrozen_modules=off", "-m", "debugpy", "--listen", "0", "--wait-for-client")
    with subprocess.Popen(
        [*arguments, *command],
        cwd=folder,
        env={**os.environ, **told, **(environment or {})},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
    ) as program:
        try:
            with socket.create_connection(_address(endpoints, program), timeout=PATIENCE_S) as connection:
                converse(Client(connection))
        except BaseException:
            program.kill()
            raise
        assert program.stdout is not None
        return program.stdout.read().decode()


def _address(endpoints: Path, program: subprocess.Popen[bytes]) -> tuple[str, int]:
    """Where the adapter waits for the IDE, once it has said so in a file; who comes sooner may be forgotten."""
    while program.poll() is None:
        try:
            client = json.loads(endpoints.read_text())["client"]
        except (FileNotFoundError, json.JSONDecodeError):
            time.sleep(0.02)  # it only asks again: what it waits for is the file
            continue
        return client["host"], client["port"]
    pytest.fail("the debugger did not start")
