"""`hricdv report live DIR`: shows a running session, loop or campaign on a page, for browsers on this machine.

The command calls `serve_live`. A `LiveSource` reads the progress as a `LiveState`; a `LiveServer` serves it by HTTP.
"""

from __future__ import annotations

import datetime
import json
import os
import signal
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, ClassVar, TypeVar

from msgspec.structs import replace

from pytest_hricdv._base.message import harmless_line
from pytest_hricdv.extra.answers.answers import status
from pytest_hricdv.registry import offers
from pytest_hricdv.report import html
from pytest_hricdv.report.files import PAGE_NAME
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.report.verdict import verdict
from pytest_hricdv.results.codec import REPORT_NAME, ReportError, load
from pytest_hricdv.results.folder_files import PROGRESS_FILE as LOOP
from pytest_hricdv.results.folder_files import LoopProgress, read_progress
from pytest_hricdv.results.journal import NAME, Journal, ResultRecord, records
from pytest_hricdv.results.model import Report
from pytest_hricdv.results.report_builder import rebuild
from pytest_hricdv.session.progress import ENOUGH, time_left

SHARE = 0.1
"""Maximum share of the time spent on reading; a large report, which takes long to read, is read less often."""

SILENT_S = 30.0
"""If nothing has changed for longer than this (s), the page says so."""


@dataclass(frozen=True)
class LiveState:
    """The progress of something that runs.

    Args:
        what: session, loop or campaign.
        is_over: whether it has ended.
        done: number of tests or runs with a result.
        total: number of all.
        workers: processes that run them.
        rate_s: mean time for one of them (s); None if it is not known yet.
        report: of what was done; None if there is no result yet, and for a loop.
        loop: the progress of a closing loop.
        silent_s: time since it last wrote something (s).
    """

    what: str
    is_over: bool
    done: int
    total: int
    workers: int
    rate_s: float | None
    report: Report | None = None
    loop: LoopProgress | None = None
    silent_s: float = 0.0

    def data(self) -> dict[str, Any]:
        """As the page reads it."""
        left_s = None if self.is_over or self.rate_s is None else self.rate_s * (self.total - self.done) - self.silent_s
        return {
            "what": self.what,
            "over": self.is_over,
            "done": self.done,
            "total": self.total,
            "workers": plural(self.workers, "worker") if self.workers else "",
            "left": "" if left_s is None else time_left(max(0.0, left_s)),
            "silent": f"silent for {self.silent_s:.0f} s" if self.silent_s >= SILENT_S else "",
            "verdicts": self._verdicts(),
            "causes": [*self._causes()],
            "open": [] if self.loop is None else [*self.loop.open],
            "has_page": self.report is not None,
        }

    def _verdicts(self) -> list[tuple[str, int, int, int]]:
        """Requirement, how often it passed, failed, and was not checked."""
        if self.report is None:
            return [] if self.loop is None else [*self.loop.verdicts]
        counts = status(self.report)["requirements"]
        return [(name, count["passed"], count["failed"], count["not_checked"]) for name, count in counts.items()]

    def _causes(self) -> Iterator[str]:
        if self.report is None:
            yield from () if self.loop is None else self.loop.causes
            return
        found = verdict(self.report)
        if found.causes is not None and found.causes.causes:
            yield from (cause.title for cause in found.causes.causes if not cause.is_known)
            return
        for group in found.new:
            situation = f" ({group.situation})" if group.situation else ""
            yield f"{group.requirement}{situation}: {plural(len(group.tests), 'test')}"


class LiveSource:
    """Reads the progress from a report folder, or from the file of a campaign."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.version = 0
        self._scratch = TemporaryDirectory(prefix="hricdv-live-")
        self._stamp: object = None
        self._next_s = 0.0
        self._state: LiveState | None = None
        self._files: tuple[int, dict[str, str]] = (0, {})

    def close(self) -> None:
        """Remove temporary files."""
        self._scratch.cleanup()

    def state(self) -> LiveState | None:
        """The state, read again if something was written; None if nothing has begun.

        Raises:
            ReportError: the files cannot be read.
        """
        began_s, stamp = time.monotonic(), self._stamp_now()
        if stamp != self._stamp and began_s >= self._next_s:
            self._state = self._look()
            self._stamp = stamp
            self.version += 1
            self._pause(began_s)
        return self._state

    def files(self) -> dict[str, str]:
        """The page of the tests that have a result, and the files next to it; empty without a report."""
        state = self.state()
        if state is None or state.report is None:
            return {}
        if self._files[0] != self.version:
            began_s = time.monotonic()
            page, packs = html.page(state.report)
            self._files = self.version, {**packs, PAGE_NAME: page}
            self._pause(began_s)
        return self._files[1]

    def _pause(self, began_s: float) -> None:
        """Read nothing for a while after reading since `began_s`."""
        now_s = time.monotonic()
        self._next_s = max(self._next_s, now_s + (now_s - began_s) / SHARE)

    def _stamp_now(self) -> tuple[tuple[int, int] | None, ...]:
        """Changes whenever something is written, or a file comes or goes."""
        names = [self.path / name for name in ("", NAME, LOOP, REPORT_NAME)]
        return tuple(map(_stamp, names if self.path.is_dir() else [self.path, Path(f"{self.path}-wal")]))

    def _look(self) -> LiveState | None:
        if not self.path.is_dir():
            for look in offers("live", "look"):
                return LiveState(**look(self.path, Path(self._scratch.name)))
            raise ReportError(f"{self.path}: no such report folder")
        loop, stamps = read_progress(self.path), [_stamp(self.path / name) or (0, 0) for name in (NAME, LOOP)]
        if loop is not None and stamps[0] <= stamps[1]:  # a newer journal is that of a session after a killed loop
            rate_s = loop.wall_s / loop.done if loop.done else None
            return LiveState("loop", False, loop.done, loop.most, loop.workers, rate_s, loop=loop)
        try:
            written = records(self.path / NAME)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise ReportError(f"{self.path / NAME}: cannot be read: {error.strerror or error}") from None
        journal = Journal()
        for record in written:
            journal.add(record)
        if journal.is_ended and (self.path / REPORT_NAME).is_file():
            report = load(self.path)
            return LiveState("session", True, report.reported, report.selected, report.workers, None, report)
        return _journal_state(journal, [record.at_s for record in written if isinstance(record, ResultRecord)])


def _stamp(file: Path) -> tuple[int, int] | None:
    try:
        status = os.stat(file)
    except OSError:
        return None
    return status.st_mtime_ns, status.st_size


def _journal_state(journal: Journal, finished: Sequence[float]) -> LiveState | None:
    if journal.declared is None:
        return None
    try:
        report, _ = rebuild(journal)
    except ValueError as error:
        raise ReportError(f"{NAME}: no report can be made of it: {error}") from None
    for of_part in offers("merging", "rebuilt"):
        report = of_part(report, journal.kept)
    if not journal.is_ended:
        report = replace(report, problems=())  # what follows the tests is still to come
    # When the first test began is not known.
    rate_s = (finished[-1] - finished[0]) / (len(finished) - 1) if len(finished) > ENOUGH else None
    done, total, silent_s = report.reported, report.selected, _silent_s(journal)
    return LiveState("session", journal.is_ended, done, total, report.workers, rate_s, report, silent_s=silent_s)


def _silent_s(journal: Journal) -> float:
    if journal.is_ended or not journal.began:
        return 0.0
    began = datetime.datetime.fromisoformat(journal.began[-1].utc)
    elapsed_s = (datetime.datetime.now(datetime.UTC) - began).total_seconds()
    return max(0.0, elapsed_s - (journal.wall_s - journal.earlier_s))


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
