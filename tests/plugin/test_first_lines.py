"""The first line of a failure stands alone: where pytest, services and editors repeat it, there is no more."""

from __future__ import annotations

import pytest
from _pytest.mark.structures import ParameterSet

from tests.plugin.project import A_WORKER, change

SUITE = ("--hri-suite=by-hand", "--hri-strict")
FIRST = "R2 failed at * s by 20 %"


def slowly(*options: str) -> ParameterSet:
    return pytest.param(options, marks=pytest.mark.slow)


def failed(result: pytest.RunResult) -> list[str]:
    """What pytest's short summary has."""
    start = next(number for number, line in enumerate(result.outlines) if "short test summary info" in line)
    return result.outlines[start + 1 : -1]


@pytest.mark.parametrize("options", [(), slowly("-q", "-rA"), slowly("--tb=line"), slowly(*A_WORKER)])
def test_services_that_repeat_a_failure_repeat_its_first_line(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, options: tuple[str, ...]
) -> None:
    monkeypatch.setenv("CI", "true")
    result = lamps.runpytest_inprocess(*SUITE, *options)
    lines = [line for line in failed(result) if not line.startswith("PASSED")]
    assert len(lines) == 1
    result.stdout.fnmatch_lines([f"FAILED test_lamps.py::test_lamps[[]by-hand-*[]] - {FIRST}*"])
    if "--tb=line" in options:
        result.stdout.fnmatch_lines([f"*test_lamps.py:*: {FIRST}*"])


@pytest.mark.slow
def test_so_does_an_error_of_the_code(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    change(lamps.path, "lamps/guide.py", "        lamp.set(level)\n", "        raise OSError('no lamp')\n")
    lines = failed(lamps.runpytest_inprocess(*SUITE))
    assert len(lines) == 4
    assert all(line.endswith(" - OSError: no lamp") for line in lines)


@pytest.mark.slow
def test_so_does_a_custom_test(lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CI", "true")
    test = "def test_mine(hri_run):\n    hri_run.check(hri_run('enter hall\\nset_lamp level = 100'))\n"
    (lamps.path / "test_mine.py").write_text(test, encoding="utf-8")
    result = lamps.runpytest_inprocess("test_mine.py", "--hri-strict")
    result.stdout.fnmatch_lines([f"FAILED test_mine.py::test_mine - {FIRST}"])
    assert len(failed(result)) == 1
