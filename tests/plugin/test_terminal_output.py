"""What stands in the terminal."""

from __future__ import annotations

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import change, counted_up_to_313

SUITE = "--hri-suite=rl"
TITLE = "human-robot interaction"


def section(result: pytest.RunResult) -> list[str]:
    """The lines of the plugin's section, without a title."""
    lines = result.outlines
    start = next(number for number, line in enumerate(lines) if line.startswith(("requirements ", "suite rl, seed 0")))
    return lines[start:-1]


@counted_up_to_313
def test_a_session_that_passes_has_one_line_in_the_header_and_few_at_the_end(finished: SessionRunner) -> None:
    session = finished(SUITE)
    result = session.result
    assert [line for line in result.outlines if line.startswith("hri")] == ["hri: lamps, suite rl, seed 0, 34 tests"]
    assert len(result.outlines) <= 15
    lines = section(result)
    assert lines[0].startswith("requirements  2 of 3 passed; least margins ")
    assert "not covered   1 statement" in "".join(lines)
    assert "  lamps/guide.py  44" in lines
    assert lines[-1].startswith("PASSED  ")
    assert lines[-1].endswith("    hri-report/index.html")
    assert all(len(line) <= 80 for line in lines)


@counted_up_to_313
@pytest.mark.slow
def test_with_v_it_has_all_requirements_and_figures(finished: SessionRunner) -> None:
    lines = section(finished(SUITE, "-v").result)
    assert lines[0] == "suite rl, seed 0: 34 tests"
    assert "statements            97.6 % (40 of 41)" in map(str.strip, lines)
    assert "34/34 tests reported" in lines


@pytest.mark.slow
def test_colour_is_optional_and_quiet_drops_the_header_only(finished: SessionRunner) -> None:
    assert "\x1b" not in finished(SUITE).result.stdout.str()
    assert "\x1b[32m" in finished(SUITE, "--color=yes").result.stdout.str()
    quiet = finished(SUITE, "-q").result
    quiet.stdout.no_fnmatch_line("hri*:*")
    assert section(quiet)[0].startswith("requirements ")


@pytest.mark.slow
def test_a_belief_that_no_agent_tests_is_named(lamps: pytest.Pytester) -> None:
    said = "no agent tests * of the belief space*"
    lamps.runpytest_inprocess("--hri-suite=by-hand").stdout.no_fnmatch_line(said)
    change(lamps.path, "models/visitor.asl", ": curt & dark <- set", ": curt <- set")  # dark is still said, and no more
    change(lamps.path, "models/visitor.asl", "+hall <- enter(hall);", "+hall <- enter(hall); +dark;")
    result = lamps.runpytest_inprocess("--hri-suite=by-hand")
    assert result.ret == 0
    result.stdout.fnmatch_lines(["no agent tests dark of the belief space, in no trigger, context or condition, so *"])
    change(lamps.path, "conftest.py", 'id_groups=("mood",),', 'id_groups=("mood",), default_beliefs=("dark",),')
    lamps.runpytest_inprocess("--hri-suite=by-hand").stdout.no_fnmatch_line(said)
