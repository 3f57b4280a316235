"""Sessions of the lamps that are killed, by what the guide does while one of its tests runs."""

from __future__ import annotations

import pytest

from tests.plugin.project import change

SUITE = "--hri-suite=by-hand"  # four tests; the third one wishes for level 10

KILLING = """
import os, pathlib, time

if os.path.exists("armed"):
    os.unlink("armed")
    until_s = time.monotonic() + 60
    while pathlib.Path("hri-report/journal.jsonl").read_text().count('"finished"') < 2:
        assert time.monotonic() < until_s, "what ran before, here or on the other worker, does not arrive"
    os.kill(os.get{}(), 9)
"""


def dimmed(lamps: pytest.Pytester, body: str) -> None:
    """Let the guide do something else when it is to dim the lamp, which one of the four tests makes it do."""
    change(lamps.path, "lamps/guide.py", "return 10.0", body)


def run(lamps: pytest.Pytester, *options: str) -> pytest.RunResult:
    """A session in a process of its own, without the cache, which orders nothing here."""
    return lamps.runpytest_subprocess(SUITE, *options)
