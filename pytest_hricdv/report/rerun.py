"""The command that runs one test again."""

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

_PLAIN_IN_DOUBLE_QUOTES = set("[]/.:-_ ()=,+@%#~{}&;<>|*?'")


def command(test: Mapping[str, Any], suite: str, seed: int, more: Sequence[str] = ()) -> str:
    """A line for the shell: `pytest "tests/..[rl-leg1-3fa2b1c0]" --hri-suite=rl --hri-seed=0`.

    Args:
        test: a test of the report.
        suite: what `--hri-suite` is given to have the test generated.
        seed: the suite's seed, not the test's own.
        more: further options that the run was given and that decide which tests there are, or what fails.
    """
    options = [f"--hri-suite={suite}", f"--hri-seed={seed}", *more]
    return " ".join(["pytest", _quoted(test["nodeid"]), *map(_option, options)])


def _quoted(nodeid: str) -> str:
    # Brackets need quotes in some shells. Double ones are understood by every shell, so they are used as long as
    # nothing in the name has a meaning inside of them.
    if all(char.isalnum() or char in _PLAIN_IN_DOUBLE_QUOTES for char in nodeid):
        return f'"{nodeid}"'
    return shlex.quote(nodeid)


def _option(text: str) -> str:
    return text if all(char.isalnum() or char in "-_=/.,:" for char in text) else shlex.quote(text)
