"""The suite of a loop: tests of people who decided during the run are in it only if they do the same again."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

from pytest_hricdv.extra.closing.loop import OnlineTests
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.strategy import Archive, ArchivedRun
from pytest_hricdv.extra.closing.suite import repeatable_suite, smallest_suite
from pytest_hricdv.generate.abstract import AbstractDraft, AbstractTest, identify

POINTS = [("bin", "pose", each) for each in "abcd"]
Runs = Callable[[Sequence[AbstractTest], OnlineTests], Iterator[tuple[int, RunObservation]]]


def archive_of(*runs: tuple[str, str, float]) -> Archive:
    """Runs, each with its strategy, the letters of the points that it hits, and its duration (s)."""
    archive = Archive(POINTS)
    tests = identify("closure", 1, [AbstractDraft(hits, (), ("look",)) for _, hits, _ in runs])
    for test, (strategy, hits, sim_s) in zip(tests, runs, strict=True):
        points = tuple(("bin", "pose", each) for each in hits)
        archive.add(RunObservation(test.to_data(), points, sim_s=sim_s, record_sha256=f"of {test.id}"), strategy)
    return archive


def rerun(asked: list[str], *different: str) -> Runs:
    """Runs tests again; those that aim at one of these points do something else than before."""

    def run(tests: Sequence[AbstractTest], online: OnlineTests) -> Iterator[tuple[int, RunObservation]]:
        asked.extend(test.target for test in tests)
        for number, test in reversed([*enumerate(tests)]):
            record = "another" if test.target in different else f"of {test.id}"
            yield number, RunObservation(test.to_data(), record_sha256=record)

    return run


def targets(entries: Sequence[ArchivedRun]) -> set[str]:
    return {entry.test.target for entry in entries}


def test_tests_that_do_the_same_again_stay() -> None:
    archive, asked = archive_of(("model", "ab", 10.0), ("online", "cd", 10.0), ("online", "c", 10.0)), list[str]()
    suite, left_out = repeatable_suite(archive, ("online",), rerun(asked))
    assert (suite, left_out) == (smallest_suite(archive), ())
    assert asked == ["cd"], "only what is in the suite, and was decided during its run"


def test_of_one_that_does_not_others_take_the_place_and_are_run_again_too() -> None:
    archive = archive_of(("online", "abcd", 5.0), ("model", "ab", 10.0), ("online", "c", 10.0), ("model", "c", 20.0))
    asked: list[str] = []
    suite, left_out = repeatable_suite(archive, ("online",), rerun(asked, "abcd", "c"))
    assert asked == ["abcd", "c"]
    assert (targets(left_out), len(left_out)) == ({"abcd", "c"}, 2)
    assert [entry.strategy for entry in suite] == ["model", "model"]


def test_points_that_only_such_a_test_hits_are_lost() -> None:
    archive = archive_of(("online", "abcd", 5.0), ("model", "a", 10.0))
    suite, left_out = repeatable_suite(archive, ("online",), rerun([], "abcd"))
    assert (targets(suite), targets(left_out)) == ({"a"}, {"abcd"})
