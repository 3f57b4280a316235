"""The way of the person who lives in the run: what its runs told of their choices weighs in those of the next ones."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from random import Random

import pytest

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.extra.closing.archive import Archive
from pytest_hricdv.extra.closing.observation import Observation
from pytest_hricdv.extra.closing.online_strategy import COMMANDS, LIKELIEST, SURPRISES, TARGETS, OnlineStrategy
from pytest_hricdv.extra.closing.strategy import Proposal
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.online.chooser import ANY_INTERACTION, DISTURBANCE, GOAL, NONE, Choice
from tests.online import toy

OPEN: Point = ("bin", "cup", "hot", "nod")
OTHERS: tuple[Point, ...] = (("bin", "cup", "hot", "shout"), ("bin", "cup", "cold", "shout"))

TASTES = (NONE, "likes_hot", "likes_cold")


@pytest.fixture
def way(tmp_path: Path) -> OnlineStrategy:
    role = toy.role(tmp_path, disturbances=("disturb wind", "disturb rain"))
    return OnlineStrategy([role], {"cup": toy.planned})


def archive_of(*wanted: Point) -> Archive:
    return Archive(wanted or (OPEN, *OTHERS))


def add(archive: Archive, lines: Sequence[str], choices: Sequence[Choice], *hits: Bin, **more: object) -> None:
    """A run of these commands, with these choices; each interaction hits a bin."""
    test = AbstractTest(f"online-{len(archive.entries)}", "closure", "online", (), tuple(lines))
    points = tuple(("bin", "cup", *hit) for hit in hits)
    archive.add(Observation(test.to_data(), points, {"cup": hits}, choices=tuple(choices), **more), "online")  # type: ignore[arg-type]


def weights(proposal: Proposal) -> dict[tuple[str, int, str, str], float]:
    assert proposal.weights is not None
    return {(state, turn, about, option): weight for state, turn, about, option, weight in proposal.weights}


def test_a_proposal_has_no_commands_and_weights_for_all_that_can_be_chosen(way: OnlineStrategy) -> None:
    [proposal] = way.propose(archive_of(), 1, Random(1))
    assert (proposal.draft.lines, proposal.way) == ((), "online")
    known = weights(proposal)
    assert [key[-1] for key in known if key[:3] == ("", ANY_INTERACTION, "taste")] == [*TASTES]
    assert {key[-1] for key in known if key[2] == GOAL} == {NONE, "fetch", "thank"}
    assert {key[1] for key in known} == {ANY_INTERACTION, 0, 1, 2, 3}, (
        "one for each aim, and what comes before the first"
    )


@pytest.mark.parametrize("commands", [0, 1, 10])
def test_ideas_of_their_own_and_disturbances_are_as_rare_in_long_runs_as_in_short_ones(
    way: OnlineStrategy, commands: int
) -> None:
    archive = archive_of()
    if commands:
        add(archive, ["press"] * commands, ())
    expected = {min(surprise / (commands or COMMANDS), LIKELIEST) for surprise in SURPRISES}
    found = set()
    for proposal in way.propose(archive, 20, Random(1)):
        known = weights(proposal)
        for about in (GOAL, DISTURBANCE):
            rare = sum(weight for key, weight in known.items() if key[:3] == ("", 1, about) and key[3] != NONE)
            assert rare + known["", 1, about, NONE] == pytest.approx(1.0)
            found.add(round(rare, 9))
    assert found == {round(each, 9) for each in expected}


def test_what_nothing_is_known_about_is_equally_likely(way: OnlineStrategy) -> None:
    known = weights(way.propose(archive_of(), 1, Random(1))[0])
    assert len({weight for key, weight in known.items() if key[2] == "taste"}) == 1


def test_what_makes_an_open_point_likelier_is_likelier(way: OnlineStrategy) -> None:
    archive = archive_of()
    for taste, level in (("likes_hot", "hot"), ("likes_cold", "cold")):
        choices = [Choice(0, "", 0, "start", "thirsty"), Choice(1, "Pouring", 1, "taste", taste)]
        add(archive, ["press", "drink hot", "shout"], choices, (level, "shout"))
    [proposal] = way.propose(archive, 1, Random(1))
    assert proposal.targets == (OPEN,)
    known = weights(proposal)
    for place in (("Pouring", 1), ("", 1), ("", ANY_INTERACTION)):
        assert known[(*place, "taste", "likes_hot")] > known[(*place, "taste", "likes_cold")]


def test_each_turn_has_an_aim_of_its_own(way: OnlineStrategy) -> None:
    aims: tuple[Point, ...] = (OPEN, ("bin", "cup", "cold", "nod"))
    archive = archive_of(*aims)
    for taste, level in (("likes_hot", "hot"), ("likes_cold", "cold")):
        add(archive, ["press", "shout"], [Choice(1, "A", 1, "taste", taste)], (level, "shout"))
    known = weights(way.propose(archive, 1, Random(1))[0])
    liked = [max(TASTES[1:], key=lambda taste: known["A", turn, "taste", taste]) for turn in (1, 2)]
    assert sorted(liked) == ["likes_cold", "likes_hot"]


def test_a_choice_counts_for_its_own_interaction_only(way: OnlineStrategy) -> None:
    archive = archive_of()
    choices = [Choice(1, "A", 1, "taste", "likes_hot"), Choice(4, "B", 2, "taste", "likes_cold")]
    lines = ["press", "disturb wind", "nod", "press", "nod"]
    add(archive, lines, choices, ("hot", "shout"), ("cold", "shout"))
    known = weights(way.propose(archive, 1, Random(1))[0])
    assert known["A", 1, "taste", "likes_hot"] > known["B", 1, "taste", "likes_cold"]


def test_what_was_tried_often_gives_way_to_what_was_not(way: OnlineStrategy) -> None:
    archive = archive_of()
    for _ in range(12):
        add(archive, ["press"], [Choice(1, "A", 1, "taste", "likes_hot")], ("hot", "shout"))
    known = weights(way.propose(archive, 1, Random(1))[0])
    assert known["", 1, "taste", "likes_cold"] > known["", 1, "taste", "likes_hot"]


def test_the_choices_of_the_run_that_came_nearest_to_an_open_point_are_likelier(way: OnlineStrategy) -> None:
    checked: Point = ("verdict", "R5", "Passed")
    archive = archive_of(checked)
    for distance, taste, level in ((1.0, "likes_hot", "hot"), (3.0, "likes_cold", "cold")):
        add(archive, ["press"], [Choice(1, "A", 1, "taste", taste)], (level, "nod"), distances=((checked, distance),))
    [proposal] = way.propose(archive, 1, Random(1))
    known = weights(proposal)
    assert proposal.targets == (checked,)
    assert known["", 1, "taste", "likes_hot"] > known["", 1, "taste", "likes_cold"]


def test_proposals_depend_on_archive_and_random_stream_only(way: OnlineStrategy, tmp_path: Path) -> None:
    archive = archive_of()
    add(archive, ["press"], [Choice(1, "A", 1, "taste", "likes_hot")], ("hot", "shout"))
    way.propose(archive, 3, Random(7))
    another = OnlineStrategy([toy.role(tmp_path, disturbances=("disturb wind", "disturb rain"))], {"cup": toy.planned})
    assert way.propose(archive, 5, Random(2)) == another.propose(archive, 5, Random(2))
    assert way.propose(archive, 5, Random(2)) != way.propose(archive, 5, Random(3))


def test_runs_are_aimed_at_what_was_seldom_aimed_at_and_at_nothing_where_nothing_is_open(way: OnlineStrategy) -> None:
    bins: tuple[Point, ...] = tuple(("bin", "cup", "hot", str(number)) for number in range(3 * TARGETS))
    archive = archive_of(*bins)
    archive.tries.update(dict.fromkeys(bins[TARGETS:], 100))
    aims = [aim for proposal in way.propose(archive, 20, Random(1)) for aim in proposal.targets]
    assert len(aims) == 20 * TARGETS
    assert sum(aim in bins[:TARGETS] for aim in aims) > 60
    add(archive, ["press"], (), *(point[2:] for point in bins))
    assert way.propose(archive, 5, Random(1)) == []
