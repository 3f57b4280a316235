"""`hricdv report live DIR`: the page of a running session, loop or campaign, for browsers on this machine."""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from typing import ClassVar, TypeVar

from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.extra.answers.live_state import LiveSource
from pytest_hricdv.results.codec import ReportError

Answer = TypeVar("Answer")
HOST = "127.0.0.1"
POLICY = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; frame-src 'self'; img-src data:"
_TYPES = {".html": "text/html; charset=utf-8", ".js": "text/javascript", ".css": "text/css"}


class LiveServer(ThreadingHTTPServer):
    """Serves one source, on the loopback interface only.

    Args:
        source: what it shows.
        port: 0 for any free port.
    """

    daemon_threads = True

    def __init__(self, source: LiveSource, port: int) -> None:
        super().__init__((HOST, port), _Handler)
        self.source = source
        self.lock = threading.Lock()

    @property
    def address(self) -> str:
        """Its address for browsers."""
        return f"http://{HOST}:{self.server_address[1]}/"


class _Handler(BaseHTTPRequestHandler):
    server: LiveServer
    server_version, sys_version = "hricdv", ""
    names: ClassVar[dict[str, str]] = {"/": "live.html", "/live.js": "live.js", "/live.css": "live.css"}

    def do_GET(self) -> None:
        """Answers a request for the frame, the state, or the page in the frame."""
        port = self.server.server_address[1]
        if self.headers.get("Host") not in (f"{HOST}:{port}", f"localhost:{port}"):  # a page of another site asks
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path in self.names:
            name = self.names[self.path]
            self._send(name, files(__package__).joinpath("page", name).read_text(encoding="utf-8"), policy=POLICY)
        elif self.path == "/status":
            self._send("status", self._within_lock(self._status))
        elif self.path.startswith("/report/"):
            name = self.path.removeprefix("/report/").partition("?")[0] or "index.html"
            text = self._within_lock(self.server.source.files).get(name)
            if text is None:
                self.send_error(HTTPStatus.NOT_FOUND)
            else:
                self._send(name, text)
        else:
            self.send_error(HTTPStatus.NOT_FOUND)

    def _status(self) -> str:
        source = self.server.source
        try:
            state = source.state()
        except ReportError as error:
            return json.dumps({"problem": harmless_line(str(error))})
        name = str(source.path)
        return json.dumps({"version": source.version, "name": name, **({} if state is None else state.data())})

    def _within_lock(self, work: Callable[[], Answer]) -> Answer:
        with self.server.lock:
            return work()

    def _send(self, name: str, text: str, policy: str = "") -> None:
        data = text.encode("utf-8", "backslashreplace")
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", _TYPES.get(Path(name).suffix, "application/json"))
        self.send_header("Content-Length", str(len(data)))
        self.send_header("Cache-Control", "no-store")
        self.send_header("X-Content-Type-Options", "nosniff")
        if policy:
            self.send_header("Content-Security-Policy", policy)
        self.end_headers()
        self.wfile.write(data)

    def log_message(self, format: str, *args: object) -> None:
        """Requests are not logged."""


def serve_live(path: Path, port: int) -> None:
    """Serve until Ctrl-C or SIGTERM.

    Raises:
        ReportError: there is nothing at the path, or the port is in use.
    """
    if not path.exists():
        raise ReportError(f"{path}: no such report folder, and no such campaign")
    if threading.current_thread() is threading.main_thread():
        signal.signal(signal.SIGTERM, signal.default_int_handler)  # what it has unpacked is removed
    source = LiveSource(path)
    try:
        with LiveServer(source, port) as server:
            print(harmless_line(f"{server.address} shows {path}; Ctrl-C ends it"), flush=True)
            server.serve_forever()
    except OSError as error:
        raise ReportError(f"--port={port}: {error.strerror or error}") from None
    except KeyboardInterrupt:
        print()
    finally:
        source.close()
