"""Dialogs that first runs find: what a person has to say in an order that no source says."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.first_runs.dialogs import (
    AT_END,
    WAITS,
    Dialog,
    Reached,
    alphabet,
    found_dialogs,
    text_of,
)
from pytest_hricdv.extra.draft.first_runs.session import Trial, covered, reached_in
from pytest_hricdv.extra.draft.first_runs.trial import LATE, tried
from pytest_hricdv.extra.draft.writing.drafted import Draft
from pytest_hricdv.extra.draft.writing.project import files

SAFE = '''
"""A box that opens for three words in the right order."""
import queue

WORDS = ("knock", "key", "push")


def run(inbox: queue.Queue, outbox: queue.Queue):
    number = 0
    while True:
        word = inbox.get()
        if word == "knock" and number == 0:
            number = 1
            outbox.put("who is there?")
        elif word == "key" and number == 1:
            number = 2
            outbox.put("come in")
        elif word == "push" and number == 2:
            number = 0
            outbox.put("open")
        elif word == "bell":
            number = 0
            outbox.put("nobody is at home")
'''

ORDER = ("inbox_text_knock in_time", "inbox_text_key in_time", "inbox_text_push in_time")
"""What opens it."""


@pytest.fixture
def draft(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Draft:
    (tmp_path / "robot_code.py").write_text(SAFE, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return Draft(analyse("robot_code", tmp_path), "robot_code", "person", tmp_path.resolve())


def steps_in_order(dialog: Dialog, order: Sequence[str]) -> int:
    """How far a dialog comes: each wrong word but the last is one from the beginning."""
    number = 0
    for word in dialog:
        if word != WAITS and number < len(order):
            number = number + 1 if word == order[number] else int(word == order[0])
    return number


def lock(order: Sequence[str], dialogs: Sequence[Dialog]) -> dict[Dialog, Reached]:
    """A simulated code: a statement more with each right word."""
    reached = {}
    for dialog in dialogs:
        number = steps_in_order(dialog, order)
        reached[dialog] = frozenset({f"{AT_END} {number}", *(f"statement {n}" for n in range(number + 1))})
    return reached


@pytest.mark.parametrize("timeline", [{}, {"timeline": None}, {"timeline": {"end_s": 2.0}}])
def test_a_run_without_texts_comes_to_its_code_only(timeline: dict[str, object]) -> None:
    bare = {"code": {"bits": ["0x5", "0x2"]}, "acted_s": [], **timeline}
    assert {"statement 0", "statement 2", "branch 1"} == {point for point in reached_in(bare) if AT_END not in point}
    assert len(reached_in({"code": None, **timeline})) == 1  # that it ended


def test_a_situation_is_all_that_texts_are_and_the_last_one_is_that_after_the_last_answer() -> None:
    texts = {"state": [[0.0, ""], [1.0, "open"], [9.0, "late"]], "said": [[0.0, ""], [2.0, "room 12"]]}
    steps = ["open in_time", "wait_answer", "wait_quiet"]  # what comes after the dialog does not count
    points = reached_in({"code": None, "timeline": {"texts": texts}, "acted_s": [0.5, 1.5, 3.0], "abstract": steps})
    assert {point for point in points if point.startswith("text")} == {
        "text state:  -> open", "text state: open -> late", "text said:  -> room #",
    }  # fmt: skip
    assert f'{AT_END} {{"said": "room #", "state": "open"}}' in points


def test_the_words_are_those_that_the_code_knows(draft: Draft) -> None:
    assert {*ORDER, "inbox_text_bell in_time", "inbox_text_other in_time"} == {*alphabet(draft)}


@given(data=st.data())
def test_an_order_of_three_words_is_found_whatever_it_is(data: st.DataObject) -> None:
    words = [f"word_{letter} in_time" for letter in "abcdefgh"]
    order = data.draw(st.lists(st.sampled_from(words), min_size=3, max_size=3, unique=True))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("pytest_hricdv.extra.draft.first_runs.dialogs.alphabet", lambda draft: tuple(words))
        told = Draft(analyse("pytest_hricdv.extra.draft.reading.naming"), "r", "person", Path())
        patch.setattr(Draft, "things", ["something"])
        dialogs = found_dialogs(told, lambda dialogs: lock(order, dialogs), frozenset({"statement 0"}))
    assert steps_in_order(dialogs[0], order) == 3
    assert [step for step in dialogs[0] if step != WAITS] == order  # the shortest way


def test_the_search_is_the_same_each_time_and_repeats_nothing(draft: Draft) -> None:
    runs: list[Dialog] = []

    def counted(dialogs: Sequence[Dialog]) -> dict[Dialog, Reached]:
        runs.extend(dialogs)
        return lock(ORDER, dialogs)

    first = found_dialogs(draft, counted, frozenset())
    assert len({*runs}) == len(runs)
    assert found_dialogs(draft, lambda dialogs: lock(ORDER, dialogs), frozenset()) == first


def test_where_other_runs_come_to_all_no_dialog_is_kept(draft: Draft) -> None:
    everything = frozenset({f"{kind} {n}" for kind in (AT_END, "statement") for n in range(4)})
    assert found_dialogs(draft, lambda dialogs: lock(ORDER, dialogs), everything) == ()


def test_dialogs_that_fail_end_the_search(draft: Draft) -> None:
    sessions: list[int] = []

    def failing(dialogs: Sequence[Dialog]) -> dict[Dialog, Reached]:
        sessions.append(len(dialogs))
        return {}

    assert found_dialogs(draft, failing, frozenset()) == ()
    assert len(sessions) == 1


def test_a_person_who_has_nothing_to_say_has_no_dialogs(tmp_path: Path) -> None:
    (tmp_path / "clock.py").write_text("import time\n\n\ndef run():\n    time.sleep(1.0)\n", encoding="utf-8")
    silent = Draft(analyse("clock", tmp_path), "clock", "person", tmp_path.resolve())
    assert found_dialogs(silent, lambda dialogs: pytest.fail("it runs something"), frozenset()) == ()


def test_each_dialog_is_a_plan_of_the_person(draft: Draft) -> None:
    texts = dict(files(replace(draft, dialogs=((ORDER[0], WAITS, ORDER[1]),))))
    tells = ".send(robot, achieve, heard_inbox_text)"
    body = f"inbox_text_knock(in_time); {tells}; wait_answer; inbox_text_key(in_time); {tells}"
    assert f"@dialog_1 +!round : dialog_1 <- {body}.\n" in texts["models/person.asl"]
    assert '"dialog_1"' in texts["conftest.py"]


@pytest.mark.parametrize(("limit_s", "said"), [(0.0, True), (30.0, False)])
def test_a_search_that_was_ended_says_so(
    limit_s: float, said: bool, draft: Draft, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pytest_hricdv.extra.draft.first_runs.trial.SEARCH_S", limit_s)
    monkeypatch.setattr("pytest_hricdv.extra.draft.first_runs.trial.run", lambda *_: Trial(8, 8, (), (), "", ()))
    monkeypatch.setattr("pytest_hricdv.extra.draft.first_runs.trial.covered", lambda _, dialogs: lock(ORDER, dialogs))
    settled, _ = tried(draft)
    assert [problem.text for problem in settled.findings.problems if problem.kind == LATE] == (
        ["the search for dialogs ended after 0 s of processor time: a longer one may find others"] if said else []
    )
    assert bool(settled.dialogs) is not said


@pytest.mark.slow
def test_first_runs_find_the_order_that_opens_the_box(draft: Draft) -> None:
    dialogs = found_dialogs(draft, lambda dialogs: covered(draft, dialogs), frozenset())
    said = [" ".join(step for step in dialog if step != WAITS) for dialog in dialogs]
    assert any(" ".join(ORDER) in dialog for dialog in said)
    assert text_of(dialogs).count("inbox_text_push in_time") >= 1


@pytest.mark.slow
def test_a_draft_with_dialogs_is_green_and_opens_the_box(draft: Draft) -> None:
    command = [sys.executable, "-m", "pytest_hricdv", "init", "draft", "--from", "robot_code"]
    made = subprocess.run(command, cwd=draft.folder, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    for suite in ("rl", "closure"):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", f"--hri-suite={suite}"],
            cwd=draft.folder / "draft", capture_output=True, text=True, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout
        report = (draft.folder / "draft" / "hri-report" / "report.json").read_text(encoding="utf-8")
        assert '{\\"text\\":\\"open\\"}' in report or '"open"' in report
