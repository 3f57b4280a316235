"""A recording of the real system gives a draft its ranges, and what the two do not share is said."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.first_runs import run
from pytest_hricdv.extra.draft.project.draft import Draft
from pytest_hricdv.extra.draft.project.files import files
from pytest_hricdv.extra.draft.recorded import with_recordings
from tests.recordings.bags import Entry, write_mcap

BAR = '''
from dataclasses import dataclass


@dataclass(frozen=True)
class Order:
    drink: str
    level_ml: float
    cups: int


@dataclass(frozen=True)
class Cancel:
    """Nobody wants it any more."""


@dataclass(frozen=True)
class Served:
    level_ml: float


def work(bus, clock):
    orders, cancels = bus.subscribe(Order), bus.subscribe(Cancel)
    while True:
        order = orders.wait(20.0)
        if order is None:
            return
        if cancels.poll() is None and order.drink in ("tea", "coffee"):
            clock.sleep(order.level_ml / 100)
            bus.publish(Served(order.level_ml))
'''


def order(number: int, drink: str = "tea") -> dict[str, object]:
    return {"drink": drink, "level_ml": 150.0 + 10 * number, "cups": 1 + number % 3}


def orders(count: int) -> list[Entry]:
    """Orders, 10 s after each other; a drink 1.5 s after each."""
    entries: list[Entry] = []
    for number in range(count):
        drink = "milk" if number == 3 else "tea"
        entries += [
            (10.0 * number, "/order", order(number, drink)),
            (10.0 * number + 1.5, "/served", {"level_ml": 1.0}),
        ]
    return entries


def drafted(tmp_path: Path, entries: Sequence[Entry]) -> tuple[CodeModel, dict[str, str]]:
    (tmp_path / "bar.py").write_text(BAR, encoding="utf-8")
    recording = write_mcap(tmp_path / "day.mcap", entries)
    model = with_recordings(analyse("bar", tmp_path), [recording], {})
    draft = Draft(model, "bar_tests", "person", tmp_path.resolve())
    return model, dict(files(draft))


def test_numbers_are_those_of_the_recording(tmp_path: Path) -> None:
    _, texts = drafted(tmp_path, orders(12))
    lines = texts["conftest.py"]
    assert 'level_ml=Uniform(139, 271, "ml"),  # observed in 12 messages of day.mcap' in lines
    assert "cups=Uniform(1, 3),  # observed in 12 messages of day.mcap" in lines


def test_texts_that_were_observed_come_after_those_of_the_code(tmp_path: Path) -> None:
    model, texts = drafted(tmp_path, orders(12))
    drink = model.inputs[0].fields[0]
    assert [str(value.location) for value in drink.values][2:] == ["observed in 12 messages of day.mcap"]
    assert '"order.drink": Field(values=("tea", "coffee", "milk", "something else"))' in texts["conftest.py"]


@pytest.mark.parametrize(
    "drinks",
    [[f"drink {n}" for n in range(20)], ["tea, " + 8 * "but not as hot "]],
)
def test_texts_that_people_write_are_a_question(tmp_path: Path, drinks: list[str]) -> None:
    entries: list[Entry] = [(10.0 * n, "/order", order(n, drinks[n % len(drinks)])) for n in range(20)]
    model, texts = drafted(tmp_path, entries)
    assert '"order.drink": Field(values=("tea", "coffee"' in texts["conftest.py"]
    assert drinks[0] not in texts["conftest.py"]
    asked = "Which strings of `order.drink` matter? day.mcap has too many, or too long ones"
    assert asked in [question.text for question in model.questions]


def test_messages_that_only_one_of_them_has_are_said(tmp_path: Path) -> None:
    stray: list[Entry] = [(1.0, "/joy", {"x": 1.0}), (2.0, "/joy", {"x": 2.0}), (3.0, "/rosout", {"msg": "hello"})]
    model, _ = drafted(tmp_path, [*orders(12), *stray])
    assert "the code receives Cancel: no message of it in day.mcap, so nothing is observed of it" in problems(model)
    assert "day.mcap: has 2 messages of /joy, which the code neither publishes nor receives" in problems(model)
    assert "rosout" not in problems(model)


def test_few_messages_are_a_question(tmp_path: Path) -> None:
    model, texts = drafted(tmp_path, orders(1))
    assert "# TODO: observed in 1 message of day.mcap" in texts["conftest.py"]
    questions = [question.text for question in model.questions]
    assert "Is that all? day.mcap has 1 message of /order: too few to trust its ranges" in questions


def test_a_recording_of_which_nothing_can_be_read_changes_nothing_else(tmp_path: Path) -> None:
    _, plain = drafted(tmp_path, orders(12))
    (tmp_path / "day.mcap").write_bytes(b"")
    model = with_recordings(analyse("bar", tmp_path), [tmp_path / "day.mcap"], {})
    assert "day.mcap: not an MCAP file that can be read" in problems(model)
    draft = Draft(model, "bar_tests", "person", tmp_path.resolve())
    assert 'level_ml=Uniform(0.0, 1.0, "ml")' in dict(files(draft))["conftest.py"]
    assert plain.keys() == dict(files(draft)).keys()


def test_a_namespace_of_the_recording_is_no_other_topic(tmp_path: Path) -> None:
    entries = [(time_s, f"/bar1{topic}", content) for time_s, topic, content in orders(12)]
    _, texts = drafted(tmp_path, entries)
    assert 'Uniform(139, 271, "ml")' in texts["conftest.py"]


def problems(model: CodeModel) -> str:
    return "\n".join(problem.text for problem in model.problems)


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--from", "bar", "--recording", "gone.mcap"], "--recording=gone.mcap: there is no file or folder"),
        (["--recording", "day.mcap"], "--recording: expected --from or --ros2, too"),
    ],
)
def test_a_wrong_option_is_one_sentence(
    arguments: list[str],
    problem: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    drafted(tmp_path, orders(1))
    monkeypatch.chdir(tmp_path)
    assert main(["init", "hri", *arguments]) == 2
    assert problem in capsys.readouterr().err
    assert not (tmp_path / "hri").exists()


@pytest.mark.slow
def test_the_learned_suite_of_a_draft_of_a_recording_is_green(tmp_path: Path) -> None:
    (tmp_path / "bar.py").write_text(BAR, encoding="utf-8")
    recording = write_mcap(tmp_path / "day.mcap", orders(12))
    model = with_recordings(analyse("bar", tmp_path), [recording], {})
    trial = run(Draft(model, "bar_tests", "person", tmp_path.resolve()), "rl", 60.0, 6)
    assert not trial.error
    assert trial.tests == 6


def test_a_number_stays_on_its_side_of_what_the_code_compares_it_with(tmp_path: Path) -> None:
    code = BAR.replace('order.drink in ("tea", "coffee")', "order.level_ml > 200.0")
    (tmp_path / "bar.py").write_text(code, encoding="utf-8")
    recording = write_mcap(tmp_path / "day.mcap", orders(12))
    model = with_recordings(analyse("bar", tmp_path), [recording], {})
    texts = dict(files(Draft(model, "bar_tests", "person", tmp_path.resolve())))
    lines = [line for line in texts["conftest.py"].splitlines() if "level_ml=Uniform(" in line]
    assert len(lines) > 1
    assert len({line.partition("#")[0] for line in lines}) > 1
