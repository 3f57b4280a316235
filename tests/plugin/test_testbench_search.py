"""Where the testbench lies: in a conftest file that pytest loads before it collects, or in one below."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.project import A_WORKER, change

BELOW = Path("tests", "hri")
each_way = pytest.mark.parametrize(
    "options",
    [
        pytest.param((), id="plain"),
        pytest.param(A_WORKER, id="on a worker", marks=pytest.mark.slow),
        pytest.param(("-p", "no:xdist"), id="without xdist", marks=pytest.mark.slow),
    ],
)


@pytest.fixture
def deep(lamps: pytest.Pytester) -> pytest.Pytester:
    """The project with its testbench and host test in tests/hri, a unit test in tests/unit, and a suite in the ini."""
    (lamps.path / BELOW).mkdir(parents=True)
    (lamps.path / "tests" / "unit").mkdir()
    (lamps.path / "tests" / "unit" / "test_unit.py").write_text("def test_unit():\n    pass\n", encoding="utf-8")
    for name in ("conftest.py", "test_lamps.py", "requirements.toml", "by_hand.toml", "models"):
        (lamps.path / name).rename(lamps.path / BELOW / name)
    change(lamps.path, "pytest.ini", "pythonpath = .\n", "pythonpath = .\nhri_suite = by-hand\n")
    return lamps


@pytest.mark.slow
@pytest.mark.parametrize("paths", [("tests",), ("tests/hri",), ("tests/unit", "tests/hri"), (".",)], ids=str)
def test_a_testbench_below_what_is_collected_is_found(deep: pytest.Pytester, paths: tuple[str, ...]) -> None:
    result = deep.runpytest_inprocess(*paths)
    assert result.ret == 0
    unit = 0 if paths == ("tests/hri",) else 1
    result.assert_outcomes(passed=4 + unit, xfailed=1)
    result.stdout.fnmatch_lines(["hri: lamps, suite by-hand, seed 0*", "PASSED  3 passed, 1 known to fail *"])


@each_way
@pytest.mark.parametrize("path", ["tests/unit", "tests/unit/test_unit.py"])
def test_where_there_is_none_nothing_is_generated_and_the_header_says_so(
    deep: pytest.Pytester, options: tuple[str, ...], path: str
) -> None:
    result = deep.runpytest_inprocess(path, *options)
    assert result.ret == 0
    result.assert_outcomes(passed=1)
    result.stdout.fnmatch_lines([f"hri: no testbench in {path}: no tests are generated, although hri_suite is by-hand"])
    assert not (deep.path / "hri-report").exists()


def test_a_suite_on_the_command_line_needs_one(deep: pytest.Pytester) -> None:
    result = deep.runpytest_inprocess("--hri-suite=by-hand", "tests/unit")
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: no testbench: implement pytest_hricdv_testbench(config) in *"])


@pytest.mark.slow
def test_a_host_test_without_one_says_what_it_needs(deep: pytest.Pytester) -> None:
    (deep.path / BELOW / "conftest.py").unlink()
    asks = "ERROR: tests/hri/test_lamps.py::test_lamps asks for hri_case, and there is no testbench: implement *"
    result = deep.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines([asks])
    result = deep.runpytest_inprocess(*A_WORKER)
    assert result.ret != 0
    result.stdout.fnmatch_lines([asks.removeprefix("ERROR: ")])
    assert "INTERNALERROR" not in result.stdout.str()


@pytest.mark.slow
def test_of_several_none_is_chosen(deep: pytest.Pytester) -> None:
    (deep.path / "tests" / "other").mkdir()
    text = (deep.path / BELOW / "conftest.py").read_text(encoding="utf-8")
    (deep.path / "tests" / "other" / "conftest.py").write_text(text, encoding="utf-8")
    result = deep.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: 2 testbenches below *: tests/hri/conftest.py, tests/other/conftest.py; a *"])
    for options in (["tests/hri"], ["--ignore=tests/other"], ["-o", "norecursedirs=other"]):
        assert deep.runpytest_inprocess(*options).ret == 0


def test_one_that_cannot_be_imported_is_located(deep: pytest.Pytester) -> None:
    change(deep.path, "tests/hri/conftest.py", "LIMIT_S = 60.0\n", "LIMIT_S = 60.0\nimport nothing_such\n")
    result = deep.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(["ERROR: *conftest.py:*: ModuleNotFoundError: No module named 'nothing_such'"])
