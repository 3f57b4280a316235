"""The ways together, on a handover that needs no simulation."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.disturbance_way import DisturbanceWay
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.interactions import Dose
from pytest_hricdv.extra.closing.loop import Loop
from pytest_hricdv.extra.closing.model_way import ModelWay, UntriedWay
from pytest_hricdv.extra.closing.scripts import Scripts, Slot
from pytest_hricdv.extra.closing.way import Way
from pytest_hricdv.extra.search import Budget
from pytest_hricdv.generate.abstract import identify
from pytest_hricdv.generate.chosen_values import RUN
from pytest_hricdv.generate.rng import make_rng
from tests.extra.closing import handover


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


def test_what_worked_is_done_again_with_the_parameters_of_the_run_in_which_it_did() -> None:
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience = Experience(scripts, lambda test: {"patience_s": float(test.seed % 7)})
    archive = Archive([("bin", "handover", "1", pose, "late") for pose in handover.POSES])
    mute = [(Dose(2, "mute", (("for_s", 15.0),)),)]
    for test in identify("closure", 0, [scripts.draft(number) for number in (0, 1, 2, 3) for _ in range(3)]):
        archive.add(handover.run(test))
    (worked,) = identify(
        "closure", 5, [scripts.draft(scripts.by_slot[Slot("handover", ("1", "00"))][0], "handover", mute)]
    )
    archive.add(handover.run(worked))
    proposals = DisturbanceWay(scripts, experience, handover.DISTURBANCES).propose(archive, 20, make_rng("again"))
    again = [each.draft.values for each in proposals if {"for_s": 15.0} in each.draft.values.values()]
    assert again
    assert all(values[RUN] == {"patience_s": float(worked.seed % 7)} for values in again)


def test_where_a_bin_is_all_that_is_open_each_test_is_aimed_at_it() -> None:
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    archive = Archive([("bin", "handover", "1", "00", "given")])
    for test in identify("closure", 0, [scripts.draft(number) for number in range(20)]):
        archive.add(handover.run(test))
    way = DisturbanceWay(scripts, Experience(scripts), handover.DISTURBANCES)
    for number in range(8):
        assert all(each.aims for each in way.propose(archive, 4, make_rng("all", number)))


def test_each_disturbance_is_soon_tried_at_the_start_of_a_run() -> None:
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    archive = Archive([("statement", "robot.py", "7")])
    way = DisturbanceWay(scripts, Experience(scripts), handover.DISTURBANCES)
    drafts = [each.draft for each in way.propose(archive, 2 * len(handover.DISTURBANCES), make_rng("starts"))]
    assert {each.lines[0] for each in drafts} >= {f"disturb {name}" for name in handover.DISTURBANCES}


def test_each_disturbance_is_soon_tried_wherever_something_else_usually_comes() -> None:
    """In scripts that have much of it: people who are given a part are one pose of four."""
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(scripts), Archive([("statement", "robot.py", "7")])
    undisturbed = [scripts.draft(numbers[0]) for numbers in scripts.by_slot.values() for _ in range(3)]
    for test in identify("closure", 0, undisturbed):
        archive.add(handover.run(test))
    proposals = DisturbanceWay(scripts, experience, handover.DISTURBANCES).propose(archive, 8, make_rng("wherever"))
    for test in identify("closure", 1, [each.draft for each in proposals]):
        archive.add(handover.run(test))
    experience.learn(archive)
    usual = {experience.usual(slot) for slot in scripts.by_slot}
    assert len(usual) == 2
    assert all(experience.tried[name, goal] for name in handover.DISTURBANCES for goal in usual)


def test_disturbances_are_tried_where_runs_came_near_to_what_is_open() -> None:
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    before, behind = ("statement", "robot.py", "7"), ("statement", "robot.py", "8")
    archive = Archive([before, behind])
    for number, test in enumerate(identify("closure", 0, [scripts.draft(number) for number in range(20)])):
        is_near = all(slot.planned[1] == "11" for slot in scripts.slots(number))
        archive.add(replace(handover.run(test), points=(before,) if is_near else ()))
    way = DisturbanceWay(scripts, Experience(scripts), handover.DISTURBANCES)
    aimed = [each.draft.lines for each in way.propose(archive, 40, make_rng("near")) if each.aims]
    assert len(aimed) > 10
    assert all("set gaze = 1" in lines and "set grip = 1" in lines for lines in aimed)


def test_a_disturbance_beside_others_was_not_tried_by_itself() -> None:
    """One of them may have hidden what it does."""
    scripts = Scripts(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(scripts), Archive([("statement", "robot.py", "7")])
    together, alone = [(Dose(1, "shake"), Dose(3, "light"))], [(Dose(1, "light"),)]
    for test in identify("closure", 0, [scripts.draft(0, "handover", each) for each in (together, alone)]):
        archive.add(handover.run(test))
    experience.learn(archive)
    assert {name for name, _ in experience.tried} == {"light"}
    assert [place for _, _, place in experience.doses] == [1]
