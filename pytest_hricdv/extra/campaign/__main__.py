"""Campaigns: run the tests of suites with many seeds each, on one machine or many, and report all runs together.

    hricdv campaign run --suite=rl --concretizations=41 --state=campaign.db
    hricdv campaign report --state=campaign.db

A campaign can be stopped at any time, even by kill -9 or a power failure; the same command resumes it. By default, it
runs on this machine, with one worker for each core. With --cluster=tls://HOST:8786 it runs on the workers of a Dask
scheduler (dask scheduler --protocol=tls; dask worker tls://HOST:8786 --nthreads=1). They have the project at the same
path, or receive it (--send-code). The documentation explains how to make credentials.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from pytest_hricdv._base.command_line import CommandParser, work_on_unread
from pytest_hricdv._base.message import quote, visible
from pytest_hricdv.extra.campaign import commands
from pytest_hricdv.extra.campaign.commands import USAGE
from pytest_hricdv.extra.campaign.database import MAX_K
from pytest_hricdv.extra.campaign.execution import AUDIT_PERCENT
from pytest_hricdv.extra.campaign.plan import CampaignError
from pytest_hricdv.results.codec import ReportError
from pytest_hricdv.session.remote import ClusterError

STATE = Path("campaign.db")


def main(arguments: Sequence[str] | None = None, called: str = "hricdv campaign") -> int:
    """Do what the command line says; returns the exit status: see `pytest_hricdv.extra.campaign.commands`."""
    options = _parser(called).parse_args(arguments)
    try:
        return int(options.do(options))
    except (CampaignError, ClusterError, ReportError) as error:
        print(visible(f"error: {error}"), file=sys.stderr)
        return USAGE


def _parser(called: str) -> CommandParser:
    parser = CommandParser(prog=called, description=__doc__)
    subparsers = parser.add_subparsers(required=True, metavar="COMMAND")
    _add_run(subparsers.add_parser("run", help="start a campaign, or resume it"))
    status = subparsers.add_parser("status", help="show the progress of a campaign, and its workers")
    status.set_defaults(do=commands.status)
    report = subparsers.add_parser("report", help="write the report of all runs; exit 1 where a gate fails")
    report.add_argument("-o", "--output", type=Path, default=Path("hri-report"), help="folder (default hri-report)")
    report.add_argument(
        "--most",
        type=_number,
        default=commands.MAX_LISTED,
        metavar="N",
        help=f"list all runs where they are at most N, otherwise those to keep (default {commands.MAX_LISTED})",
    )
    report.set_defaults(do=commands.report)
    export = subparsers.add_parser("export", help="write one row per run for other tools")
    export.add_argument("--parquet", type=Path, required=True, metavar="FILE", help="file to write")
    export.set_defaults(do=commands.export)
    cancel = subparsers.add_parser("cancel", help="stop a campaign that runs elsewhere in an orderly way")
    cancel.set_defaults(do=commands.cancel)
    for subparser in subparsers.choices.values():
        subparser.add_argument(
            "--state", type=Path, default=STATE, metavar="FILE", help=f"the campaign (default {STATE})"
        )
    return parser


def _add_run(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--suite", default="rl", metavar="NAME|PATH[,...]", help="as --hri-suite of pytest (default rl)")
    add("--seed", type=int, default=0, metavar="N", help="that the suite is generated from (default 0)")
    add("--tests", type=_number, metavar="N", help="abstract tests per suite (default: the method's own)")
    add("--concretizations", type=_number, default=1, metavar="K", help="seeds of each test (default 1)")
    add("--cluster", type=_address, default="local", metavar="ADDRESS", help="local, local:N or tls://HOST:PORT")
    add("--send-code", action="store_true", help="send the project to the workers, which do not have it")
    add(
        "--send-hidden",
        action="append",
        default=[],
        metavar="PATTERN",
        help="with --send-code, send hidden files with this name, as .robot.toml, too; repeatable",
    )
    add(
        "--audit",
        type=_percent,
        default=AUDIT_PERCENT,
        metavar="PCT",
        help="runs done again elsewhere (default 1 %%)",
    )
    add(
        "--run-seconds",
        type=_number,
        default=120,
        metavar="S",
        help="a run that takes longer is retried",
    )
    add("--retry-lost", action="store_true", help="run again what was lost")
    add(
        "pytest", nargs="*", metavar="ARGUMENT", help="further arguments of pytest, after --, as -- --hri-fidelity=full"
    )
    parser.set_defaults(do=commands.run)


def _number(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 20 and 1 <= int(text) <= MAX_K):
        raise argparse.ArgumentTypeError(f"{quote(text)}: expected a whole number from 1 to {MAX_K:,}")
    return int(text)


def _percent(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = -1.0
    if not 0.0 <= value <= 100.0:
        raise argparse.ArgumentTypeError(f"{text!r}: expected a share in per cent, from 0 to 100")
    return value


def _address(text: str) -> str:
    try:
        return commands.cluster_of_campaign().address(text)
    except (CampaignError, ClusterError) as error:
        raise argparse.ArgumentTypeError(str(error)) from None


if __name__ == "__main__":
    work_on_unread()
    sys.exit(main())
