"""Code under test that takes away what the session needs of its process: a report, and an end, nevertheless."""

from __future__ import annotations

import sys

import pytest

from tests._base.test_output import unread
from tests.plugin import project

RUN = ("--hri-suite=by-hand", "-p", "no:cacheprovider", "--hri-no-cov", "--hri-audit=1")

LOUD = {
    "builtins.open": "import builtins; builtins.open = None",
    "os.write": "import os; os.write = None",
    "builtins.isinstance": "import builtins; builtins.isinstance = lambda *_: True",
}
"""What is taken away -> how; the test fails for it."""

SILENT = {
    "arguments": "import argparse; argparse.ArgumentParser().parse_args()",
    "children": "import signal; signal.signal(signal.SIGCHLD, signal.SIG_IGN)",
    "signals": "import signal; signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGCHLD})",
    "folder": "import os, tempfile; folder = tempfile.mkdtemp(); os.chdir(folder); os.rmdir(folder)",
    "lies": "import os; os.stat = os.replace = os.path.exists = lambda *_, **__: True",
    "streams": "import sys; sys.stdout = sys.stderr = None",
}
"""What code may do: nobody else notices."""

REFUSED = {
    "resource.setrlimit": "import resource; resource.setrlimit(resource.RLIMIT_AS, (1 << 28, 1 << 28))",
    "sys.setrecursionlimit": "import sys; sys.setrecursionlimit(60)",
    "os.seteuid": "import os; os.seteuid(os.geteuid())",
    "time.clock_settime": "import time; time.clock_settime(-1, 0.0)",
    "sys.addaudithook": "import sys; sys.addaudithook(lambda *_: None)",
    "sys.setswitchinterval": "import sys; sys.setswitchinterval(1e3)",
    "signal.signal": "import signal; signal.signal(signal.SIGVTALRM, signal.SIG_IGN)",
    "faulthandler.dump_traceback_later": "import faulthandler; faulthandler.dump_traceback_later(0.1, exit=True)",
    "os.close": "import os; os.close(1)",
    "os.closerange": "import os; os.closerange(0, 1 << 16)",
    "sys.stdout.close": "import sys; sys.stdout.close()",
    "abc.ABCMeta.register": "from collections.abc import Mapping; Mapping.register(float)",
    "select.select": "import os, select; select.select([os.pipe()[0]], [], [], 0.1)",
}
"""What nobody can give back, or strikes by the machine's clock -> how code does it."""


def does(lamps: pytest.Pytester, statement: str) -> pytest.RunResult:
    """A session whose code does something when it begins to serve."""
    serving = "    greetings, wishes = "
    project.change(lamps.path, "lamps/guide.py", serving, f"    {statement}\n{serving}")
    return lamps.runpytest_subprocess(*RUN, timeout=120)


def test_what_cannot_be_given_back_is_refused_with_its_line(lamps: pytest.Pytester) -> None:
    tried = "".join(
        f"    try:\n        {statement}\n    except Exception:\n        pass\n" for statement in REFUSED.values()
    )
    serving = "    greetings, wishes = "
    project.change(lamps.path, "lamps/guide.py", serving, f"{tried}{serving}")
    result = lamps.runpytest_inprocess(*RUN[:-1], "-k", "hall-polite")
    assert result.ret == 1
    (test,) = project.report(lamps.path)["tests"]
    assert [name for name in REFUSED if name not in " ".join(test["errors"])] == []
    assert "guide.py:" in test["errors"][0]


HARMLESS = """import abc, numbers, os, sys
        sys.setrecursionlimit(10**9)
        assert sys.getrecursionlimit() == 10**6
        numbers.Integral.register(type("Count", (), {}))
        file = os.open(os.devnull, os.O_RDWR)
        os.dup2(file, file + 100)
        os.close(file)
        os.closerange(file + 100, file + 101)"""
"""What libraries do when they are imported, and code with its own files."""


def test_what_takes_nothing_away_is_as_ever(lamps: pytest.Pytester) -> None:
    serving = "    greetings, wishes = "
    project.change(lamps.path, "lamps/guide.py", serving, f"    if True:\n        {HARMLESS}\n{serving}")
    result = lamps.runpytest_inprocess(*RUN[:-1], "-k", "hall-polite")
    assert result.ret == 0


@pytest.mark.slow
@pytest.mark.parametrize("mode", [("-n", "2"), ("--hri-isolate",)], ids=str)
def test_a_session_of_any_mode_ends_with_a_report(lamps: pytest.Pytester, mode: tuple[str, ...]) -> None:
    """Errors that come of each other, a replaced builtin, and a limit of memory."""
    serving = "    greetings, wishes = "
    circle = "first, second = ValueError(), ValueError(); first.__cause__, second.__cause__ = second, first"
    statements = (REFUSED["resource.setrlimit"], LOUD["builtins.isinstance"], circle, "raise first")
    tried = f"    try:\n        {statements[0]}\n    finally:\n        {'; '.join(statements[1:])}\n"
    project.change(lamps.path, "lamps/guide.py", serving, f"{tried}{serving}")
    result = lamps.runpytest_subprocess(*RUN, *mode, timeout=120)
    assert result.ret == 1
    assert project.report(lamps.path)["reported"] == 4
    assert "INTERNALERROR" not in result.stdout.str()


@pytest.mark.slow
@pytest.mark.parametrize("name", LOUD)
def test_what_is_taken_from_the_process_is_put_back_and_fails_the_test(lamps: pytest.Pytester, name: str) -> None:
    result = does(lamps, LOUD[name])
    assert result.ret == 1
    written = project.report(lamps.path)
    assert {test["outcome"] for test in written["tests"]} == {"failed"}
    assert name in result.stdout.str()
    assert "INTERNALERROR" not in result.stdout.str()


@pytest.mark.slow
def test_what_finalizers_do_at_any_moment_ends_no_session(
    lamps: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Python 3.11 cannot parse while it parses; without files of bytecode, pytest parses what the session imports."""
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    parse = "type('Loud', (), {'__del__': lambda self: __import__('ast').parse('1')})"
    does(lamps, f"for _ in range(50): loud = {parse}(); loud.itself = loud").assert_outcomes(passed=3, xfailed=1)


@pytest.mark.slow
def test_a_session_that_failed_does_not_end_well_whatever_code_does_at_the_end(lamps: pytest.Pytester) -> None:
    leaves = "import atexit, os; atexit.register(os._exit, 0); atexit.register(lambda: os._exit(0)); raise OSError"
    result = does(lamps, leaves)
    assert result.ret == 1
    assert "Traceback" not in result.stderr.str()


@pytest.mark.slow
def test_what_code_may_change_ends_no_session(lamps: pytest.Pytester) -> None:
    result = does(lamps, "; ".join(SILENT.values()))
    assert result.ret == 0
    assert project.report(lamps.path)["reported"] == 4
    assert "INTERNALERROR" not in result.stdout.str()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGPIPE")
def test_a_session_that_nobody_reads_runs_all_its_tests(lamps: pytest.Pytester) -> None:
    unread(["pytest", *RUN[:-2]], lamps.path)
    assert project.report(lamps.path)["reported"] == 4
