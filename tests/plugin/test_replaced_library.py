"""Code that replaces parts of Python's library for the whole process loses no result; wrong parts are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.project import A_WORKER, change, report

pytestmark = pytest.mark.slow

SUITE = "--hri-suite=by-hand"
WRONG = {
    "hashlib.sha256": "import hashlib; hashlib.sha256 = lambda data=b'', **_: hashlib.md5(data)",
    "json.dumps": "import json; json.dumps = lambda value, **_: '{}'",
    "zlib.compress": "import zlib; zlib.compress = lambda data, level=-1: b''",
}
PLACE = ("lamps/guide.py", "    if wish.level == 0.0:\n        return switched_off()\n")


def _hashes(folder: Path) -> list[str]:
    return [test["record_sha256"] for test in report(folder)["tests"]]


@pytest.mark.parametrize(
    ("name", "options"),
    [*(pytest.param(name, (), id=name) for name in WRONG), pytest.param("json.dumps", A_WORKER, id="on a worker")],
)
def test_what_answers_wrongly_fails_the_session(lamps: pytest.Pytester, name: str, options: tuple[str, ...]) -> None:
    change(lamps.path, *PLACE, f"    {WRONG[name]}\n" + PLACE[1])
    result = lamps.runpytest_subprocess(SUITE, *options)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"*{name} of Python's library answers wrongly: the code under test has replaced*"])
    assert len(_hashes(lamps.path)) == 4
    assert report(lamps.path)["not_run"] == 0


BUILTINS = {
    "sorted": "import builtins; builtins.sorted = lambda items, **_: [*items]",
    "zip": "import builtins; builtins.zip = None",
    "dict": "import builtins; del builtins.dict",
}


@pytest.mark.parametrize("name", BUILTINS)
def test_a_function_of_python_is_not_replaced_in_a_run(lamps: pytest.Pytester, name: str) -> None:
    change(lamps.path, *PLACE, f"    {BUILTINS[name]}\n" + PLACE[1])
    result = lamps.runpytest_subprocess(SUITE)
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"*guide.py:*builtins.{name} is changed for the whole process, pytest included:*"])
    assert report(lamps.path)["not_run"] == 0


FINDER = """
class Finder:
    def find_spec(self, name, path=None, target=None):
        raise RuntimeError("no imports")
import sys
"""
FINDERS = {
    "meta_path": FINDER + "sys.meta_path.insert(0, Finder())\n",
    "path_hooks": FINDER + "sys.path_hooks.insert(0, Finder().find_spec)\n",
}


@pytest.mark.parametrize("name", FINDERS)
def test_what_lets_no_import_pass_is_taken_away_and_named(lamps: pytest.Pytester, name: str) -> None:
    indented = FINDERS[name].replace("\n", "\n    ").rstrip()
    change(lamps.path, *PLACE, f"    {indented}\n" + PLACE[1])
    result = lamps.runpytest_subprocess(SUITE, "--hri-audit=2")
    assert result.ret == pytest.ExitCode.TESTS_FAILED
    result.stdout.fnmatch_lines([f"*the code under test changed sys.{name} for the whole process at *guide.py:*"])
    assert report(lamps.path)["not_run"] == 0
