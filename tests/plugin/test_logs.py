"""What the code under test logged stands beside the failure of its test, at simulated times."""

from __future__ import annotations

import pytest

from tests.plugin.project import A_WORKER, change, report

SUITE = "--hri-suite=by-hand"
FAILING = "hall-polite-5a5e8c87"
each_way = pytest.mark.parametrize(
    "options",
    [(), A_WORKER, ("--hri-isolate",), ("-p", "no:logging")],
    ids=["plain", "worker", "isolated", "without pytest's logging"],
)


def log(lamps: pytest.Pytester, *statements: str) -> None:
    """Let the guide log at each wish, before it sets the lamp."""
    lines = "".join(f"        {statement}\n" for statement in statements)
    change(lamps.path, "lamps/guide.py", "        lamp.set(level)\n", f"{lines}        lamp.set(level)\n")
    change(
        lamps.path,
        "lamps/guide.py",
        "GLARE = 80.0\n",
        "import logging\n\nGLARE = 80.0\nLOG = logging.getLogger('guide')\n",
    )


@pytest.mark.slow
@each_way
def test_messages_stand_beside_the_violation(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    log(lamps, "LOG.warning('switching to %s', level)", "LOG.debug('not shown')")
    result = lamps.runpytest_inprocess("-vv", SUITE, "--hri-strict", *options)
    result.stdout.fnmatch_lines(
        [
            "*--> R2 is violated",
            "",
            "what was logged around then:",
            "      2.02 s  WARNING guide: switching to 100.0",
            "",
        ]
    )
    (failed,) = [test for test in report(lamps.path)["tests"] if test["outcome"] == "failed"]
    assert "WARNING guide: switching to 100.0" in failed["failure"]
    assert "not shown" not in failed["failure"]


@pytest.mark.slow
def test_levels_are_those_of_the_project(lamps: pytest.Pytester) -> None:
    log(lamps, "LOG.debug('level %s', level)")
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict", "-v", "--log-level=DEBUG")
    result.stdout.fnmatch_lines(["      2.02 s  DEBUG   guide: level 100.0"])


def test_what_a_message_raised_for_is_named(lamps: pytest.Pytester) -> None:
    log(lamps, "try: 1 / 0", "except ZeroDivisionError: LOG.exception('odd\\nlevel')")
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict", "-v")
    result.stdout.fnmatch_lines(["*s  ERROR   guide: odd (ZeroDivisionError: division by zero)"])
