"""The Chasing Cars move by their equations, their requirements are those of the competition, and rows repeat."""

from __future__ import annotations

import math

import pytest

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.rng import make_rng
from studies.falsification import APART, DURATION_S, STEP_S, Course, drive
from studies.falsification.__main__ import COMMAND, PAGE, SEEDS, figures, read
from studies.falsification.search import METHODS, REQUIREMENTS, SEGMENTS, run, sampled

STEPS = round(DURATION_S / STEP_S)


def test_nobody_moves_before_the_first_car_does() -> None:
    course = drive([(0.0, 1.0)])
    assert [set(places) for places in course.places] == [{APART * number} for number in range(5)]


def test_the_first_car_has_the_closed_form_of_its_equation() -> None:
    course = drive([(1.0, 0.0), (0.5, 0.25)])
    middle = STEPS // 2
    assert course.places[0][middle] == pytest.approx(-(50.0**2) / 2)
    final, decay = -2.0, math.exp(-0.25 * 50)
    after = -1250.0 + final * 50 + (-50.0 - final) * (1 - decay) / 0.25
    assert course.places[0][-1] == pytest.approx(after)


def test_the_second_car_chases_from_15_m_on() -> None:
    course = drive([(1.0, 0.0)])
    began_s = math.sqrt(10.0)  # when the first car is 5 m ahead
    after = next(number for number, time_s in enumerate(course.times_s) if time_s > began_s)
    assert course.places[1][after - 1] == APART
    assert course.places[1][after] == pytest.approx(APART - (course.times_s[after] - began_s) ** 2 / 2, abs=1e-3)


def _by_small_steps(throttle: float, brake: float, duration_s: float) -> list[float]:
    """Where the cars are, by the equations in steps of 0.1 ms."""
    places, speeds, modes, step_s = [APART * number for number in range(5)], [0.0] * 5, ["keeping"] * 5, 1e-4
    for _ in range(round(duration_s / step_s)):
        before = list(places)
        places[0], speeds[0] = places[0] + speeds[0] * step_s, speeds[0] - (throttle + brake * speeds[0]) * step_s
        for car in range(1, 5):
            distance, speed = before[car] - before[car - 1], speeds[car]
            following = {
                "keeping": "chasing" if distance >= 15 else "braking" if distance <= 5 else "keeping",
                "chasing": "keeping" if distance <= 10 else "chasing",
                "braking": "chasing" if distance >= 20 else "braking",
            }
            modes[car] = following[modes[car]]
            places[car] += (speed if modes[car] == "keeping" else -speed) * step_s
            speeds[car] += {"keeping": 0.0, "chasing": 1.0, "braking": -speed}[modes[car]] * step_s
    return places


@pytest.mark.parametrize(("throttle", "brake"), [(1.0, 1.0), (0.4, 0.5), (0.9, 0.2)])
def test_all_cars_go_where_small_steps_lead(throttle: float, brake: float) -> None:
    # Errors grow with each of the two thousand transitions of a run: only its first part can be compared.
    course = drive([(throttle, brake)])
    there = [places[round(20.0 / STEP_S)] for places in course.places]
    assert there == pytest.approx(_by_small_steps(throttle, brake, 20.0), abs=0.1)
    assert len({round(place - APART * number, 1) for number, place in enumerate(there)}) == 5


def test_the_step_does_not_decide_where_the_cars_go() -> None:
    segments = _segments(next(sampled("corners", make_rng("steps", 1))))
    coarse, fine = (drive(segments, step_s) for step_s in (0.25, 0.05))
    assert [places[-1] for places in coarse.places] == pytest.approx([places[-1] for places in fine.places], abs=1e-3)


def _segments(test: ConcreteTest) -> list[tuple[float, float]]:
    return [(action.parameters["throttle"], action.parameters["brake"]) for action in test.actions]


def _robustness(course: Course) -> dict[str, float]:
    """Of STL, sample by sample: negative if violated."""
    last = [fifth - fourth for fourth, fifth in zip(*course.places[3:], strict=True)]
    window = round(30 / STEP_S)
    starts = range(round(70 / STEP_S) + 1)
    return {
        "CC1": 40.0 - max(last),
        "CC2": min(max(last[start : start + window + 1]) for start in starts) - 15.0,
    }


def test_verdicts_have_the_sign_of_the_robustness_of_stl() -> None:
    tests, seen = sampled("corners", make_rng("signs", 1)), set()
    for _ in range(60):
        test = next(tests)
        robustness = _robustness(drive(_segments(test)))
        for requirement in REQUIREMENTS:
            ended = run(requirement, test)
            assert ended.violated == (robustness[requirement.id] < 0), (requirement.id, robustness)
            seen.add((requirement.id, ended.violated))
            if requirement.id == "CC1":
                assert ended.margin == pytest.approx(robustness["CC1"], abs=1e-6)
    assert seen == {(requirement.id, violated) for requirement in REQUIREMENTS for violated in (True, False)}


def test_a_run_that_brakes_all_the_time_violates_what_asks_for_a_distance() -> None:
    test = ConcreteTest("cars", "cars", 0, (ConcreteAction("drive", {"throttle": 0.0, "brake": 1.0}),) * SEGMENTS, {})
    assert [run(requirement, test).violated for requirement in REQUIREMENTS] == [False, True]


def test_rows_repeat() -> None:
    stored = read()
    for requirement in REQUIREMENTS:
        row = stored[f"{requirement.id}/corners, search"]
        again = METHODS["corners, search"][1](requirement, 3)
        assert [row["simulations"][3], row["falsified"][3]] == [again.simulations, again.violated]
        assert len(row["simulations"]) == len(SEEDS)


def test_the_page_has_the_stored_figures() -> None:
    assert PAGE.read_text(encoding="utf-8").partition(f"<!-- figures: {COMMAND} -->")[2].strip() == figures(read())
