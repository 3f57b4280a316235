"""Commands on reports that optional parts add to `python -m pytest_hricdv.report`."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from dataclasses import dataclass

from pytest_hricdv.registry import offers


@dataclass(frozen=True)
class Command:
    """A command.

    Args:
        name: of the command.
        purpose: what it does, for `--help`.
        add_arguments: adds its arguments to its parser.
        do: does it; returns the exit status, and raises ReportError for a report that cannot be used.
    """

    name: str
    purpose: str
    add_arguments: Callable[[argparse.ArgumentParser], None]
    do: Callable[[argparse.Namespace], int]


def commands_of_parts() -> tuple[Command, ...]:
    """Those of all parts."""
    return tuple(command for offered in offers("commands", "COMMANDS") for command in offered)
