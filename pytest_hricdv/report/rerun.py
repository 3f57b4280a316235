"""The command that runs one test again."""

import shlex
from collections.abc import Mapping, Sequence
from typing import Any

_JUDGING = ("--hri-replay-anyway", "--hri-known", "--hri-strict")
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


def replay(file: str, more: Sequence[str] = ()) -> str:
    """A line for the shell: `pytest --hri-replay=hri-report/failures/rl-leg1-3fa2b1c0.json`.

    Args:
        file: the replay file.
        more: as for `command`; only what decides on what fails matters to a test that is in a file.
    """
    options = [f"--hri-replay={file}", *(each for each in more if each.startswith(_JUDGING))]
    return " ".join(["pytest", *map(_option, options)])


def told(
    test: Mapping[str, Any], suite: str | None, seed: int | None, more: Sequence[str] = (), file: str | None = None
) -> list[str]:
    """How to run a test again, in a few lines for people.

    Args:
        test: a test of the report.
        suite: as for `command`; empty for a test that came out of a replay file, None for the suite of the test.
        seed: as for `command`; None for a test function that somebody wrote, which no suite has.
        more: as for `command`.
        file: the test's replay file, where there is one.
    """
    if seed is None:
        return ["run it again:", f"  pytest {_quoted(test['nodeid'])}"]
    again = file if suite == "" else None
    if again:
        return ["run it again:", f"  {replay(again, more)}"]
    lines = ["run it again:", f"  {command(test, suite or test['suite'], seed, more)}"]
    return [*lines, "or the very same run, from its file:", f"  {replay(file, more)}"] if file else lines


def again(report: Mapping[str, Any], test: Mapping[str, Any]) -> list[str]:
    """How to run a test of a report again, in a few lines for people."""
    rerun = report.get("rerun", {})
    seeds = {suite["name"]: suite["seed"] for suite in report["suites"]}
    return told(test, rerun.get("suite"), seeds.get(test["suite"], 0), rerun.get("options", ()), test.get("replay"))


def _quoted(nodeid: str) -> str:
    # Brackets need quotes in some shells. Double ones are understood by every shell, so they are used as long as
    # nothing in the name has a meaning inside of them.
    if all(char.isalnum() or char in _PLAIN_IN_DOUBLE_QUOTES for char in nodeid):
        return f'"{nodeid}"'
    return shlex.quote(nodeid)


def _option(text: str) -> str:
    return text if all(char.isalnum() or char in "-_=/.,:" for char in text) else shlex.quote(text)
