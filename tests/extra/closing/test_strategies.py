"""The strategies together, on a handover that needs no simulation."""

from __future__ import annotations

import pytest

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.loop import Loop
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
from pytest_hricdv.extra.closing.nearest_strategy import NearestStrategy
from pytest_hricdv.extra.closing.pool import Intervention, Pool
from pytest_hricdv.extra.closing.strategy import Archive, Strategy
from pytest_hricdv.generate.abstract import disturbance_of, identify
from pytest_hricdv.generate.rng import make_rng
from tests.extra.closing import handover, large_handover


def loop(seed: int, *, disturbing: bool = True) -> Loop:
    """A loop as a session has it."""
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience = Experience(pool)
    strategies: tuple[Strategy, ...] = (ModelStrategy(pool, experience),)
    if disturbing:
        strategies = (*strategies, DisturbanceStrategy(pool, experience, handover.DISTURBANCES))
    return Loop(
        Archive(handover.WANTED), strategies, handover.runner, seed, Budget(400), fallback=FallbackStrategy(pool)
    )


@pytest.mark.parametrize("seed", range(4))
def test_all_is_closed_though_some_bins_need_two_certain_disturbances_at_once(seed: int) -> None:
    closing = loop(seed)
    assert closing.run() == "closed"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_loop_of_the_size_of_the_table_closes(seed: int) -> None:
    assert large_handover.loop(seed).run() == "closed"


def test_without_disturbances_what_only_they_lead_to_stays_open() -> None:
    closing = loop(0, disturbing=False)
    assert closing.run() in ("runs", "nothing to try")
    unreachable = {("bin", "handover", count, pose, "given") for count in "123" for pose in ("00", "01", "10")}
    assert unreachable < set(closing.archive.open)
    assert ("verdict", "R5", "Passed") not in closing.archive.open


def test_targets_are_hit_more_often_than_by_chance() -> None:
    closing = loop(1)
    closing.run()
    aimed = [entry for entry in closing.archive.entries if entry.targets]
    hits = sum(bool({*entry.targets} & {*entry.new}) for entry in aimed)
    assert hits > 0.7 * sum(bool(entry.new) for entry in closing.archive.entries)


def test_each_disturbance_is_soon_tried_under_each_nominal_outcome() -> None:
    """In tests that have much of it: people who are given a part are one pose of four."""
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    experience, archive = Experience(pool), Archive([("statement", "robot.py", "7")])
    undisturbed = [pool.draft(numbers[0]) for numbers in pool.by_interaction.values() for _ in range(3)]
    for test in identify("closure", 0, undisturbed):
        archive.add(handover.run(test))
    proposals = DisturbanceStrategy(pool, experience, handover.DISTURBANCES).propose(archive, 8, make_rng("wherever"))
    for test in identify("closure", 1, [each.draft for each in proposals]):
        archive.add(handover.run(test))
    experience.learn(archive)
    nominal = {experience.nominal(interaction) for interaction in pool.by_interaction}
    assert len(nominal) == 2
    assert all(experience.tries[name, goal] for name in handover.DISTURBANCES for goal in nominal)


def test_each_disturbance_is_tried_beside_those_of_the_nearest_test() -> None:
    """The statement before the open one is reached by a shake after the second command."""
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    target = ("branch", "robot.py", "9", "10")
    strategy, archive = NearestStrategy(pool, handover.DISTURBANCES), Archive([target])
    [shaken] = identify("closure", 0, [pool.draft(0, "handover", [(Intervention(2, "shake"),)])])
    archive.add(handover.run(shaken))
    propose(strategy, archive, 4)
    aimed = [[*map(disturbance_of, entry.test.lines)] for entry in archive.entries[1:]]
    assert all("shake" in names for names in aimed)
    assert {name for names in aimed for name in names if name} == set(handover.DISTURBANCES)
    assert len(aimed) == len(handover.DISTURBANCES)


def test_what_brought_a_run_nearer_is_repeated() -> None:
    """The requirement is checked where all three parts are given."""
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    target = ("verdict", "R5", "Passed")
    strategy, archive = NearestStrategy(pool, {}), Archive([target])
    poses = [[bin_[1] for bin_ in handover.planned(test.lines)] for test in pool.tests]
    tests = [pool.draft(poses.index([*each])) for each in (("00",), ("00", "11", "01"))]
    for test in identify("closure", 0, tests):
        archive.add(handover.run(test))
    assert target in archive.open
    propose(strategy, archive, 1)
    assert {("3", "11")} in [{*handover.planned(entry.test.lines)} for entry in archive.entries]
    assert target not in archive.open


def test_nothing_is_repeated_where_no_run_came_nearer_than_others() -> None:
    pool = Pool(handover.exploration(), handover.SPACE, {"handover": handover.planned})
    archive = Archive([("verdict", "R5", "Passed")])
    for test in identify("closure", 0, [pool.draft(0)] * 2):
        archive.add(handover.run(test))
    assert NearestStrategy(pool, {}).propose(archive, 8, make_rng("wherever")) == []


def propose(strategy: Strategy, archive: Archive, generations: int) -> None:
    """Run what a strategy proposes, alone."""
    for generation in range(generations):
        proposals = strategy.propose(archive, 8, make_rng("proposals", generation))
        drafts = [proposal.draft for proposal in proposals]
        for proposal, test in zip(proposals, identify("closure", generation, drafts), strict=True):
            archive.add(handover.run(test), proposal.strategy, proposal.targets)
