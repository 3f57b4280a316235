"""The same error in many tests has one traceback."""

from __future__ import annotations

import pytest

from tests.plugin.project import A_WORKER, change, outcomes

SUITE = "--hri-suite=by-hand"
each_way = pytest.mark.parametrize(
    "options",
    [
        pytest.param((), id="plain"),
        pytest.param(A_WORKER, id="worker", marks=pytest.mark.slow),
        pytest.param(("-p", "no:xdist"), id="no xdist", marks=pytest.mark.slow),
    ],
)


def break_guide(lamps: pytest.Pytester, how: str = 'raise ConnectionError(f"lamp {level} unplugged")') -> None:
    """Let the guide fail at each wish."""
    change(lamps.path, "lamps/guide.py", "        lamp.set(level)\n", f"        {how}\n")


@each_way
def test_an_error_of_the_code_under_test_is_shown_once(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    break_guide(lamps)
    result = lamps.runpytest_inprocess(SUITE, "-rf", *options)
    assert result.ret == 1
    result.assert_outcomes(failed=4, deselected=None if "-n" in options else 1)
    assert result.stdout.str().count(">           raise ConnectionError(") == 1
    result.stdout.fnmatch_lines(["*- the same in 3 more tests -*", "test_lamps.py::test_lamps[[]by-hand-*"])
    assert len([line for line in result.outlines if line.startswith("FAILED test_lamps.py")]) == 4
    assert list(outcomes(lamps.path).values()) == ["failed"] * 4


def test_an_error_of_a_fixture_is_shown_once(lamps: pytest.Pytester) -> None:
    head = "import pytest\n\n\n@pytest.fixture\ndef rig():\n    raise OSError('no rig')\n\n\n"
    change(lamps.path, "test_lamps.py", "def test_lamps(hri_case):", f"{head}def test_lamps(hri_case, rig):")
    result = lamps.runpytest_inprocess(SUITE)
    result.assert_outcomes(errors=4, deselected=1)
    assert result.stdout.str().count("raise OSError('no rig')") == 1
    result.stdout.fnmatch_lines(["*- the same in 3 more tests -*"])


def test_other_errors_are_shown_each_and_violations_by_an_example(lamps: pytest.Pytester) -> None:
    error = "raise (ValueError if level == 100 else KeyError)(level)"
    break_guide(lamps, f"lamp.set(level)\n        if wish.level == 0 or wish.cellar:\n            {error}")
    change(lamps.path, "requirements.toml", "lamp_level <= 80", "lamp_level <= 5")
    result = lamps.runpytest_inprocess(SUITE, "--hri-strict")
    text = result.stdout.str()
    assert text.count("R2 Failed: The lamp shall never glare") >= 1
    assert text.count(f">           {error}") == len(
        {name for name in ("ValueError", "KeyError") if f"E       {name}" in text}
    )


def test_tests_of_others_are_not_folded(lamps: pytest.Pytester) -> None:
    head = "import pytest\n\n\n@pytest.mark.parametrize('number', [1, 2])\n"
    change(
        lamps.path,
        "test_lamps.py",
        "def test_of_their_own():\n    pass",
        f"{head}def test_of_their_own(number):\n    assert 0",
    )
    result = lamps.runpytest_inprocess(SUITE, "test_lamps.py")
    assert result.stdout.str().count(">       assert 0") == 2
