"""Code that ends its test by a word of pytest fails the session: only a test function may skip or expect a failure."""

from __future__ import annotations

import pytest

from tests.plugin.project import A_WORKER, change, report

pytestmark = pytest.mark.slow

SUITE = "--hri-suite=by-hand"
WORDS = {
    "pytest.xfail": "import pytest; pytest.xfail('no sensor')",
    "pytest.skip": "import pytest; pytest.skip('no sensor')",
    "pytest.exit": "import pytest; pytest.exit('no sensor', 0)",
    "unittest.SkipTest": "import unittest; raise unittest.SkipTest('no sensor')",
}
AT = {
    "code under test": ("lamps/guide.py", "    if wish.level == 0.0:\n        return switched_off()\n", "    {}\n"),
    "handler of the world": (
        "conftest.py",
        "            run.recorder.signal(",
        "            {}\n            run.recorder.signal(",
    ),
    "run": ("conftest.py", "    ended = run.go(LIMIT_S)\n", "    ended = run.go(LIMIT_S)\n    {}\n"),
}
CASES = [pytest.param(word, "code under test", (), id=word) for word in WORDS]
CASES += [pytest.param("pytest.exit", place, (), id=f"pytest.exit in the {place}") for place in [*AT][1:]]
CASES += [pytest.param("pytest.exit", "code under test", A_WORKER, id="pytest.exit on a worker")]


@pytest.mark.parametrize(("word", "place", "options"), CASES)
def test_the_session_fails(lamps: pytest.Pytester, word: str, place: str, options: tuple[str, ...]) -> None:
    file, before, after = AT[place]
    change(lamps.path, file, before, after.format(WORDS[word]))
    result = lamps.runpytest_subprocess(SUITE, *options)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    outcomes = {test["outcome"] for test in report(lamps.path)["tests"]}
    assert outcomes & {"failed", "error"}
    assert "expected-failure" not in outcomes
    assert "no sensor" in result.stdout.str()
    assert report(lamps.path)["not_run"] == 0


@pytest.mark.parametrize(
    ("line", "call"),
    [
        ("import os; os._exit(0)", "os._exit(0)"),
        ("import signal; signal.raise_signal(15)", "signal.raise_signal(15)"),
        ("import os; os.kill(os.getpid(), 1)", "os.kill(*, ...)"),
    ],
)
def test_code_that_ends_the_process_loses_no_result(lamps: pytest.Pytester, line: str, call: str) -> None:
    change(lamps.path, "lamps/guide.py", AT["code under test"][1], f"    {line}\n")
    result = lamps.runpytest_subprocess(SUITE)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"*{call} at *guide.py:*: it would end all tests at once*"])


def test_the_test_functions_own_words_keep_their_meaning(lamps: pytest.Pytester) -> None:
    change(lamps.path, "test_lamps.py", "def test_lamps(hri_case):\n", "import pytest\n\n\ndef test_lamps(hri_case):\n")
    change(lamps.path, "test_lamps.py", "    hri_case.check(hri_case.run())\n", "    pytest.skip('rig is busy')\n")
    result = lamps.runpytest_subprocess(SUITE)
    assert result.ret == pytest.ExitCode.OK
    result.assert_outcomes(skipped=4, deselected=1)
