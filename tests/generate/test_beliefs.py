"""The belief space, belief subsets written by hand, and their errors."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace, read_belief_sets
from tests.generate.table import SPACE
from tests.generate.toy import LAMPS


@pytest.mark.parametrize(
    ("beliefs", "aim"),
    [
        (("m111l1", "bored", "leg1"), "leg1-bored"),
        (("leg4", "m000l4"), "leg4"),
        (("m000l4",), "no-start"),
        ((), "no-start"),
        (("not_bored",), "no-start-not_bored"),
    ],
)
def test_the_target_is_the_start_belief_and_the_naming_groups(beliefs: tuple[str, ...], aim: str) -> None:
    assert SPACE.target(beliefs) == aim


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: BeliefSpace((), {}), "group 'start' of beliefs is empty"),
        (lambda: BeliefSpace(("a",), {"g": ()}), "group 'g' of beliefs is empty"),
        (lambda: BeliefSpace(("a",), {"g": ("a",)}), "belief 'a' is in group 'start' and in group 'g'"),
        (lambda: BeliefSpace(("a", "a"), {}), "belief 'a' is in group 'start' and in group 'start'"),
        (lambda: BeliefSpace(("Leg",), {}), "'Leg' is not a belief"),
        (lambda: BeliefSpace(("a b",), {}), "'a b' is not a belief"),
        (lambda: BeliefSpace(("a",), {"mood": ("b",)}, id_groups=("moods",)), "'moods' is not a group.*nearest: mood"),
        (
            lambda: BeliefSpace(("a",), {"mood": ("b",)}, default_beliefs=("c",)),
            "default belief 'c' is not in the belief space",
        ),
        (lambda: BeliefSpace(("a",), {"start": ("b",)}), "have this name already"),
        (lambda: SPACE.subset(["leg5"]), "'leg5' is not in the belief space; nearest: leg4"),
        (lambda: SPACE.subset(["leg1", "leg1"]), "'leg1' is given twice"),
    ],
)
def test_invalid_arguments_are_errors(make: Callable[[], object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        make()


def _written(folder: Path, text: str) -> Path:
    path = folder / "by_hand.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_patterns_stand_for_every_combination(tmp_path: Path) -> None:
    path = _written(tmp_path, '[[belief_set]]\nname = "x"\nbeliefs = ["hall", "c*t", "d[ia]*"]\n')
    (aim,) = read_belief_sets(path, LAMPS)
    assert aim.subsets == (("hall", "curt", "dim"), ("hall", "curt", "dark"))
    assert aim.concretizations == 1


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('[[belief_set]]\nbeliefs = ["hall",\n  "brigth"]\n', "toml:3:4: unknown belief: 'brigth'; nearest: bright"),
        ('[[belief_set]]\nbeliefs = ["b?"]\n', "toml:2:13: pattern matches no belief: 'b\\?'"),
        (
            '[[belief_set]]\nbeliefs = ["hall"]\n[[belief_set]]\nbelief = ["dim"]\n',
            "toml:4:1: unknown key 'belief'; nearest: beliefs",
        ),
        ('[[aims]]\nbeliefs = ["hall"]\n', "toml:1:3: unknown key 'aims'"),
        ("", "toml:1:1: no \\[\\[belief_set\\]\\] entries"),
        ('[[belief_set]]\nbeliefs = ["hall", "h*"]\n', "toml:2:1: belief 'hall' is given twice"),
        (
            '[[belief_set]]\nbeliefs = ["hall"]\n[[belief_set]]\nbeliefs = ["h*"]\n',
            "toml:4:1: subset hall is in the entry at .*toml:2:1",
        ),
        ('[[belief_set]]\nbeliefs = "hall"\n', "toml:2:1: beliefs = 'hall'; expected a list of strings"),
        ("[[belief_set]]\nname = 'x'\n", "toml:1:1: beliefs = None; expected a list"),
        (
            '[[belief_set]]\nbeliefs = ["hall"]\nconcretizations = 0\n',
            "toml:3:1: concretizations = 0; expected a whole number",
        ),
        ('[[belief_set]]\nbeliefs = ["hall"]\nconcretizations = true\n', "toml:3:1: concretizations = True"),
        ('[[belief_set]]\nbeliefs = ["hall"]\nname = 3\n', "toml:3:1: name 3; expected one line"),
        ('[[belief_set]]\nbeliefs = ["hall"\nname = 3\n', "toml:3:1: .*"),
        ('[[belief_set]]\nbeliefs = ["hall"', "toml:2:1: .*"),
    ],
)
def test_errors_name_file_line_and_column(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        read_belief_sets(_written(tmp_path, text), LAMPS)


def test_a_file_that_is_not_there_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match="expected a TOML file of belief subsets"):
        read_belief_sets(tmp_path / "gone.toml", LAMPS)
