"""The commands `query`, `live` and `mcp` of `hricdv report`: their options and functions, listed in `COMMANDS`.

The feature registry adds them; they call `answers.ask`, `serve_live` and `server.serve`.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from pytest_hricdv.report.view import ReportCommand
from pytest_hricdv.results.codec import ReportError, load

OK = 0


def _add_query(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("report", type=Path, metavar="REPORT", help="a report folder or its report.json")
    add("what", metavar="WHAT", help="status, causes, open, changes, test ID, requirement ID or coverage FILE")
    add("name", metavar="NAME", nargs="?", default="", help="of the test, requirement or file")


def _query(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.answers.answers import ask

    print(json.dumps(ask(load(options.report), options.what, options.name), indent=1, ensure_ascii=False))
    return OK


def _add_mcp(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("project", type=Path, metavar="DIR", nargs="?", default=Path(), help="the project (default: here)")
    add("--allow-run", action="store_true", help="let the client run tests; by default it only reads")


def _mcp(options: argparse.Namespace) -> int:
    try:
        from pytest_hricdv.extra.answers.server import serve
    except ImportError as error:
        raise ReportError(f"mcp needs {error.name}: pip install 'pytest-hricdv[mcp]'") from None
    serve(options.project, allow_run=options.allow_run)
    return OK


def _add_live(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("path", type=Path, metavar="DIR", help="a report folder, or the file of a campaign")
    add("--port", type=int, default=0, metavar="N", help="port of 127.0.0.1 (default: any free one)")


def _live(options: argparse.Namespace) -> int:
    from pytest_hricdv.extra.answers.live_server import serve_live

    serve_live(options.path, options.port)
    return OK


COMMANDS = (
    ReportCommand("query", "answer one question about a report, as JSON", _add_query, _query),
    ReportCommand("live", "show a session, a loop or a campaign while it runs, in a browser", _add_live, _live),
    ReportCommand("mcp", "serve reports over the Model Context Protocol", _add_mcp, _mcp),
)
