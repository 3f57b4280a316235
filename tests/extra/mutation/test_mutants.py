"""The mutants of a code: found again, each once, with its place, in a seeded order."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.mutation.mutants import sample
from tests.extra.mutation.robots import code_of, mutants_of

ROBOT = """
    def act(robot, turns=4):
        for turn in range(turns):
            robot.bus.publish(
                turn + 1,
            )
        return "done"
"""


def test_a_mutant_has_the_line_that_differs_and_the_number_of_its_statement(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    code = code_of(ROBOT, tmp_path, monkeypatch)
    mutants = mutants_of(ROBOT, tmp_path, monkeypatch)
    assert [(each.line, code.files[0].statements[each.statement]) for each in mutants if "+ 2" in each.after] == [
        (5, 4)
    ]
    assert all(each.text != code.files[0].text for each in mutants)
    for mutant in mutants:
        compile(mutant.text, mutant.file, "exec")


def test_mutants_are_the_same_each_time_and_no_two_are_equal(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mutants = mutants_of(ROBOT, tmp_path, monkeypatch)
    assert mutants == mutants_of(ROBOT, tmp_path, monkeypatch)
    assert len({each.id for each in mutants}) == len({each.text for each in mutants}) == len(mutants) > 8


@pytest.mark.skipif(sys.version_info >= (3, 14), reason="from Python 3.14 on, equal expressions compile to other code")
def test_what_compiles_to_the_same_code_is_no_mutant_and_is_made_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = [each.after for each in mutants_of("def f():\n    return 1 + 1", tmp_path, monkeypatch)]
    assert found == ["return 1 - 1", "return (0) + 1", "return 2 + 1"]  # not 1 + (0) and 1 + 2
    assert [each.after for each in mutants_of("def f():\n    return 0 + 0", tmp_path, monkeypatch)] == [
        "return (-1) + 0",
        "return 1 + 0",
    ]  # not 0 - 0


def test_an_id_does_not_change_with_other_lines(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = {each.id: each.after for each in mutants_of(ROBOT, tmp_path, monkeypatch)}
    longer = "X = 'text'\n" + "\n".join(line[4:] for line in ROBOT.splitlines())
    after = {each.id: each.after for each in mutants_of(longer, tmp_path, monkeypatch)}
    assert before == after


def test_a_sample_is_seeded_and_stands_for_all(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mutants = mutants_of(ROBOT, tmp_path, monkeypatch)
    assert sample(mutants, 1, 3) == sample(mutants, 1, None)[:3]
    assert sorted(sample(mutants, 1, None), key=mutants.index) == list(mutants)
    assert sample(mutants, 1, None) != sample(mutants, 2, None)
