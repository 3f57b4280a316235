"""The methods, on a small model that is not the table; and how they are selected."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.methods import (
    METHODS,
    Pseudorandom,
    ReinforcementLearning,
    select_methods,
)
from pytest_hricdv.generate.suite_files import Files
from tests.generate.table import COMMANDS
from tests.generate.toy import LAMPS, lamps

ORIGINAL = GenerationContext(commands=COMMANDS)


@pytest.fixture
def context(tmp_path: Path) -> GenerationContext:
    by_hand = tmp_path / "by_hand.toml"
    by_hand.write_text(
        '[[belief_set]]\nname = "polite"\nbeliefs = ["?[ae]l*", "polite", "bright"]\n'
        '[[belief_set]]\nbeliefs = ["hall", "curt", "d*"]\nconcretizations = 2\n'
    )
    return GenerationContext(lamps(tmp_path), LAMPS, by_hand=by_hand)


def test_rl_learns_and_covers_the_small_model(context: GenerationContext) -> None:
    suite = ReinforcementLearning().generate(context)
    generation = suite.generation
    assert len({test.beliefs for test in suite.tests}) == len(suite.tests)
    assert suite.plans_covered()["guide"] == generation.declared_plans["guide"]
    assert generation.converged_at is not None
    assert generation.bdi_runs > generation.iterations
    assert len(generation.q_delta) == generation.iterations
    assert generation.notes[0].startswith("134 tests asked for, but the policy leads to ")


def test_pseudorandom_draws_lengths_and_commands() -> None:
    suite = Pseudorandom().generate(ORIGINAL)
    assert len(suite.tests) == 100
    assert {len(test.lines) for test in suite.tests} == set(range(4, 20))
    assert {line for test in suite.tests for line in test.lines} == set(COMMANDS)
    assert all(test.target == f"{len(test.lines)}-actions" and not test.beliefs for test in suite.tests)
    short = Pseudorandom().generate(replace(ORIGINAL, lengths=(1, 1), tests=30))
    assert len(short.tests) == 30
    assert {len(test.lines) for test in short.tests} == {1}


@pytest.mark.parametrize("name", list(METHODS))
def test_the_same_seed_gives_the_same_result_and_another_one_does_not(context: GenerationContext, name: str) -> None:
    context = replace(context, commands=COMMANDS)
    first = METHODS[name].generate(context)
    assert first == METHODS[name].generate(context)
    assert first.name == name
    assert not {test.id for test in first.tests} & {
        test.id for test in METHODS[name].generate(replace(context, seed=1)).tests
    }


@pytest.mark.parametrize("name", list(METHODS))
def test_a_method_without_its_inputs_is_an_error(name: str) -> None:
    with pytest.raises(GenerateError, match="but the testbench "):
        METHODS[name].generate(GenerationContext())


@pytest.mark.parametrize(
    ("options", "message"), [({"tests": 0}, "0 tests"), ({"lengths": (5, 4)}, "random_test_length")]
)
def test_an_invalid_context_is_an_error(options: dict[str, object], message: str) -> None:
    with pytest.raises(GenerateError, match=message):
        GenerationContext(**options)  # type: ignore[arg-type]


def test_selection_by_name_path_and_all(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("bored\n")
    assert select_methods("rl, by-hand,rl", tmp_path) == (METHODS["rl"], METHODS["by-hand"])
    assert select_methods("all", tmp_path) == tuple(METHODS.values())
    assert select_methods("mine.txt,pseudorandom", tmp_path) == (Files(tmp_path / "mine.txt"), METHODS["pseudorandom"])


def test_belief_sets_of_a_file_are_a_suite_of_its_name(context: GenerationContext, tmp_path: Path) -> None:
    (tmp_path / "My moods.toml").write_text('[[belief_set]]\nbeliefs = ["hall", "polite", "bright"]\n')
    (method,) = select_methods("My moods.toml", tmp_path)
    suite = method.generate(context)
    assert (suite.name, len(suite.tests)) == ("My-moods", 1)
    assert suite.tests[0].lines == ("enter hall", "greet", "set_lamp level = 100")


def test_an_unknown_selection_names_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match=r"suite 'byhand' is not a method, .*; nearest: by-hand"):
        select_methods("byhand", tmp_path)
    with pytest.raises(GenerateError, match="selects nothing; known: by-hand, bdi-random, rl, pseudorandom, all"):
        select_methods(" , ", tmp_path)


def test_the_cache_key_changes_with_the_context(context: GenerationContext, monkeypatch: pytest.MonkeyPatch) -> None:
    assert context.model is not None
    changes = [
        context,
        replace(context, seed=1),
        replace(context, tests=5),
        replace(context, commands=COMMANDS),
        replace(context, lengths=(1, 2)),
        replace(context, by_hand=None),
        replace(context, space=None),
        replace(context, space=replace(LAMPS, id_groups=())),
        replace(context, space=replace(LAMPS, default_beliefs=("dim",))),
        replace(context, learning=replace(context.learning, gamma=0.5)),
        replace(context, model=replace(context.model, max_rounds=9)),
    ]
    keys = {each.fingerprint("rl") for each in changes}
    keys.add(context.fingerprint("by-hand"))
    (context.model.path.parent / "guide.asl").write_text("@g1 +asked <- switch.")
    keys.add(context.fingerprint("rl"))
    monkeypatch.setattr("pytest_hricdv.generate.context.GENERATOR_VERSION", "0")
    keys.add(context.fingerprint("rl"))
    assert len(keys) == len(changes) + 3


def test_the_cache_key_does_not_depend_on_folders(tmp_path: Path) -> None:
    keys = set()
    for name in ("here", "there"):
        folder = tmp_path / name
        folder.mkdir()
        keys.add(GenerationContext(lamps(folder), LAMPS).fingerprint("rl"))
    assert len(keys) == 1


def test_a_cache_key_of_a_missing_file_is_an_error(context: GenerationContext, tmp_path: Path) -> None:
    with pytest.raises(GenerateError, match=r"gone\.toml: .*expected a readable file"):
        replace(context, by_hand=tmp_path / "gone.toml").fingerprint("by-hand")
