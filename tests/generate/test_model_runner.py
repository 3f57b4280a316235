"""The model runner: from a belief subset to an abstract test, and its errors."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import pytest

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Model
from pytest_hricdv.generate.model_runner import ModelRunner
from tests.generate.toy import GUIDE, LAMPS, VISITOR, lamps


def test_runs_do_not_leak_into_each_other_and_order_does_not_matter(tmp_path: Path) -> None:
    runner = ModelRunner(lamps(tmp_path), LAMPS)
    first = runner.run(["hall", "polite", "bright"])
    assert runner.run([]).lines == ()
    assert {runner.run(beliefs) for beliefs in permutations(["hall", "polite", "bright"])} == {first}
    assert runner.run_count == 8
    assert runner.notes() == ()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"actor": "visitors"}, "no agent 'visitors'.*; nearest: visitor"),
        ({"steering_agent": "meta"}, "no agent 'meta'"),
        ({"covered": ("visitor", "giude")}, "no agent 'giude'.*; nearest: guide"),
        ({"covered": ("usher",)}, "agent 'usher' has no labelled plan"),
    ],
)
def test_a_model_without_its_agents_is_an_error(tmp_path: Path, change: dict[str, object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        ModelRunner(replace(lamps(tmp_path), **change), LAMPS)  # type: ignore[arg-type]


def test_a_belief_that_the_actor_never_mentions_is_an_error(tmp_path: Path) -> None:
    space = BeliefSpace(LAMPS.start, {**LAMPS.groups, "more": ("dimm",)})
    with pytest.raises(GenerateError, match=r"'dimm'.*nowhere in agent 'visitor'.*; nearest: dim"):
        ModelRunner(lamps(tmp_path), space)


def test_an_action_without_a_text_form_is_an_error(tmp_path: Path) -> None:
    visitor = VISITOR.replace("enter(hall)", "enter(hall, 1, 2)")
    with pytest.raises(GenerateError, match="has no text form"):
        ModelRunner(lamps(tmp_path, visitor=visitor), LAMPS).run(["hall"])


def test_a_model_that_cannot_be_read_is_an_error(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match=r"gone.mas2j"):
        ModelRunner(Model(tmp_path / "gone.mas2j"), LAMPS)
    with pytest.raises(GenerateError, match=r"guide.asl:\d+:\d+"):
        ModelRunner(lamps(tmp_path, guide=GUIDE + "@g3 +!x <- ;;"), LAMPS)


@pytest.mark.parametrize(
    "loop", ["+!g <- !g.", "+!g <- !!g.", "+!g <- .fail.\n-!g <- !g.", "+!g <- .random(X); -+seen(X); !g."]
)
def test_a_plan_without_end_is_noted_with_its_place(tmp_path: Path, loop: str) -> None:
    visitor = VISITOR.replace("greet; set_lamp(level, 100);", "greet; !g;") + f"\n{loop}\n"
    runner = ModelRunner(replace(lamps(tmp_path, visitor=visitor), max_rounds=200), LAMPS)
    runner.run(["hall"])
    assert runner.notes() == ()
    runner.run(["hall", "polite", "bright"])
    assert any("visitor.asl:10:1: plan @" in note and "never ends in 1 runs" in note for note in runner.notes())


def test_runs_in_which_nobody_acts_are_noted(tmp_path: Path) -> None:
    runner = ModelRunner(lamps(tmp_path, visitor=re.sub("<- .*", "<- !wish.", VISITOR)), LAMPS)
    runner.run(["hall"])
    (note,) = runner.notes()
    assert note.startswith("no run of the model has an action of visitor: ")


def test_runs_of_which_none_ends_are_an_error(tmp_path: Path) -> None:
    model = lamps(tmp_path, guide=GUIDE + "@g3 +asked <- !g.\n+!g <- .random(X); -+seen(X); !g.\n!g.\n")
    runner = ModelRunner(replace(model, max_rounds=50), LAMPS)
    assert runner.run(["hall"]).rounds == 50
    with pytest.raises(GenerateError, match=r"^1 of 1 runs of the model were cut off after 50 rounds; .*guide.asl:5:1"):
        runner.notes()


@pytest.mark.parametrize(
    ("change", "message"), [({"covered": ()}, "no covered"), ({"max_rounds": 0}, "max_rounds = 0")]
)
def test_an_invalid_model_is_an_error(change: dict[str, object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        Model(Path("x.mas2j"), **change)  # type: ignore[arg-type]


def test_a_model_that_was_changed_is_loaded_again(tmp_path: Path) -> None:
    before = ModelRunner(lamps(tmp_path), LAMPS).run(["hall"])
    changed = ModelRunner(lamps(tmp_path, visitor=VISITOR.replace("leave.", "wait.")), LAMPS)
    assert (before.lines, changed.run(["hall"]).lines) == (("enter hall", "leave"), ("enter hall", "wait"))
    assert ModelRunner(lamps(tmp_path), LAMPS).run(["hall"]) == before
