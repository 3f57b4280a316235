"""The strategies together, on a handover that needs no simulation."""

from __future__ import annotations

import pytest

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.disturbance_strategy import DisturbanceStrategy
from pytest_hricdv.extra.closing.experience import Experience
from pytest_hricdv.extra.closing.loop import Loop
from pytest_hricdv.extra.closing.model_strategy import FallbackStrategy, ModelStrategy
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
    strategy, archive = DisturbanceStrategy(pool, Experience(pool), handover.DISTURBANCES), Archive([target])
    [shaken] = identify("closure", 0, [pool.draft(0, "handover", [(Intervention(2, "shake"),)])])
    archive.add(handover.run(shaken))
    for generation in range(4):
        proposals = strategy.propose(archive, 8, make_rng("beside", generation))
        for proposal, test in zip(
            proposals, identify("closure", generation, [p.draft for p in proposals]), strict=True
        ):
            archive.add(handover.run(test), proposal.strategy, proposal.targets)
    aimed = [[*map(disturbance_of, entry.test.lines)] for entry in archive.entries if entry.targets == (target,)]
    assert all("shake" in names for names in aimed)
    assert {name for names in aimed for name in names if name} == set(handover.DISTURBANCES)
    assert len(aimed) <= len(handover.DISTURBANCES)
