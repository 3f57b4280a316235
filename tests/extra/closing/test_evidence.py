"""Evidence of a closing loop: hit, impossible and open points, bounds, growth, what a further run would find."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.coverage.closure import Point
from pytest_hricdv.coverage.code_map import CodeMap, SourceFile
from pytest_hricdv.extra.closing.evidence import evidence, rule_of_three
from pytest_hricdv.extra.closing.observation import RunObservation
from pytest_hricdv.extra.closing.records import ClosingResult, ImpossiblePoint
from pytest_hricdv.extra.closing.strategy import GIVEN, Archive, ArchivedRun
from pytest_hricdv.extra.closing.targets import Surroundings
from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.monitor import NearMiss

CODE = CodeMap(
    ("lamp",),
    (
        SourceFile(
            "lamp.py",
            Path("lamp.py"),
            (1, 2, 3, 4),
            ((1, 2), (1, 3), (3, -1), (3, 4)),
            (),
            "if dark:\n    switch_on()\nif bright:\n    switch_off()\n",
        ),
    ),
    "",
)
KNOWN = Surroundings(CODE, {"light": ("place", "level")}, {"visitor": {"wish": ("curt", "dim")}})
STATEMENTS: list[Point] = [("statement", "lamp.py", str(line)) for line in (1, 2, 3, 4)]
BINS: list[Point] = [("bin", "light", place, level) for place in ("hall", "cellar") for level in ("low", "high")]


def add(
    archive: Archive, name: str, *points: Point, strategy: str = "model", targets: tuple[Point, ...] = ()
) -> ArchivedRun:
    """A run of 10 s that hits these points; its id is `NAME-1`."""
    hits = tuple(point[2:] for point in points if point[0] == "bin")
    test = AbstractTest(f"{name}-1", "closure", name, (), ("greet",), seed=1)
    observation = RunObservation(test.to_data(), tuple(sorted(points)), {"light": hits}, sim_s=10.0)
    return archive.add(observation, strategy, targets)


def shown(
    archive: Archive, *suite: ArchivedRun, impossible: tuple[ImpossiblePoint, ...] = (), without: tuple[int, ...] = ()
) -> ClosingResult:
    """The evidence of an archive."""
    return evidence(archive, suite, impossible, KNOWN, suite="closure", ended="runs", budget=99, without=without)


def test_a_hit_point_names_a_test_of_the_suite_and_the_way_that_led_there_first() -> None:
    archive = Archive(STATEMENTS[:2])
    add(archive, "early", STATEMENTS[0])
    late = add(archive, "late", *STATEMENTS[:2], strategy="disturbances")
    result = shown(archive, late)
    assert [(each.point, each.test, each.strategy, each.run) for each in result.hit] == [
        (STATEMENTS[0], "late-1", "model", 1),
        (STATEMENTS[1], "late-1", "disturbances", 2),
    ]
    assert result.open == ()


def test_the_bound_of_an_open_point_is_three_over_the_runs_that_were_aimed_at_it() -> None:
    archive = Archive(BINS[:2])
    for number in range(12):
        add(archive, f"n{number}", targets=(BINS[0],) if number % 2 else ())
    aimed, other = shown(archive).open
    assert (aimed.tries, aimed.bound) == (6, 0.5)
    assert (other.tries, other.bound) == (0, None)
    assert shown(archive).bound == 3 / 12
    assert [rule_of_three(trials) for trials in (0, 1, 3, 300)] == [None, 1.0, 1.0, 0.01]


def test_the_nearest_test_of_a_bin_differs_in_fewest_coordinates_and_is_of_the_suite_if_it_can_be() -> None:
    archive = Archive(BINS)
    add(archive, "dear", BINS[0])
    add(archive, "far", BINS[2])
    kept = add(archive, "kept", BINS[0], BINS[2])
    open_points = {each.point: each for each in shown(archive, kept).open}
    assert open_points[BINS[1]].test == "kept-1"
    assert open_points[BINS[1]].lacking == "level low instead of high"
    assert open_points[BINS[3]].lacking == "level low instead of high"
    assert open_points[BINS[1]].waiver == """cross product light: impossible={('hall', 'high'): "why"}"""


def test_a_requirement_that_nothing_triggered_says_which_conditions_were_missing_when_and_by_how_much() -> None:
    passed, condition = ("verdict", "R1", "Passed"), ("condition", "R1", "legs >= 4", "true")
    archive = Archive([passed, condition])
    misses = {"far": NearMiss(9.0, ("dark", "legs >= 4"), None), "near": NearMiss(41.2, ("legs >= 4",), 1.0)}
    for name, miss in misses.items():
        test = AbstractTest(f"{name}-1", "closure", name, (), ("greet",))
        distances = tuple((point, float(len(miss.missing))) for point in (passed, condition))
        archive.add(RunObservation(test.to_data(), distances=distances, near_misses={"R1": miss}), "model")
    checked, true = shown(archive).open
    for point in (checked, true):
        assert (point.test, point.lacking) == ("near-1", "nearest at 41.2 s: only legs >= 4 was missing, by 1")
    assert checked.waiver == "hri_allow_nc = R1: why"


def test_a_requirement_that_no_run_passed_and_a_transition_say_what_came_instead() -> None:
    targets: list[Point] = [("verdict", "R1", "Passed"), ("transition", "Ask", "Give"), ("transition", "Off", "Ask")]
    archive = Archive(targets)
    add(archive, "first", ("verdict", "R1", "Failed"), ("transition", "Ask", "Off"))
    add(archive, "second", ("verdict", "R1", "Failed"), ("transition", "Ask", "Ask"))
    assert [point.lacking for point in shown(archive).open] == [
        "no run passed it, 2 runs failed it",
        "after Ask came Ask, Off",
        "nothing came after Off",
    ]


def test_growth_counts_new_points_by_kind_and_way_without_the_time_of_given_tests() -> None:
    archive = Archive([*STATEMENTS, *BINS])
    add(archive, "given", STATEMENTS[0], strategy=GIVEN)
    add(archive, "first", STATEMENTS[0], BINS[0], BINS[1])
    add(archive, "second", STATEMENTS[0])
    add(archive, "third", STATEMENTS[1], strategy="disturbances")
    result = shown(archive)
    assert [each.run for each in result.hit] == [0, 3, 1, 1]
    assert [(each.run, each.sim_s, each.strategy, dict(each.new)) for each in result.growth] == [
        (0, 0.0, GIVEN, {"statement": 1}),
        (1, 10.0, "model", {"bin": 2}),
        (3, 30.0, "disturbances", {"statement": 1}),
    ]
    assert {strategy: (each.runs, each.sim_s, dict(each.new)) for strategy, each in result.strategies.items()} == {
        "model": (2, 20.0, {"bin": 2}),
        "disturbances": (1, 10.0, {"statement": 1}),
    }
    assert (result.runs, result.initial_runs, result.sim_s) == (3, 1, 30.0)


def test_violations_are_listed_by_kind_with_a_test_of_the_suite_and_those_that_are_not_known_first() -> None:
    known = ("known violation", "R3", "far >= 0.05", "Move", "released")
    new = ("violation", "R4", "speed < 0.25", "Reset", "")
    archive = Archive(())
    add(archive, "first", known)
    kept = add(archive, "kept", known, new, ("fault", "# s too late"))
    result = shown(archive, kept)
    assert [
        (each.requirement, each.part, each.state, each.known, each.runs, each.test) for each in result.violations
    ] == [
        ("", "# s too late", "", False, 1, "kept-1"),
        ("R4", "speed < 0.25", "Reset", False, 1, "kept-1"),
        ("R3", "far >= 0.05", "Move", True, 2, "kept-1"),
    ]
