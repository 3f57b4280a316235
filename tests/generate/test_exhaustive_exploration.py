"""Exhaustive exploration of a model: the runs of all belief sets, found without running each of them."""

from __future__ import annotations

import json
from itertools import combinations

import pytest

import conftest
from pytest_hricdv.bdi.memo import decision_diagram
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.model import Exploration
from pytest_hricdv.generate.model_runner import NOT_ENUMERABLE, TOO_LARGE, ModelRunner, explore_exhaustively

TABLE = conftest.pytest_hricdv_testbench(None)  # type: ignore[arg-type]
#: Small enough to try all sets; with what makes trouble: boredom, and several poses for one leg.
SPACES = {
    "last leg": BeliefSpace(("leg4",), {"mood": ("bored",), "pose": tuple(f"m{n:03b}l4" for n in range(8))}),
    "two legs": BeliefSpace(
        ("leg3", "leg4"), {"mood": ("bored",), "third": ("m000l3", "m111l3", "m011l3"), "fourth": ("m111l4", "m110l4")}
    ),
    "a pose for another leg": BeliefSpace(
        ("leg2", "leg3"), {"pose": ("m111l1", "m101l2", "m000l3", "m111l4"), "mood": ("bored",)}
    ),
}


def run_all_sets(runner: ModelRunner, plans: tuple[tuple[str, str], ...]) -> dict[tuple[tuple[str, ...], int], int]:
    """Every distinct run, by running all sets -> the size of its smallest set."""
    found: dict[tuple[tuple[str, ...], int], int] = {}
    for size in range(len(runner.space.others) + 1):
        for start in runner.space.start:
            for chosen in combinations(runner.space.others, size):
                run = runner.run((start, *chosen))
                mask = sum(1 << place for place, (agent, label) in enumerate(plans) if label in run.plans[agent])
                found.setdefault((run.lines, mask), size + 1)
    return found


@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES.keys())
def test_exploration_finds_exactly_the_runs_of_all_sets(space: BeliefSpace) -> None:
    found = explore_exhaustively(ModelRunner(TABLE.model, space))
    assert found.complete
    expected = run_all_sets(ModelRunner(TABLE.model, space), found.plans)
    assert {(run.lines, run.plans) for run in found.runs} == expected.keys()
    runner = ModelRunner(TABLE.model, space)
    for run in found.runs:
        shown = runner.run(found.belief_set(run.beliefs))
        assert shown.lines == run.lines
        assert run.beliefs.bit_count() == expected[run.lines, run.plans]


def test_the_table_is_explored_without_running_its_sets() -> None:
    """Each leg has eight poses or none, and the human may get bored at the first; 4 * 2^34 sets give no other runs."""
    runner = ModelRunner(TABLE.model, TABLE.beliefs)
    found = explore_exhaustively(runner)
    assert found.complete
    assert len(found.runs) == 2 * (9 + 9**2 + 9**3 + 9**4)
    assert runner.run_count == 0
    for run in found.runs[::500]:
        shown = runner.run(found.belief_set(run.beliefs))
        assert shown.lines == run.lines
        assert {(agent, label) for agent, labels in shown.plans.items() for label in labels} == {
            plan for place, plan in enumerate(found.plans) if run.plans >> place & 1
        }


def test_an_exploration_is_the_same_from_the_cache() -> None:
    found = explore_exhaustively(ModelRunner(TABLE.model, SPACES["last leg"]))
    assert Exploration.from_json(json.loads(json.dumps(found.to_json()))) == found
    empty = Exploration(reason=TOO_LARGE)
    assert Exploration.from_json(json.loads(json.dumps(empty.to_json()))) == empty


@pytest.mark.parametrize(
    "change", [{"schema": "hricdv-exploration/0"}, {"runs": "?,zz,1"}, {"runs": "0"}, {"plans": None}]
)
def test_an_invalid_cache_is_an_error(change: dict[str, object]) -> None:
    data = explore_exhaustively(ModelRunner(TABLE.model, SPACES["two legs"])).to_json()
    with pytest.raises(GenerateError):
        Exploration.from_json(data | change)
    with pytest.raises(GenerateError):
        Exploration.from_json({})


def test_an_exploration_that_is_not_possible_is_not_complete(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(decision_diagram, "MAX_RUNS", 100)
    runner = ModelRunner(TABLE.model, TABLE.beliefs)
    assert explore_exhaustively(runner) == Exploration(*_names(), reason=TOO_LARGE)
    monkeypatch.undo()
    monkeypatch.setattr(ModelRunner, "all_runs", lambda self, plans: None)
    not_enumerable = explore_exhaustively(ModelRunner(TABLE.model, TABLE.beliefs))
    assert not_enumerable == Exploration(*_names(), reason=not_enumerable.reason)
    assert not_enumerable.reason.startswith(NOT_ENUMERABLE.format(len(TABLE.beliefs.others), 9))


def _names() -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    labels = ModelRunner(TABLE.model, TABLE.beliefs).plan_labels
    return tuple((agent, label) for agent, plans in labels.items() for label in plans), TABLE.beliefs.beliefs
