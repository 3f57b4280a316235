"""Texts of megabytes, of the code under test: results are kept, and short."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from tests.plugin.project import A_WORKER, change, report

pytestmark = pytest.mark.slow

SUITE = "--hri-suite=by-hand"
SWITCH_OFF = ("lamps/guide.py", "    if wish.level == 0.0:\n        return switched_off()\n")
SAYS = {
    "an exception with a text of its own": (
        "    class Odd(Exception):\n        def __str__(self):\n            return 'begin ' + 'x' * {size} + ' end'\n"
        "    raise Odd\n"
    ),
    "a cause": (
        "    try:\n        raise ValueError('begin ' + 'x' * {size} + ' end')\n"
        "    except ValueError as error:\n        raise RuntimeError('no lamp') from error\n"
    ),
    "what it prints and logs": (
        "    import logging\n    text = 'begin ' + 'x' * {size} + ' end'\n    print(text)\n    logging.error(text)\n"
        "    raise ValueError('end')\n"
    ),
    "an error group with notes": (
        "    error = ExceptionGroup('begin', [ValueError('x' * {size}), KeyError('y' * {size})])\n"
        "    error.add_note('x' * {size})\n    raise error\n"
    ),
    "a failure of pytest": "    import pytest; pytest.fail('begin ' + 'x' * {size} + ' end')\n",
}
LIMITED = "import resource\n\nresource.setrlimit(resource.RLIMIT_AS, ({bytes}, {bytes}))\n"


@pytest.fixture
def summary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where GitHub wants the summary of a step."""
    file = tmp_path / "summary.md"
    monkeypatch.setenv("GITHUB_STEP_SUMMARY", os.fspath(file))
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    return file


def _texts_are_short(lamps: pytest.Pytester, summary: Path, result: pytest.RunResult) -> None:
    tests = {test["outcome"] for test in report(lamps.path)["tests"]}
    assert "failed" in tests or "error" in tests
    assert report(lamps.path)["not_run"] == 0
    assert (lamps.path / "hri-report" / "report.json").stat().st_size < 3_000_000
    assert (lamps.path / "junit.xml").stat().st_size < 3_000_000
    assert not summary.exists() or summary.stat().st_size < 1 << 20
    assert sum(map(len, result.outlines)) < 3_000_000


@pytest.mark.parametrize("says", SAYS)
def test_three_megabytes_are_cut(lamps: pytest.Pytester, summary: Path, says: str) -> None:
    change(lamps.path, *SWITCH_OFF, SAYS[says].format(size=3_000_000))
    result = lamps.runpytest_subprocess(SUITE, "--junitxml=junit.xml")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    _texts_are_short(lamps, summary, result)


@pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "on a worker"])
def test_200_megabytes_under_a_memory_limit_lose_no_result(
    lamps: pytest.Pytester, summary: Path, options: tuple[str, ...]
) -> None:
    change(lamps.path, *SWITCH_OFF, "    raise ValueError('begin ' + 'x' * 200_000_000 + ' end')\n")
    conftest = lamps.path / "conftest.py"
    limited = LIMITED.format(bytes=1_500_000_000)
    conftest.write_text(limited + conftest.read_text(encoding="utf-8"), encoding="utf-8")
    result = lamps.runpytest_subprocess(SUITE, "--junitxml=junit.xml", *options)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    _texts_are_short(lamps, summary, result)
    assert len(report(lamps.path)["tests"]) == 4
