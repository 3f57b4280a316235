"""Shell commands that run a test again."""

import shlex
from collections.abc import Sequence

from pytest_hricdv.results.model import Report, TestResult

_JUDGING = ("--hri-replay-anyway", "--hri-known", "--hri-strict")
_PLAIN_IN_DOUBLE_QUOTES = set("[]/.:-_ ()=,+@%#~{}&;<>|*?'")


def generate_command(nodeid: str, suite: str, seed: int, options: Sequence[str] = ()) -> str:
    """The command that generates a test anew: `pytest "tests/..[rl-leg1-3fa2b1c0]" --hri-suite=rl --hri-seed=0`.

    Args:
        nodeid: of the test.
        suite: what `--hri-suite` is given to have the test generated.
        seed: the suite's seed, not the test's own.
        options: further options that the run was given and that decide which tests exist or what fails.
    """
    words = [f"--hri-suite={suite}", f"--hri-seed={seed}", *options]
    return " ".join(["pytest", _quoted(nodeid), *map(_option, words)])


def replay_command(file: str, options: Sequence[str] = ()) -> str:
    """The command that replays a file: `pytest --hri-replay=hri-report/failures/rl-leg1-3fa2b1c0.json`.

    Args:
        file: the replay file.
        options: as for `generate_command`; only those that decide what fails are used.
    """
    words = [f"--hri-replay={file}", *(each for each in options if each.startswith(_JUDGING))]
    return " ".join(["pytest", *map(_option, words)])


def instructions(
    test: TestResult, suite: str | None, seed: int | None, options: Sequence[str] = (), file: str | None = None
) -> list[str]:
    """How to run a test again: commands, each below a line that says what it does.

    Args:
        test: a test of the report.
        suite: as for `generate_command`; empty for a test from a replay file, None for the test's own suite.
        seed: as for `generate_command`; None for a custom test function, which belongs to no suite.
        options: as for `generate_command`.
        file: the test's replay file, if it has one.
    """
    if seed is None:
        return ["run it again:", f"  pytest {_quoted(test.nodeid)}"]
    if file and suite == "":
        return ["run it again:", f"  {replay_command(file, options)}"]
    lines = ["run it again:", f"  {generate_command(test.nodeid, suite or test.suite, seed, options)}"]
    return [*lines, "or the very same run, from its file:", f"  {replay_command(file, options)}"] if file else lines


def instructions_of(report: Report, test: TestResult) -> list[str]:
    """How to run a test of a report again, with the options of the report's run."""
    seeds = {suite.name: suite.seed for suite in report.suites}
    return instructions(test, report.rerun.suite, seeds.get(test.suite, 0), report.rerun.options, test.replay)


def _quoted(nodeid: str) -> str:
    # Some shells require quotes around brackets. Every shell understands double quotes, so these are used unless a
    # character of the name has a meaning inside of them.
    if all(char.isalnum() or char in _PLAIN_IN_DOUBLE_QUOTES for char in nodeid):
        return f'"{nodeid}"'
    return shlex.quote(nodeid)


def _option(text: str) -> str:
    return text if all(char.isalnum() or char in "-_=/.,:" for char in text) else shlex.quote(text)
