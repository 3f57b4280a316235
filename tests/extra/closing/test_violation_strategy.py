"""The search for violations after a loop: what it aims at, how many runs it has, and what is said of further ones."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from random import Random

import pytest

from pytest_hricdv.experiments.budget import Budget
from pytest_hricdv.extra.closing.evidence import violation_estimate
from pytest_hricdv.extra.closing.loop import GENERATION, Loop, OnlineTests, search_violations
from pytest_hricdv.extra.closing.observation import NEW, RunObservation
from pytest_hricdv.extra.closing.records import ViolationEstimate
from pytest_hricdv.extra.closing.strategy import Archive, Proposal
from pytest_hricdv.extra.closing.violation_strategy import NAME, ViolationStrategy, vacuous_alternatives
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest
from pytest_hricdv.generate.concrete import Concretization, concretize
from pytest_hricdv.generate.sampler import Uniform

SPACE = Concretization(commands={"enter": {"at_s": Uniform(0.0, 60.0, "s")}, "wait": {}}, run={})
LEAVES_S, DOOR_S = 41.0, 0.5
"""The lift leaves then, and a robot is in its door for so long before and after it has entered."""


def at_s(test: AbstractTest) -> float:
    return concretize(test, SPACE).actions[0].parameters["at_s"]


def entering(test: AbstractTest) -> RunObservation:
    """R1: the lift does not leave while the robot is in its door. R2 is near to nothing, R3 compares nothing."""
    margin = abs(at_s(test) - LEAVES_S) - DOOR_S
    violated = [(NEW, "R1", "in the door", "", "")] if margin < 0.0 else []
    return RunObservation(
        test.to_data(),
        points=(("entered",), *violated),
        margins={"R1": margin, "R2": 100.0 + at_s(test)},
        unused={"R1": (), "R2": (), "R3": ("early", "late") if at_s(test) < 55.0 else ("early",)},
        sim_s=1.0,
    )


@dataclass
class Enters:
    """A strategy that proposes the same draft as often as it is asked to."""

    lines: tuple[str, ...] = ("enter",)
    name: str = "enters"

    def propose(self, archive: Archive, count: int, rng: Random) -> list[Proposal]:
        """See `Strategy`."""
        return [Proposal(AbstractDraft("one", (), self.lines), self.name) for _ in range(count)]


@dataclass
class Runs:
    """Runs tests, forwards or backwards, and keeps how many at a time."""

    yields: Callable[[AbstractTest], RunObservation] = entering
    backwards: bool = False
    sizes: list[int] = field(default_factory=list)

    def __call__(self, tests: Sequence[AbstractTest], online: OnlineTests) -> Iterable[tuple[int, RunObservation]]:
        """See `BatchRunner`."""
        self.sizes.append(len(tests))
        observed = [(number, self.yields(test)) for number, test in enumerate(tests)]
        return reversed(observed) if self.backwards else observed


def closed(runs: int, search: int | None, runner: Runs | None = None, seed: int = 0) -> Archive:
    """The archive of a loop that is closed by its first generation, and of the search after it."""
    archive = Archive([("entered",)])
    strategy = ViolationStrategy(("R1", "R2", "R3"), SPACE)
    whole = Loop(archive, [Enters()], runner or Runs(), seed, Budget(runs), searcher=strategy)
    assert search_violations(whole, whole.run(), search) == "closed"
    return archive


def of(archive: Archive, requirement: str) -> int:
    """How many runs searched for a violation of it."""
    return sum((NEW, requirement) in entry.targets for entry in archive.entries if entry.strategy == NAME)


def is_violated(archive: Archive) -> bool:
    return any(point[0] == NEW for point in archive.best)


@pytest.mark.parametrize("seed", range(5))
def test_what_closing_has_not_shown_a_search_after_it_shows(seed: int) -> None:
    found = closed(400, 150, seed=seed)
    assert is_violated(found)
    assert of(found, "R1") < 60
    without = closed(400, 0, seed=seed)
    assert [entry.strategy for entry in without.entries] == ["enters"] * GENERATION


@pytest.mark.parametrize(
    ("runs", "search", "made"),
    [(400, None, GENERATION), (400, 30, 30), (12, None, 4), (12, 30, 4), (8, None, 0), (400, 0, 0)],
)
def test_a_search_has_a_tenth_of_the_runs_made_and_none_but_those_left(
    runs: int, search: int | None, made: int
) -> None:
    assert len(closed(runs, search).entries) == GENERATION + made


def test_what_was_never_decisive_is_aimed_at_until_it_is() -> None:
    archive = closed(400, 150)
    aimed = [entry.targets[0][2] for entry in archive.entries if entry.targets and entry.targets[0][0] == "part"]
    assert set(aimed) == {"early", "late"}
    assert vacuous_alternatives(archive, "R3") == ("early",)
    last = max(entry.number for entry in archive.entries if ("part", "R3", "late") in entry.targets)
    assert "early" in {entry.targets[0][-1] for entry in archive.entries[last:]}


@pytest.mark.parametrize(
    ("kinds", "expected"),
    [
        ([], None),
        ([(), ()], ViolationEstimate(kinds=0, once=0, runs=2, new=0.0)),
        ([("a",), ("a", "b"), ("c",), ()], ViolationEstimate(kinds=3, once=2, runs=4, new=0.5)),
    ],
)
def test_kinds_that_came_once_say_how_many_are_left(
    kinds: Sequence[Sequence[str]], expected: ViolationEstimate | None
) -> None:
    archive = Archive([])
    for number, names in enumerate(kinds):
        test = AbstractTest(f"t{number}", "s", "t", (), ("enter",))
        points = [(NEW, name, "", "", "") for name in names]
        archive.add(RunObservation(test.to_data(), points=(("known violation", "R9", "", "", ""), *points)))
    archive.add(RunObservation(AbstractTest("e", "s", "t", (), ("enter",)).to_data(), error="it broke"))
    assert violation_estimate(archive, ()) == expected
