"""Tests for robots that work with people: begin a project, work with models, reports and campaigns.

    hricdv init coffee && cd coffee    # a project that runs
    pytest                             # its tests are run by pytest; see pytest --help for --hri-*

`python -m pytest_hricdv` is the same command.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.metadata import version
from types import MappingProxyType
from typing import NamedTuple

from pytest_hricdv._base.command_line import CommandParser, end_with_reader, work_on_unread
from pytest_hricdv.registry import offers
from pytest_hricdv.skeleton.skeleton import add_commands


class CommandGroup(NamedTuple):
    """A command in another module, which is imported only when the command is used.

    Args:
        purpose: for `--help`.
        module: its `main` gets the arguments, and what the command is called.
        first: arguments in front of those that were given.
    """

    purpose: str
    module: str
    first: tuple[str, ...] = ()


GROUPS = MappingProxyType(
    {
        "lint": CommandGroup("find probable mistakes in models, without running them", "pytest_hricdv.bdi.__main__",
                             ("lint",)),
        "model": CommandGroup("run a model, trace why it acts, check a folder of models", "pytest_hricdv.bdi.__main__"),
        "report": CommandGroup("merge, gate, export and rebuild reports", "pytest_hricdv.report.__main__"),
        "campaign": CommandGroup("run each test with many seeds, on several machines", "pytest_hricdv.campaign"),
    }
)  # fmt: skip
"""All commands but those of the skeleton and of features, which are parsed here."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the command line says; returns the exit status."""
    argv = sys.argv[1:] if arguments is None else [*arguments]
    group = GROUPS.get(argv[0]) if argv else None
    if group is not None:
        called = "hricdv" if group.first else f"hricdv {argv[0]}"
        return int(import_module(group.module).main([*group.first, *argv[1:]], called))
    parser = _parser()
    if not argv:
        parser.print_help()
        return 0
    options = parser.parse_args(argv)
    return int(options.do(options))


def run() -> None:
    """The console script."""
    (end_with_reader if sys.argv[1:2] == ["model"] else work_on_unread)()
    sys.exit(main())


def _parser() -> CommandParser:
    parser = CommandParser(prog="hricdv", description=__doc__)
    parser.add_argument("--version", action="version", version=f"hricdv {version('pytest-hricdv')}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND", title="commands, each with --help")
    add_commands(commands)
    for add_command in offers("command", "add_command"):
        add_command(commands)
    for name, group in GROUPS.items():
        commands.add_parser(name, help=group.purpose)
    return parser


if __name__ == "__main__":
    run()
