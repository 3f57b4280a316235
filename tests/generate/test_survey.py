"""The survey of a model: the runs that trying every belief set shows, found without trying them."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path

import pytest

import conftest
from pytest_hricdv.bdi.memo import survey as memo_survey
from pytest_hricdv.generate.beliefs import BeliefSpace
from pytest_hricdv.generate.error import GenerateError
from pytest_hricdv.generate.explorer import Explorer
from pytest_hricdv.generate.survey import NOT_APART, TOO_LARGE, Survey, survey
from tests.generate.toy import LAMPS, lamps

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


def tried(explorer: Explorer, plans: tuple[tuple[str, str], ...]) -> dict[tuple[tuple[str, ...], int], int]:
    """Every run, by trying all sets -> the size of the smallest set."""
    found: dict[tuple[tuple[str, ...], int], int] = {}
    for size in range(len(explorer.space.others) + 1):
        for start in explorer.space.start:
            for chosen in combinations(explorer.space.others, size):
                run = explorer.explore((start, *chosen))
                mask = sum(1 << place for place, (agent, label) in enumerate(plans) if label in run.plans[agent])
                found.setdefault((run.lines, mask), size + 1)
    return found


@pytest.mark.parametrize("space", SPACES.values(), ids=SPACES.keys())
def test_the_survey_has_exactly_the_runs_that_trying_all_sets_shows(space: BeliefSpace) -> None:
    found = survey(Explorer(TABLE.model, space))
    assert found.proven
    expected = tried(Explorer(TABLE.model, space), found.plans)
    assert {(run.lines, run.plans) for run in found.runs} == expected.keys()
    explorer = Explorer(TABLE.model, space)
    for run in found.runs:
        shown = explorer.explore(found.chosen(run.beliefs))
        assert shown.lines == run.lines
        assert run.beliefs.bit_count() == expected[run.lines, run.plans]


def test_the_table_is_surveyed_without_trying_its_sets() -> None:
    """Each leg has eight poses or none, the first one may be given up for boredom; of 4 * 2^34 sets no more differ."""
    explorer = Explorer(TABLE.model, TABLE.beliefs)
    found = survey(explorer)
    assert found.proven
    assert len(found.runs) == 2 * (9 + 9**2 + 9**3 + 9**4)
    assert explorer.runs == 0
    for run in found.runs[::500]:
        shown = explorer.explore(found.chosen(run.beliefs))
        assert shown.lines == run.lines
        assert {(agent, label) for agent, labels in shown.plans.items() for label in labels} == {
            plan for place, plan in enumerate(found.plans) if run.plans >> place & 1
        }


def test_a_survey_is_the_same_from_the_cache() -> None:
    found = survey(Explorer(TABLE.model, SPACES["last leg"]))
    assert Survey.from_json(json.loads(json.dumps(found.to_json()))) == found
    empty = Survey(reason=TOO_LARGE)
    assert Survey.from_json(json.loads(json.dumps(empty.to_json()))) == empty


@pytest.mark.parametrize("change", [{"schema": "hricdv-survey/0"}, {"runs": "?,zz,1"}, {"runs": "0"}, {"plans": None}])
def test_a_spoilt_cache_is_noticed(change: dict[str, object]) -> None:
    data = survey(Explorer(TABLE.model, SPACES["two legs"])).to_json()
    with pytest.raises(GenerateError):
        Survey.from_json(data | change)
    with pytest.raises(GenerateError):
        Survey.from_json({})


def test_a_small_space_of_another_model_is_tried_set_by_set(tmp_path: Path) -> None:
    explorer = Explorer(lamps(tmp_path), LAMPS)
    found = survey(explorer)
    assert found.proven
    expected = tried(Explorer(lamps(tmp_path), LAMPS), found.plans)
    assert {(run.lines, run.plans) for run in found.runs} == expected.keys()


def test_what_cannot_be_surveyed_is_not_proven(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memo_survey, "MAX_RUNS", 100)
    assert survey(Explorer(TABLE.model, TABLE.beliefs)) == Survey(*_names(), reason=TOO_LARGE)
    monkeypatch.undo()
    monkeypatch.setattr(Explorer, "every_run", lambda self, plans: None)
    assert survey(Explorer(TABLE.model, TABLE.beliefs)) == Survey(*_names(), reason=NOT_APART)


def _names() -> tuple[tuple[tuple[str, str], ...], tuple[str, ...]]:
    labels = Explorer(TABLE.model, TABLE.beliefs).plan_labels
    return tuple((agent, label) for agent, plans in labels.items() for label in plans), TABLE.beliefs.beliefs
