"""pytest's own options and plugins: what is switched off, what only shows something, and what runs tests otherwise."""

from __future__ import annotations

import sys

import pytest

from tests.plugin.conftest import SessionRunner
from tests.plugin.project import A_WORKER, change, in_each_mode, outcomes, report

pytestmark = pytest.mark.slow  # each test is a session or several

SUITE = "--hri-suite=by-hand"
CALLED = "def test_lamps(hri_case):\n    hri_case.check(hri_case.run())\n"
KNOWN = "known-violation"
FOUR = sorted((KNOWN, "passed", "passed", "passed"))
SWITCHING = """import os

SWITCHING_S = 0.3 if os.environ.get("PYTEST_XDIST_WORKER") == "gw0" else 0.4
"""
OLD_LARK = """
__version__ = "0.12.0"


class Tree:
    pass


class Token(str):
    pass
"""
OFF = (
    *("terminal", "skipping", "capture", "cacheprovider", "junitxml", "logging", "warnings", "tmpdir", "debugging"),
    *("faulthandler", "unraisableexception", "threadexception", "assertion", "monkeypatch", "setuponly", "unittest"),
)


@pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "on a worker"])
@pytest.mark.parametrize("name", ["terminal", "skipping", "capture"])
def test_a_plugin_of_pytest_may_be_off(lamps: pytest.Pytester, name: str, options: tuple[str, ...]) -> None:
    assert lamps.runpytest_inprocess(SUITE, "-p", f"no:{name}", *options).ret == 0
    assert sorted(outcomes(lamps.path).values()) == FOUR


def test_all_may_be_off_at_once(lamps: pytest.Pytester) -> None:
    off = [option for name in OFF for option in ("-p", f"no:{name}")]
    assert lamps.runpytest_inprocess(SUITE, *off, "-p", "no:xdist").ret == 0
    assert sorted(outcomes(lamps.path).values()) == FOUR


def test_without_its_terminal_standard_error_says_why_a_session_failed(lamps: pytest.Pytester) -> None:
    result = lamps.runpytest_inprocess(SUITE, "-p", "no:terminal", "--hri-fail-under=statements=100")
    assert result.ret == 1
    result.stderr.fnmatch_lines(["FAILED suite by-hand: statements 97.56 %, at least 100 % asked for"])
    assert result.outlines == []


@in_each_mode
@pytest.mark.parametrize("shown", ["--setup-plan", "--setup-only", "--cache-show", "--fixtures"])
def test_what_only_shows_something_leaves_the_report_as_it_is(
    lamps: pytest.Pytester, after: SessionRunner, options: tuple[str, ...], shown: str
) -> None:
    after(SUITE)
    before = (lamps.path / "hri-report" / "report.json").read_bytes()
    result = lamps.runpytest_inprocess(SUITE, shown, *options)
    assert result.ret == 0
    result.stdout.no_fnmatch_line("*human-robot interaction*")
    assert (lamps.path / "hri-report" / "report.json").read_bytes() == before


class TestWaysToHandOutTests:
    EACH = ("--dist=each", "--tx=2*popen")

    @pytest.mark.slow
    def test_each_test_on_each_worker_counts_once(self, lamps: pytest.Pytester) -> None:
        result = lamps.runpytest_inprocess(SUITE, *self.EACH)
        assert result.ret == 0
        result.assert_outcomes(passed=6, xfailed=2)
        result.stdout.fnmatch_lines(
            ["--dist=each: 4 tests ran on each of gw0, gw1, and *", "PASSED  3 passed, 1 known to fail *"]
        )

    def test_what_is_not_the_same_on_each_worker_fails_the_session(self, lamps: pytest.Pytester) -> None:
        change(lamps.path, "lamps/guide.py", "SWITCHING_S = 0.3\n", SWITCHING)
        result = lamps.runpytest_inprocess(SUITE, *self.EACH, "-k", "cellar")
        assert result.ret == 1
        result.stdout.fnmatch_lines(["FAILED test_lamps.py::*cellar* is not the same on each worker: gw*; gw*"])

    def test_a_way_that_gives_all_to_one_worker_is_named(self, lamps: pytest.Pytester) -> None:
        result = lamps.runpytest_inprocess(SUITE, "-n", "2", "--dist=loadfile")
        result.stdout.fnmatch_lines(["--dist=loadfile gave all tests to one worker, as they are of one file; *"])

    @pytest.mark.slow
    @pytest.mark.parametrize("way", ["load", "worksteal", "loadgroup", "loadscope"])
    def test_the_others_run_each_test_once(self, lamps: pytest.Pytester, way: str) -> None:
        assert lamps.runpytest_inprocess(SUITE, "-n", "2", f"--dist={way}").ret == 0
        assert sorted(outcomes(lamps.path).values()) == FOUR


def test_an_old_lark_in_the_same_folder_is_one_line(lamps: pytest.Pytester) -> None:
    (lamps.path / "lark").mkdir()
    (lamps.path / "lark" / "__init__.py").write_text(OLD_LARK, encoding="utf-8")  # what lark-parser 0.12 has of it
    for options in ([SUITE], [SUITE, *A_WORKER]):
        result = lamps.runpytest_subprocess(*options)
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines(["ERROR: *__init__.py: lark of version 0.12.0; expected 1.2 or later. An old *"])
        assert "INTERNALERROR" not in result.stdout.str() + result.stderr.str()


@pytest.mark.parametrize("name", ["fractions", "difflib"])  # imported by the testbench, and before any hook
def test_a_module_of_the_project_that_hides_one_of_python_is_one_line(lamps: pytest.Pytester, name: str) -> None:
    (lamps.path / f"{name}.py").write_text("LEVELS = [1, 2]\n", encoding="utf-8")
    for options in ([SUITE], [SUITE, *A_WORKER]):
        result = lamps.runpytest_subprocess(*options)
        assert result.ret == pytest.ExitCode.USAGE_ERROR
        result.stderr.fnmatch_lines([f"ERROR: *{name}.py: hides Python's own module {name}, which *: rename it"])
        assert "INTERNALERROR" not in result.stdout.str() + result.stderr.str()
    (lamps.path / f"{name}.py").rename(lamps.path / "turtle.py")  # which nobody here imports
    assert lamps.runpytest_subprocess(SUITE).ret == 0


class TestATimeLimit:
    """As pytest-timeout has it: armed for all hooks of a test, it raises wherever the test is."""

    LIMIT = """import signal

import pytest


def pytest_configure(config):
    {patch}


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    before = signal.signal(signal.SIGALRM, lambda number, frame: pytest.fail("Timeout (>2.0s)"))
    try:
        return (yield)
    finally:
        signal.signal(signal.SIGALRM, before)


def over_in(module, name):
    own = getattr(module, name)

    def late(*arguments, **options):
        if signal.getsignal(signal.SIGALRM) is not signal.SIG_DFL:
            signal.raise_signal(signal.SIGALRM)
        return own(*arguments, **options)

    setattr(module, name, late)
"""

    def test_is_none_of_what_a_session_works_out_before_its_first_test(self, lamps: pytest.Pytester) -> None:
        patch = "from pytest_hricdv.session import reporting; over_in(reporting, 'explore')"
        (lamps.path / "limit.py").write_text(self.LIMIT.format(patch=patch), encoding="utf-8")
        result = lamps.runpytest_subprocess(SUITE, "-p", "limit")
        assert result.ret == 0
        result.stdout.fnmatch_lines(["PASSED  3 passed, 1 known to fail *"])

    @pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "on a worker"])
    def test_that_is_over_while_a_result_is_made_fails_this_test_only(
        self, lamps: pytest.Pytester, options: tuple[str, ...]
    ) -> None:
        patch = "from pytest_hricdv.extra.traces.trace_writer import TraceWriter; over_in(TraceWriter, 'trace')"
        (lamps.path / "limit.py").write_text(self.LIMIT.format(patch=patch), encoding="utf-8")
        result = lamps.runpytest_subprocess(SUITE, "-p", "limit", "--hri-mcap", "--hri-strict", *options)
        assert result.ret == 1
        result.assert_outcomes(passed=3, failed=1, deselected=None if options else 1)
        result.stdout.fnmatch_lines(["Timeout (>2.0s): while the result of *", "FAILED  3 passed, 1 failed *"])
        assert "INTERNALERROR" not in result.stdout.str()


class TestTheFixture:
    def test_is_listed_with_what_it_is_for(self, lamps: pytest.Pytester) -> None:
        for options in ([], [SUITE]):
            result = lamps.runpytest_inprocess("--fixtures", *options)
            result.stdout.fnmatch_lines(["hri_case -- *", "    One generated test: `hri_case.check(hri_case.run())` *"])

    @in_each_mode
    def test_runs_where_another_fixture_runs_it(self, lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
        change(
            lamps.path,
            "test_lamps.py",
            CALLED,
            "import pytest\n\n\n@pytest.fixture\ndef ran(hri_case):\n    return hri_case.run()\n\n\n"
            "def test_lamps(hri_case, ran):\n    hri_case.check(ran)\n",
        )
        result = lamps.runpytest_inprocess(SUITE, *options)
        result.assert_outcomes(passed=3, xfailed=1, deselected=None if "-n" in options else 1)
        assert sorted(outcomes(lamps.path).values()) == FOUR
        assert all(test["wall_s"] > 0 for test in report(lamps.path)["tests"])

    def test_that_a_fixture_checks_is_a_result_also_where_it_fails(self, lamps: pytest.Pytester) -> None:
        change(
            lamps.path,
            "test_lamps.py",
            CALLED,
            "import pytest\n\n\n@pytest.fixture\ndef checked(hri_case):\n    hri_case.check(hri_case.run())\n\n\n"
            "def test_lamps(checked):\n    pass\n",
        )
        result = lamps.runpytest_inprocess(SUITE, "--hri-strict")
        result.assert_outcomes(passed=3, errors=1, deselected=1)
        result.stdout.fnmatch_lines(["FAILED  3 passed, 1 failed *"])
        lamps.runpytest_inprocess(SUITE).assert_outcomes(passed=3, xfailed=1, deselected=1)
        assert sorted(outcomes(lamps.path).values()) == FOUR

    def test_is_isolated_in_the_test_only(self, lamps: pytest.Pytester) -> None:
        change(
            lamps.path,
            "test_lamps.py",
            CALLED,
            "import pytest\n\n\n@pytest.fixture\ndef ran(hri_case):\n    return hri_case.run()\n\n\n"
            "def test_lamps(hri_case, ran):\n    hri_case.check(ran)\n",
        )
        result = lamps.runpytest_inprocess(SUITE, "--hri-isolate")
        result.assert_outcomes(errors=4, deselected=1)
        result.stdout.fnmatch_lines(["hri_case.run in a fixture: with --hri-isolate only the calls of tests are in *"])

    def test_is_not_run_by_what_clears_up(self, lamps: pytest.Pytester) -> None:
        change(
            lamps.path,
            "test_lamps.py",
            CALLED,
            "import pytest\n\n\n@pytest.fixture\ndef late(hri_case):\n    yield\n    hri_case.run()\n\n\n"
            f"def test_lamps(hri_case, late):\n{CALLED.splitlines()[1]}\n",
        )
        result = lamps.runpytest_inprocess(SUITE)
        result.stdout.fnmatch_lines(
            ["E * RuntimeError: hri_case.run: expected inside of its own test, or of a fixture*"]
        )

    def test_is_not_made_while_a_test_runs(self, lamps: pytest.Pytester) -> None:
        change(lamps.path, "test_lamps.py", "    pass\n", "    request.getfixturevalue('hri_case')\n")
        change(lamps.path, "test_lamps.py", "their_own()", "their_own(request)")
        result = lamps.runpytest_inprocess(SUITE, "test_lamps.py")
        result.assert_outcomes(passed=3, xfailed=1, failed=1)
        result.stdout.fnmatch_lines(["*test_of_their_own: hri_case is asked for while the test runs, *"])
        lamps.runpytest_inprocess().assert_outcomes(skipped=2)

    def test_may_be_asked_for_while_the_test_runs_where_it_is_marked(self, lamps: pytest.Pytester) -> None:
        change(
            lamps.path,
            "test_lamps.py",
            CALLED,
            'import pytest\n\n\n@pytest.mark.usefixtures("hri_case")\ndef test_lamps(request):\n'
            '    case = request.getfixturevalue("hri_case")\n    case.check(case.run())\n',
        )
        lamps.runpytest_inprocess(SUITE).assert_outcomes(passed=3, xfailed=1, deselected=1)


@pytest.mark.parametrize("options", [(), A_WORKER], ids=["plain", "on a worker"])
def test_no_text_file_is_opened_in_the_encoding_of_the_machine(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    lamps.run("git", "init", "-q", ".")  # a report has the revision
    python = (sys.executable, "-X", "warn_default_encoding", "-W", "error::EncodingWarning")
    done = lamps.run(*python, "-m", "pytest", "-W", "error::EncodingWarning", SUITE, *options)
    assert done.ret == 0
    assert "EncodingWarning" not in done.stdout.str() + done.stderr.str()
