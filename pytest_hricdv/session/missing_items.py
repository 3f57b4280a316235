"""Generated tests that the command line names and that do not exist: says why that may be."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pytest_hricdv.session.options import Options

_NAMED = re.compile(r"::[^\[]*\[.*?(?P<id>[A-Za-z0-9_]+(?:-[A-Za-z0-9_]+)*-[0-9a-f]{8}(?:[0-9a-f]{8})?(?:-k\d+)?)\b")


def hint(arguments: Sequence[str], options: Options | None) -> str:
    """What to say of node ids that pytest did not find; empty when none of them is a generated test's.

    Args:
        arguments: what the command line named.
        options: in force; None where no suite is active.
    """
    named = [match["id"] for argument in arguments if (match := _NAMED.search(argument))]
    if not named:
        return ""
    if options is None:
        return (
            f"\n{named[0]} is the id of a generated test, and no suite is active: give the --hri-suite that it is of, "
            "or set hri_suite in the ini file, so that IDEs find it, too"
        )
    if options.replay:
        return f"\n{named[0]} is the id of a generated test, and --hri-replay has the tests of its files only"
    return (
        f"\n{named[0]} is the id of a generated test, and is not among those of --hri-suite={options.suites} "
        f"--hri-seed={options.seed}: which tests there are depends on suite, seed, --hri-tests, --hri-concretizations, "
        "and on models and belief space"
    )
