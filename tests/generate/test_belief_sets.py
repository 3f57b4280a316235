"""Belief subsets written by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.generate.belief_sets import read_belief_sets
from pytest_hricdv.generate.error import GenerateError
from tests.generate.table import CONTEXT, SPACE
from tests.generate.toy import LAMPS


def _written(folder: Path, text: str) -> Path:
    path = folder / "by_hand.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_table_has_130_subsets_of_which_two_are_concretized_five_times() -> None:
    assert CONTEXT.by_hand is not None
    aims = read_belief_sets(CONTEXT.by_hand, SPACE)
    subsets = [subset for aim in aims for subset in aim.subsets]
    assert len(subsets) == len(set(subsets)) == 130
    assert [len(aim.subsets) for aim in aims if aim.concretizations == 5] == [2]
    assert sum(len(aim.subsets) * aim.concretizations for aim in aims) == 138
    for start in SPACE.start:
        for mood in ("bored", "not_bored"):
            assert sum({start, mood} <= set(subset) for subset in subsets) == 16


def test_patterns_stand_for_every_combination(tmp_path: Path) -> None:
    path = _written(tmp_path, '[[aim]]\nname = "x"\nbeliefs = ["hall", "c*t", "d[ia]*"]\n')
    (aim,) = read_belief_sets(path, LAMPS)
    assert aim.subsets == (("hall", "curt", "dim"), ("hall", "curt", "dark"))
    assert aim.concretizations == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[aim]]\nbeliefs = ["hall",\n  "brigth"]\n', "toml:3:4: unknown belief: 'brigth'; nearest: bright"),
        ('[[aim]]\nbeliefs = ["b?"]\n', "toml:2:13: pattern matches no belief: 'b\\?'"),
        (
            '[[aim]]\nbeliefs = ["hall"]\n[[aim]]\nbelief = ["dim"]\n',
            "toml:4:1: unknown key 'belief'; nearest: beliefs",
        ),
        ('[[aims]]\nbeliefs = ["hall"]\n', "toml:1:3: unknown key 'aims'"),
        ("", "toml:1:1: no \\[\\[aim\\]\\] entries"),
        ('[[aim]]\nbeliefs = ["hall", "h*"]\n', "toml:2:1: belief 'hall' is given twice"),
        (
            '[[aim]]\nbeliefs = ["hall"]\n[[aim]]\nbeliefs = ["h*"]\n',
            "toml:4:1: subset hall is in the entry at .*toml:2:1",
        ),
        ('[[aim]]\nbeliefs = "hall"\n', "toml:2:1: beliefs = 'hall'; expected a list of strings"),
        ("[[aim]]\nname = 'x'\n", "toml:1:1: beliefs = None; expected a list"),
        (
            '[[aim]]\nbeliefs = ["hall"]\nconcretizations = 0\n',
            "toml:3:1: concretizations = 0; expected a whole number",
        ),
        ('[[aim]]\nbeliefs = ["hall"]\nconcretizations = true\n', "toml:3:1: concretizations = True"),
        ('[[aim]]\nbeliefs = ["hall"]\nname = 3\n', "toml:3:1: name 3; expected one line"),
        ('[[aim]]\nbeliefs = ["hall"\nname = 3\n', "toml:3:1: .*"),
        ('[[aim]]\nbeliefs = ["hall"', "toml:2:1: .*"),
    ],
)
def test_errors_name_file_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        read_belief_sets(_written(tmp_path, text), LAMPS)


def test_an_entry_of_too_many_subsets_is_an_error(tmp_path: Path) -> None:
    path = _written(tmp_path, '[[aim]]\nbeliefs = ["m*l1", "m*l2", "m*l3", "m*l4", "leg?", "*b*", "m*", "m*"]\n')
    with pytest.raises(GenerateError, match=r"toml:2:1: \d+ subsets in one entry; expected at most 100000"):
        read_belief_sets(path, SPACE)


def test_a_file_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match="expected a TOML file of belief subsets"):
        read_belief_sets(tmp_path / "gone.toml", LAMPS)
