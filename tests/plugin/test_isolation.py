"""`--hri-isolate`: no test sees what another one has left, and all else is as without it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.plugin import project, state

pytestmark = pytest.mark.slow  # each test is a session or several

RUN = ("--hri-suite=bdi-random", "--hri-tests=3", "-p", "no:cacheprovider")
ISOLATED = (*RUN, "--hri-isolate")


def records(folder: Path) -> dict[str, str]:
    """Id of a test -> hash of its record, of the report."""
    return {test["id"]: test["record_sha256"] for test in project.report(folder)["tests"]}


def without_times(folder: Path) -> list[dict[str, Any]]:
    """The tests of the report, without how long they took."""
    return [{**test, "wall_s": 0.0} for test in project.report(folder)["tests"]]


@pytest.mark.parametrize(
    "way",
    [pytest.param(way, marks=() if way in ("list of a module", "cache") else pytest.mark.slow) for way in state.WAYS],
)
def test_each_run_is_what_it_is_alone(lamps: pytest.Pytester, way: str) -> None:
    state.leave(lamps, way)
    lamps.runpytest_subprocess(*RUN)
    together = records(lamps.path)
    lamps.runpytest_subprocess(*ISOLATED)
    isolated, last = records(lamps.path), [*together][-1]
    lamps.runpytest_subprocess(*RUN, "-k", last)
    assert records(lamps.path)[last] == isolated[last]
    assert isolated != together


@project.in_each_mode
def test_results_are_those_without_it(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    project.change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3", "SWITCHING_S = 1.3")
    lamps.runpytest_subprocess(*RUN, *options)
    before = without_times(lamps.path)
    lamps.runpytest_subprocess(*ISOLATED, *options).assert_outcomes(failed=3, deselected=0 if "-n" in options else 1)
    assert without_times(lamps.path) == before
    assert {test["outcome"] for test in before} == {"failed"}


def test_prints_warnings_and_properties_come_back(lamps: pytest.Pytester) -> None:
    test = (
        "import warnings\n\ndef test_lamps(hri_case, record_property):\n    print('said it')\n"
        "    warnings.warn('mind the lamp')\n    record_property('light', 'dim')\n"
        "    hri_case.check(hri_case.run())\n    assert False, 'so that it is shown'\n"
    )
    lamps.makepyfile(test_lamps=test)
    for capture in ("fd", "sys"):
        result = lamps.runpytest_subprocess(*ISOLATED, f"--capture={capture}", "--junitxml=junit.xml")
        result.stdout.fnmatch_lines(
            ["*- Captured stdout call -*", "said it", "*warnings summary*", "*UserWarning: mind the lamp"]
        )
        junit = Path(lamps.path, "junit.xml").read_text(encoding="utf-8")
        assert junit.count('name="light"') == 3
        assert junit.count('name="hri.R1"') == 3


@project.in_each_mode
def test_a_process_that_dies_is_the_error_of_its_test(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    state.say(lamps, "os.kill(os.getpid(), 9) or 0", module="import os\n")
    result = lamps.runpytest_subprocess(*ISOLATED, *options)
    result.assert_outcomes(failed=3, deselected=0 if "-n" in options else 1)
    result.stdout.fnmatch_lines(["test_lamps.py::test_lamps*: its process ended by SIGKILL, without a result*"])
    assert set(project.outcomes(lamps.path).values()) == {"error"}


def test_an_error_keeps_its_line(lamps: pytest.Pytester) -> None:
    state.say(lamps, "1 / 0")
    lines = []
    for options in (RUN, ISOLATED):
        result = lamps.runpytest_subprocess(*options)
        lines.append([line for line in result.outlines if "lamps/guide.py:" in line or "ZeroDivisionError" in line])
    assert lines[1] == lines[0]
    assert lines[0]
