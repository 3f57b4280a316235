"""The way by branching: from a decision point of an earlier run, tests that go on in other ways."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from random import Random

import pytest
from msgspec.structs import replace

from pytest_hricdv.coverage.cross_product import Bin, CrossProduct
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.branching import trees
from pytest_hricdv.extra.closing.branching_way import LEAVES, BranchingWay
from pytest_hricdv.extra.closing.decision_points import DecisionPoint
from pytest_hricdv.extra.closing.observation import Observation
from pytest_hricdv.extra.closing.way import Proposal
from pytest_hricdv.generate.abstract import AbstractTest, Draft, identify
from pytest_hricdv.generate.concrete import ConcreteTest, Concretization, concretize
from pytest_hricdv.generate.sampler import Range

TAKES = {"takes_s": Range(1.0, 3.0, "s")}
RANGES = Concretization(
    {"ask": TAKES, "wait": TAKES, "look": {}, "say": TAKES, "disturb slip": {"by_m": Range(0.0, 0.1, "m")}},
    {"outage_turn": Range(1.0, 5.0, "turn")},
)


def _planned(lines: Sequence[str]) -> list[Bin]:
    """An interaction begins with `ask`; it is slow if the person waits in it."""
    begins = [place for place, line in enumerate(lines) if line == "ask"]
    parts = [lines[begin:end] for begin, end in pairwise([*begins, len(lines)])]
    return [("slow" if "wait" in part else "quick",) for part in parts]


CROSS = {"handover": CrossProduct({"pace": ("quick", "slow"), "outcome": ("given", "kept")}, planned=_planned)}
BINS = [("bin", "handover", *each) for each in CROSS["handover"].bins()]


def archive_of(*scripts: str, wanted: Sequence[tuple[str, ...]] = BINS) -> Archive:
    """An archive of runs in which nothing was hit, and each action took a second."""
    archive = Archive(wanted)
    drafts = [Draft("toy", (), tuple(script.split(", ")), {"human": ("plan1",)}) for script in scripts]
    for test in identify("closure", 1, drafts):
        decisions = tuple(DecisionPoint(taken, float(taken)) for taken in range(len(test.lines)))
        archive.add(Observation(test.to_data(), decisions=decisions), "model")
    return archive


def add(archive: Archive, proposals: Sequence[Proposal]) -> None:
    for test, proposal in zip(identified(proposals), proposals, strict=True):
        archive.add(Observation(test.to_data()), proposal.way, proposal.targets)


def identified(proposals: Sequence[Proposal]) -> tuple[AbstractTest, ...]:
    return identify("closure", 1, [proposal.draft for proposal in proposals])


def concrete(proposals: Sequence[Proposal]) -> list[ConcreteTest]:
    return [concretize(test, RANGES) for test in identified(proposals)]


@pytest.mark.parametrize("seed", range(8))
def test_proposals_make_trees_whose_tests_begin_as_one_of_the_archive(seed: int) -> None:
    archive = archive_of("ask, look, say", "ask, wait, look, say, ask, say")
    proposals = BranchingWay(RANGES, CROSS).propose(archive, 2 * LEAVES, Random(seed))
    found = concrete(proposals)
    assert len(found) == 2 * LEAVES
    known = [concretize(entry.test, RANGES) for entry in archive.entries]
    for test, proposal in zip(found, proposals, strict=True):
        (trunk,) = [each for each in known if f"{each.id} up to command" in proposal.draft.name]
        taken = int(proposal.draft.name.split(" up to command ")[1].split(",")[0])
        assert (test.seed, test.run, test.actions[:taken]) == (trunk.seed, trunk.run, trunk.actions[:taken])
        assert test.actions not in [each.actions for each in known]
    assert len({test.id for test in found}) == len(found)
    assert len(trees(found)) <= len(known)


def test_a_disturbance_other_values_or_the_rest_of_another_test_follow() -> None:
    archive = archive_of("ask, look, say", "ask, look, wait, say")
    way = BranchingWay(RANGES, CROSS)
    drafts = [each.draft for seed in range(20) for each in way.propose(archive, LEAVES, Random(seed))]
    kinds = {draft.name.partition(", then ")[2].partition("closure-")[0] for draft in drafts}
    assert kinds == {"disturb slip", "other values", "the rest of "}
    for draft in drafts:
        assert draft.plans == ({} if "rest of" in draft.name else {"human": ("plan1",)})
        assert ("disturb slip" in draft.lines) == ("disturb slip" in draft.name)


def test_a_test_aims_at_the_open_bins_that_it_plans_from_the_decision_on() -> None:
    archive = archive_of("ask, wait, say, ask, say", wanted=[*BINS[1:], ("statement", "robot.py", "3")])
    for seed in range(8):
        for proposal in BranchingWay(RANGES, CROSS).propose(archive, LEAVES, Random(seed)):
            taken = int(proposal.draft.name.split(" up to command ")[1].split(",")[0])
            second = {BINS[1]}
            both = {*BINS[1:]}
            assert {*proposal.targets} == (second if taken > 3 else both)


def test_what_was_aimed_at_seldom_comes_first() -> None:
    quick, slow = BINS[:2], BINS[2:]

    def share(often: Sequence[tuple[str, ...]]) -> int:
        """How many of 60 tests aim at slow interactions."""
        archive = archive_of("ask, look, say", "ask, look, wait, say")
        archive.tries.update(dict.fromkeys(often, 50))
        first = [BranchingWay(RANGES, CROSS).propose(archive, 1, Random(seed))[0] for seed in range(60)]
        return sum({*slow} <= {*proposal.targets} for proposal in first)

    assert share(often=quick) > share(often=slow)


def test_runs_that_came_near_to_an_open_point_are_gone_back_to_and_exchange_their_rests() -> None:
    point = ("verdict", "R5", "Passed")
    archive = archive_of(*["ask, look, say"] * 20, wanted=[point, *BINS])
    source = archive.entries[0].observation
    drafts = [Draft("near", (), ("ask", "look", "say")) for _ in range(10)]
    for number, test in enumerate(identify("closure", 2, drafts)):
        archive.add(replace(source, test=test.to_data(), distances=((point, float(number)),)), "model")
    near = [entry.test.id for entry in archive.entries[20:]]
    names = [
        proposal.draft.name
        for seed in range(60)
        for proposal in BranchingWay(RANGES, CROSS).propose(archive, 1, Random(seed))
        if proposal.targets == (point,)
    ]
    assert 20 < len(names) < 40
    assert {name.partition(" up to")[0] for name in names} <= {*near[:8]}
    rests = {name.partition("the rest of ")[2] for name in names if "the rest" in name}
    assert rests == {*near[:2]}, "of the fifth that came nearest"


def test_proposals_depend_on_the_archive_and_the_random_stream_alone() -> None:
    archive = archive_of("ask, look, say", "ask, wait, look, say")
    used = BranchingWay(RANGES, CROSS)
    used.propose(archive, 6, Random(1))
    assert used.propose(archive, 6, Random(2)) == BranchingWay(RANGES, CROSS).propose(archive, 6, Random(2))
    add(archive, used.propose(archive, 6, Random(3)))
    assert used.propose(archive, 6, Random(4)) == BranchingWay(RANGES, CROSS).propose(archive, 6, Random(4))


def test_what_was_run_or_is_proposed_already_is_not_proposed_again() -> None:
    archive = archive_of("look, look, look", "look")
    way = BranchingWay(Concretization({"look": {}, "disturb slip": {}}), {})
    proposed: list[tuple[str, ...]] = []
    for seed in range(20):
        found = way.propose(archive, LEAVES, Random(seed))
        proposed += [each.draft.lines for each in found]
        add(archive, found)
    assert len({*proposed}) == len(proposed) > 1
    assert ("look", "look", "look") not in proposed


@pytest.mark.parametrize(
    ("ranges", "cross"), [(Concretization({"look": {}}), {}), (Concretization({"look": {}}), CROSS)]
)
def test_where_there_is_nothing_to_change_nothing_is_proposed(
    ranges: Concretization, cross: dict[str, CrossProduct]
) -> None:
    assert BranchingWay(ranges, cross).propose(archive_of("look, look"), 4, Random(1)) == []
    assert BranchingWay(ranges, cross).propose(Archive(BINS), 4, Random(1)) == []
