"""Stand-ins of connections: sockets, and the streams of asyncio. A person is at the other end."""

from __future__ import annotations

import asyncio
import queue
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.extra.draft.stand_ins.border import RunBorder
from pytest_hricdv.extra.draft.stand_ins.channels import REST_OF_RUN_S, AsyncInbox, Convert, Inbox
from pytest_hricdv.extra.draft.stand_ins.device import Device, DeviceStandIn

READS = ("recv", "recvfrom", "readline", "read", "readuntil", "readexactly")
SENDS = ("send", "sendall", "sendto", "write")
"""Methods of connections that take and give bytes."""

PERSON = ("person", 1)
"""The address of the other end."""


@dataclass(frozen=True)
class ConnectionPort:
    """A function that makes connections.

    Args:
        streams: "start_server" or "open_connection" of asyncio; empty for a socket.
        kinds: class of a message -> the bytes, or the text, that come in.
    """

    streams: str = ""
    kinds: Mapping[type[Any], Convert] = field(default_factory=dict)

    def make(self, border: RunBorder, name: str) -> Any:
        """A socket, or the function, of a run."""
        if not self.streams:
            return SocketStandIn(border, name, Device(), Inbox(border, self.kinds))

        async def connect(*arguments: Any, **_: Any) -> Any:
            stream = StreamStandIn(border, name, AsyncInbox(border, self.kinds))
            if self.streams == "open_connection":
                return stream, stream
            return ServerStandIn(arguments[0], stream)

        return connect


class SocketStandIn(DeviceStandIn):
    """A fake of a socket, and of the only connection that it accepts."""

    def __init__(self, border: RunBorder, name: str, device: Device, inbox: Inbox) -> None:
        super().__init__(border, name, device)
        self.__dict__.update(_inbox=inbox, _is_accepted=False, _timeout_s=REST_OF_RUN_S)

    def call(self, name: str, arguments: tuple[Any, ...], named: Mapping[str, Any]) -> Any:
        """The code calls a method."""
        own = self.__dict__
        if name in SENDS:
            own["_border"].note_call(own["_name"], name, arguments, named)
            own["_border"].tell_call(own["_name"], name, arguments[:1], {})
            return len(arguments[0])
        if name in READS:
            content = self._take()
            content = content + b"\n" if name == "readline" and not content.endswith(b"\n") else content
            return (content, PERSON) if name == "recvfrom" else content
        if name == "accept":
            if own["_is_accepted"]:
                self._take()
            own["_is_accepted"] = True
            return self, PERSON
        if name in ("settimeout", "setblocking"):
            asked = arguments[0] if name == "settimeout" else None if arguments[0] else 0.0
            own["_timeout_s"] = REST_OF_RUN_S if asked is None else float(asked)
            return None
        return self if name in ("makefile", "detach", "dup") else super().call(name, arguments, named)

    def _take(self) -> bytes:
        """The next bytes; raises TimeoutError, or BlockingIOError, as a socket does."""
        own = self.__dict__
        try:
            return _bytes(own["_inbox"].get(timeout=own["_timeout_s"]))
        except queue.Empty:
            own["_border"].pass_time()
            raise (TimeoutError if own["_timeout_s"] else BlockingIOError)("nothing came") from None

    def __iter__(self) -> Iterator[Any]:
        while True:
            yield self._take().decode("utf-8", "replace")


class StreamStandIn:
    """A fake of a reader and a writer."""

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

    def at_eof(self) -> bool:
        """Nobody leaves."""
        return False

    def write(self, content: bytes) -> None:
        """The code says something."""
        self._border.note_call(self._name, "write", (content,), {})
        self._border.tell_call(self._name, "write", (content,), {})

    def writelines(self, contents: list[bytes]) -> None:
        """Likewise."""
        self.write(b"".join(contents))

    async def drain(self) -> None:
        """Return at once: all is written."""

    async def wait_closed(self) -> None:
        """It closes at once."""

    def close(self) -> None:
        """Nobody minds."""

    write_eof = close

    def is_closing(self) -> bool:
        """It never is."""
        return False

    def get_extra_info(self, *_: Any) -> Any:
        """The address, whatever is asked for."""
        return PERSON


class ServerStandIn:
    """A fake of a server: one client has connected."""

    sockets: tuple[Any, ...] = ()

    def __init__(self, function: Callable[..., Any], stream: StreamStandIn) -> None:
        made = function(stream, stream)
        self._client = asyncio.ensure_future(made) if asyncio.iscoroutine(made) else None

    async def __aenter__(self) -> ServerStandIn:
        return self

    async def __aexit__(self, *_: object) -> None:
        return None

    async def serve_forever(self) -> None:
        """Serve for the rest of the run; errors of its client are raised here."""
        if self._client is not None:
            await self._client
        await asyncio.sleep(REST_OF_RUN_S)

    async def start_serving(self) -> None:
        """It serves already."""

    async def wait_closed(self) -> None:
        """It closes at once."""

    def close(self) -> None:
        """The client stays."""

    def is_serving(self) -> bool:
        """It always is."""
        return True


def _bytes(content: Any) -> bytes:
    return content if isinstance(content, bytes) else str(content).encode()
