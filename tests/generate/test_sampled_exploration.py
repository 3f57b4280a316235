"""Where not all runs of a model can be found: runs of belief sets that are drawn, and why."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import pytest

from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import ModelRun
from pytest_hricdv.generate.model_runner import SAMPLES, ModelRunner, explore_by_sampling, explore_exhaustively
from tests.generate.toy import VISITOR, lamps

MANY = BeliefSpace(start=("hall", "cellar"), groups={f"wish {n}": (f"a{n}", f"b{n}") for n in range(8)})
WISHES = "".join(f"@w{n} +!wish : a{n} & b{(n + 1) % 8} <- set_lamp(level, {n}).\n" for n in range(8))


def runner_of(folder: Path, visitor: str = "", space: BeliefSpace = MANY) -> ModelRunner:
    mentioned = " ".join(f"+!never : {belief} <- true." for belief in space.others)
    return ModelRunner(lamps(folder, visitor=visitor or VISITOR.replace("@v3", WISHES + mentioned + "@v3", 1)), space)


def test_a_model_that_is_not_enumerable_says_why_and_gives_runs_of_drawn_sets(tmp_path: Path) -> None:
    runner = runner_of(tmp_path)
    reason = explore_exhaustively(runner).reason
    assert reason.startswith("too large: 16 beliefs besides the start beliefs, of which more than 9 cannot be tried")
    assert "agent 'usher' does other things with its percepts chosen(B) than to tell B" in reason
    exploration = explore_by_sampling(runner, reason)
    assert not exploration.complete
    assert exploration.reason.startswith(f"{reason}; so {SAMPLES} sets of beliefs were drawn, which gave ")
    assert len(exploration.runs) > 5
    for found in exploration.runs:
        assert runner.run(exploration.belief_set(found.beliefs)).lines == found.lines
    assert explore_by_sampling(runner_of(tmp_path), reason) == exploration, "the same in each session"


def test_sets_that_the_model_fails_with_are_left_out_and_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = ModelRunner.run

    def fails_in_the_dark(self: ModelRunner, beliefs: Iterable[str]) -> ModelRun:
        chosen = tuple(beliefs)
        if "a0" in chosen:
            raise GenerateError("BDI model lamps.mas2j: the guide cannot go on")
        return run(self, chosen)

    monkeypatch.setattr(ModelRunner, "run", fails_in_the_dark)
    exploration = explore_by_sampling(runner_of(tmp_path), "too large")
    assert exploration.runs
    assert "of them the model failed; the first: BDI model lamps.mas2j: the guide cannot go on" in exploration.reason


def test_a_model_that_always_fails_is_an_error(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(self: ModelRunner, beliefs: object) -> None:
        raise GenerateError("BDI model lamps.mas2j: the guide cannot go on")

    runner = runner_of(tmp_path)
    monkeypatch.setattr(ModelRunner, "run", fails)
    with pytest.raises(GenerateError, match="the guide cannot go on"):
        explore_by_sampling(runner, "too large")
