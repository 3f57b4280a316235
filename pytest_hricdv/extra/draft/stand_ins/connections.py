"""`ConnectionPort`: stand-ins for sockets, asyncio streams and servers of libraries.

The conftest of a draft declares it; its `Driver` and `Replace` call `make` in each run. The other end of a connection
is the person of the test: the code receives what the person says, and what it sends is recorded.
"""

from __future__ import annotations

import asyncio
import inspect
import queue
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.channels import AsyncInbox, Convert, Inbox
from pytest_hricdv.extra.draft.stand_ins.neutral import REST_OF_RUN_S, Lenient
from pytest_hricdv.extra.draft.stand_ins.parts import DeviceStandIn

READS = ("recv", "recvfrom", "readline", "read", "readuntil", "readexactly")
SENDS = ("send", "sendall", "sendto", "write")
"""Methods by which code receives and sends bytes, as analyses of drafts know them (`READS`, too)."""

POSITIONAL = (inspect.Parameter.POSITIONAL_ONLY, inspect.Parameter.POSITIONAL_OR_KEYWORD)

PERSON = ("person", 1)
"""The address of the other end."""


@dataclass(frozen=True)
class ConnectionPort:
    """A port of a drafted testbench that makes connections.

    Args:
        streams: "start_server" or "open_connection" of asyncio, or the name of a function of a library that gives texts
            to the code, as "serve"; empty for a socket.
        kinds: class of a message -> the bytes, or the text, that come in.
    """

    streams: str = ""
    kinds: Mapping[type[Any], Convert] = field(default_factory=dict)

    def make(self, border: RunBorder, name: str) -> Any:
        """A socket, or the function, of a run."""
        if not self.streams:
            return SocketStandIn(border, name, Inbox(border, self.kinds))

        def serve(function: Callable[..., Any], *_: Any, **__: Any) -> ServerStandIn:
            kind = StreamStandIn if self.streams == "start_server" else TextStandIn
            return ServerStandIn(function, lambda: kind(border, name, AsyncInbox(border, self.kinds)))

        async def connect(*_: Any, **__: Any) -> tuple[StreamStandIn, StreamStandIn]:
            stream = StreamStandIn(border, name, AsyncInbox(border, self.kinds))
            return stream, stream

        return connect if self.streams == "open_connection" else serve


def _sender(name: str) -> Callable[..., int]:
    """A method by which the code says something."""

    def send(socket: SocketStandIn, content: bytes, *_: Any) -> int:
        socket._run.note_call(socket._path, name, (content,), {})
        socket._run.tell_call(socket._path, name, (content,), {})
        return len(content)

    return send


class SocketStandIn(DeviceStandIn):
    """A fake of a socket, and of the only connection that it accepts."""

    def __init__(self, border: RunBorder, name: str, inbox: Inbox) -> None:
        super().__init__(name)
        self.__dict__.update(_run=border, _inbox=inbox, _is_accepted=False, _timeout_s=REST_OF_RUN_S)

    send, sendall, sendto, write = map(_sender, SENDS)

    def recv(self, *_: Any) -> bytes:
        """The next bytes; raises TimeoutError, or BlockingIOError, as a socket does."""
        try:
            return _bytes(self._inbox.get(timeout=self._timeout_s))
        except queue.Empty:
            self._run.pass_time()
            raise (TimeoutError if self._timeout_s else BlockingIOError)("nothing came") from None

    read = recv

    def recvfrom(self, *_: Any) -> tuple[bytes, tuple[str, int]]:
        """Likewise, with the address of the other end."""
        return self.recv(), PERSON

    def readline(self, *_: Any) -> bytes:
        """The next line."""
        return self.recv().rstrip(b"\n") + b"\n"

    def __iter__(self) -> Iterator[Any]:
        while True:
            yield self.recv().decode("utf-8", "replace")

    def accept(self) -> tuple[SocketStandIn, tuple[str, int]]:
        """The only connection; the next one does not come."""
        if self._is_accepted:
            self.recv()
        self.__dict__["_is_accepted"] = True
        return self, PERSON

    def settimeout(self, value: float | None) -> None:
        """How long it waits (s)."""
        self.__dict__["_timeout_s"] = REST_OF_RUN_S if value is None else float(value)

    def block(self, flag: bool) -> None:
        """Whether it waits."""
        self.settimeout(None if flag else 0.0)

    setblocking = block

    def makefile(self, *_: Any, **__: Any) -> SocketStandIn:
        """Itself."""
        return self

    detach = dup = makefile


class StreamStandIn(Lenient):
    """A fake of a reader and a writer, from which nobody leaves."""

    def __init__(self, border: RunBorder, name: str, inbox: AsyncInbox) -> None:
        self._border, self._name, self._inbox = border, name, inbox

    async def readline(self, *_: Any) -> bytes:
        """The next line; it waits for one, if need be for the rest of the run."""
        return _bytes(await self._inbox.get()).rstrip(b"\n") + b"\n"

    read = readuntil = readexactly = readline

    def __aiter__(self) -> StreamStandIn:
        return self

    async def __anext__(self) -> bytes:
        return await self.readline()

    def write(self, content: bytes) -> None:
        """The code says something."""
        self._say("write", content)

    def _say(self, name: str, content: Any) -> None:
        self._border.note_call(self._name, name, (content,), {})
        self._border.tell_call(self._name, name, (content,), {})

    def writelines(self, contents: list[bytes]) -> None:
        """Likewise."""
        self.write(b"".join(contents))

    def get_extra_info(self, *_: Any) -> Any:
        """The address, whatever is asked for."""
        return PERSON


class TextStandIn(StreamStandIn):
    """A fake of the connection of a library: both ends give each other whole texts."""

    async def recv(self, *_: Any) -> Any:
        """The next text, likewise."""
        return await self._inbox.get()

    readline = read = receive = receive_text = __anext__ = recv

    async def send(self, content: Any, *_: Any) -> None:
        """The code says something."""
        self._say("send", content)

    send_text = send


class ServerStandIn(Lenient):
    """A fake of a server to which one client has connected."""

    sockets: tuple[Any, ...] = ()
    _client: asyncio.Future[Any] | None = None

    def __init__(self, function: Callable[..., Any], connect: Callable[[], StreamStandIn]) -> None:
        self._function, self._connect = function, connect

    def __await__(self) -> Generator[Any, Any, ServerStandIn]:
        return self.__aenter__().__await__()

    async def __aenter__(self) -> ServerStandIn:
        if self._client is None:
            parameters = inspect.signature(self._function).parameters.values()
            stream = self._connect()
            made = self._function(
                *(stream for part in parameters if part.kind in POSITIONAL and part.default is part.empty)
            )
            self._client = asyncio.ensure_future(made) if asyncio.iscoroutine(made) else None
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    async def serve_forever(self) -> None:
        """Serve for the rest of the run; errors of its client are raised here."""
        if self._client is not None:
            await self._client
        await asyncio.sleep(REST_OF_RUN_S)


def _bytes(content: Any) -> bytes:
    return content if isinstance(content, bytes) else str(content).encode()
