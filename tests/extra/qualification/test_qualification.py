"""Known answers: on this installation, and on ones that are broken on purpose."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.qualification.command import page, qualify
from pytest_hricdv.extra.qualification.known_answers import KNOWN_ANSWERS, MonitorCase

MONITORS = [entry for entry in KNOWN_ANSWERS if isinstance(entry[1], MonitorCase)]
SESSIONS = [entry for entry in KNOWN_ANSWERS if not isinstance(entry[1], MonitorCase)]


def test_there_are_twenty_answers_each_with_a_title_of_its_own() -> None:
    assert len({title for title, _ in KNOWN_ANSWERS}) == len(KNOWN_ANSWERS) == 20


def test_monitors_give_what_was_computed_by_hand(tmp_path: Path) -> None:
    assert list(qualify(tmp_path, MONITORS)) == [(title, "") for title, _ in MONITORS]


def test_a_wrong_monitor_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its answer is wrong, others are not asked less for it."""
    from pytest_hricdv.extra.qualification import known_answers

    monkeypatch.setattr(known_answers, "evaluate", lambda requirements, log: ())
    found = list(qualify(tmp_path, MONITORS))
    assert [title for title, _ in found] == [title for title, _ in MONITORS]
    assert all(problem for _, problem in found)


def test_the_page_says_what_is_wrong_and_runs_no_text() -> None:
    made = page([("a <b>", ""), ("c", "expected 1, found <script>")])
    assert "1 of 2 answers are the known ones" in made
    assert "<script>" not in made
    assert "expected 1, found &lt;script&gt;" in made


@pytest.mark.slow
def test_this_installation_gives_the_known_answers(tmp_path: Path) -> None:
    assert list(qualify(tmp_path, SESSIONS)) == [(title, "") for title, _ in SESSIONS]


BREAK = {
    "monitors that always pass": (
        "a robot that does not stop fails",
        "from pytest_hricdv.monitor.verdict import VerdictBuilder as V\nold = V.decide\n"
        "V.decide = lambda self, begin, end, *, passed: old(self, begin, end, passed=True)\n",
    ),
    "the plugin is not loaded": ("a correct robot passes", "PYTEST_DISABLE_PLUGIN_AUTOLOAD"),
    "nothing is measured": (
        "a statement that no test covers is named with its line",
        "import sys\nsys.settrace = lambda *a: None\nimport coverage\ncoverage.Coverage.start = lambda self: None\n",
    ),
    "runs depend on chance": (
        "a session repeats bit for bit, with other hashes and on two workers",
        "import os, time\nSHIFT = os.urandom(4)\nimport pytest_hricdv.generate.rng as R\nold = R.make_rng\n"
        "R.make_rng = lambda *a: old(*a, SHIFT.hex())\n",
    ),
    "pytest is another one": ("a correct robot passes", "raise SystemExit('no pytest here')\n"),
}


@pytest.mark.slow
@pytest.mark.parametrize("how", BREAK)
def test_a_broken_installation_is_found(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    title, text = BREAK[how]
    (tmp_path / "broken").mkdir()
    (tmp_path / "sessions").mkdir()
    if text.isupper():
        monkeypatch.setenv(text, "1")
    else:
        (tmp_path / "broken" / "sitecustomize.py").write_text(text, encoding="utf-8")
        monkeypatch.setenv("PYTHONPATH", str(tmp_path / "broken"))
    ((_, problem),) = qualify(tmp_path / "sessions", [entry for entry in KNOWN_ANSWERS if entry[0] == title])
    assert problem
