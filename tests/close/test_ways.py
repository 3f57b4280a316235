"""The ways together, on a handover that needs no simulation."""

from __future__ import annotations

import pytest

from pytest_hricdv.close.archive import Archive
from pytest_hricdv.close.disturbance_way import DisturbanceWay
from pytest_hricdv.close.experience import Experience
from pytest_hricdv.close.interactions import Dose
from pytest_hricdv.close.loop import Loop
from pytest_hricdv.close.model_way import ModelWay, UntriedWay
from pytest_hricdv.close.scripts import Scripts
from pytest_hricdv.close.way import Way
from pytest_hricdv.generate.abstract import identify
from pytest_hricdv.generate.rng import make_rng
from pytest_hricdv.search import Budget
from tests.close import handover


def loop(seed: int, *, disturbing: bool = True) -> Loop:
    """A loop as a session has it."""
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience = Experience(scripts)
    ways: tuple[Way, ...] = (ModelWay(scripts, experience),)
    if disturbing:
        ways = (*ways, DisturbanceWay(scripts, experience, handover.DISTURBANCES))
    return Loop(Archive(handover.WANTED), ways, handover.runner, seed, Budget(400), last=UntriedWay(scripts))


@pytest.mark.parametrize("seed", range(4))
def test_all_is_closed_though_some_bins_need_two_certain_disturbances_at_once(seed: int) -> None:
    closing = loop(seed)
    assert closing.run() == "closed"


def test_without_disturbances_what_only_they_lead_to_stays_open() -> None:
    closing = loop(0, disturbing=False)
    assert closing.run() in ("runs", "nothing to try")
    unreachable = {("bin", "handover", count, pose, "given") for count in "123" for pose in ("00", "01", "10")}
    assert unreachable < set(closing.archive.open)
    assert ("verdict", "R5", "Passed") not in closing.archive.open


def test_what_is_aimed_at_is_hit_more_often_than_by_chance() -> None:
    closing = loop(1)
    closing.run()
    aimed = [entry for entry in closing.archive.entries if entry.aims]
    hits = sum(bool({*entry.aims} & {*entry.new}) for entry in aimed)
    assert hits > 0.7 * sum(bool(entry.new) for entry in closing.archive.entries)


def test_disturbances_are_tried_where_interactions_end_as_those_do_in_which_few_were_tried() -> None:
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(scripts), Archive([("statement", "robot.py", "7")])
    undisturbed = [numbers[0] for numbers in scripts.by_slot.values()]
    drafts = [scripts.draft(number) for number in undisturbed for _ in range(3)]
    drafts += [scripts.draft(0, "handover", [(Dose(1, name),)]) for name in ("shake", "ready_lost") for _ in range(20)]
    for test in identify("closure", 0, drafts):
        archive.add(handover.run(test))
    found = DisturbanceWay(scripts, experience, {"shake": {}, "ready_lost": {}}).propose(archive, 4, make_rng("few"))
    assert all("set gaze = 1" in each.draft.lines and "set grip = 1" in each.draft.lines for each in found)
    assert all(any(line.startswith("disturb ") for line in each.draft.lines) for each in found)
