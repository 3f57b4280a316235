"""Robots with a planted race."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from studies.races import __doc__ as described
from studies.races import peers
from studies.races.__main__ import PAGE, fails, kept
from studies.races.catalogue import ANCHORS, RACES
from studies.races.peer_models import THREADS


def test_held_out_robots_are_named() -> None:
    held_out = [race.name for race in RACES if race.is_held_out]
    assert len(held_out) == 19
    assert all(name in (described or "") for name in held_out)


def test_race_of_a_robot_is_found_and_kept(tmp_path: Path) -> None:
    race = next(race for race in RACES if race.name == "check_then_act")
    results = tmp_path / "results.json"
    found = kept(race, results, 0, 10)
    assert fails(found)
    assert "robot.py:" in found[0]["words"]
    results.write_text('{"check_then_act robot 10 0": []}', encoding="utf-8")
    assert kept(race, results, 0, 10) == []


@pytest.mark.parametrize("name", THREADS)
def test_model_holds_where_one_worker_follows_the_other(name: str) -> None:
    model = THREADS[name]()
    for number in range(model.workers):
        model.serve(number)
    assert model.holds()
    assert name in {race.name for race in ANCHORS}


def test_page_shows_what_other_explorers_found() -> None:
    results, ours = (json.loads((peers.HERE / name).read_text()) for name in ("peers.json", "results.json"))
    assert peers.tables(results, ours) in PAGE.read_text(encoding="utf-8")
