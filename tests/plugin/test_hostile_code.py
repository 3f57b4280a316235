"""Code under test that takes away what the session needs of its process: a report, and an end, nevertheless."""

from __future__ import annotations

import pytest

from tests.plugin import project

RUN = ("--hri-suite=by-hand", "-p", "no:cacheprovider", "--hri-no-cov", "--hri-audit=1")

LOUD = {
    "builtins.open": "import builtins; builtins.open = None",
    "os.write": "import os; os.write = None",
    "os.fork": "import os; os.fork = os.waitpid = os.pipe = os.close = None",
    "sys.modules": "import sys; sys.modules.clear()",
}
"""What is taken away -> how; the test fails for it."""

SILENT = {
    "children": "import signal; signal.signal(signal.SIGCHLD, signal.SIG_IGN)",
    "signals": "import signal; signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM, signal.SIGCHLD})",
    "folder": "import os, tempfile; folder = tempfile.mkdtemp(); os.chdir(folder); os.rmdir(folder)",
    "files": "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (20, 20))",
}
"""What code may do: nobody else notices."""


def does(lamps: pytest.Pytester, statement: str) -> pytest.RunResult:
    """A session whose code does something when it begins to serve."""
    serving = "    greetings, wishes = "
    project.change(lamps.path, "lamps/guide.py", serving, f"    {statement}\n{serving}")
    return lamps.runpytest_subprocess(*RUN, timeout=120)


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
@pytest.mark.parametrize("name", SILENT)
def test_what_code_may_change_ends_no_session(lamps: pytest.Pytester, name: str) -> None:
    result = does(lamps, SILENT[name])
    assert result.ret == 0
    assert project.report(lamps.path)["reported"] == 4
    assert "INTERNALERROR" not in result.stdout.str()
