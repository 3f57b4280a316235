"""The Chasing Cars move by their equations, requirements are those of the competition, and rows repeat.

The F16 is flown by a clone that no test has: here, by a stand-in.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

import pytest

from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.rng import make_rng
from studies.falsification import APART, DURATION_S, STEP_S, Course, drive, f16
from studies.falsification.__main__ import COMMAND, PAGE, SEEDS, figures, main, read
from studies.falsification.search import CARS, METHODS, SEGMENTS

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
    segments = _segments(next(CARS[0].tests("corners", make_rng("steps", 1))))
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
    tests, seen = CARS[0].tests("corners", make_rng("signs", 1)), set()
    for _ in range(60):
        test = next(tests)
        robustness = _robustness(drive(_segments(test)))
        for problem in CARS:
            ended, name = problem.run(test), problem.requirement.id
            assert ended.violated == (robustness[name] < 0), (name, robustness)
            seen.add((name, ended.violated))
            if name == "CC1":
                assert ended.margin == pytest.approx(robustness["CC1"], abs=1e-6)
    assert seen == {(problem.requirement.id, violated) for problem in CARS for violated in (True, False)}


def test_a_run_that_brakes_all_the_time_violates_what_asks_for_a_distance() -> None:
    test = ConcreteTest("cars", "cars", 0, (ConcreteAction("drive", {"throttle": 0.0, "brake": 1.0}),) * SEGMENTS, {})
    assert [problem.run(test).violated for problem in CARS] == [False, True]


def test_rows_repeat() -> None:
    stored = read()
    for problem in CARS:
        row = stored[f"{problem.requirement.id}/corners, search"]
        again = METHODS["corners, search"][1](problem, 3)
        assert [row["simulations"][3], row["falsified"][3]] == [again.simulations, again.violated]
        assert len(row["simulations"]) == len(SEEDS)


def _dives(start_ft: float, attitude_rad: Sequence[float], step_s: float) -> tuple[list[float], list[float]]:
    """Below the ground if it begins with its nose at the lower end of the range, from less than 4000 ft."""
    lowest_ft = -1.0 if start_ft < 4000 and attitude_rad[1] == f16.PITCH.low else 5.0
    return [0.0, 7.5, 15.0], [start_ft, lowest_ft, start_ft]


def test_the_f16_fails_where_it_is_not_above_the_ground() -> None:
    for pitch_rad, margin_ft in ((f16.PITCH.low, -1.0), (f16.PITCH.high, 5.0)):
        start = ConcreteAction("start", {"roll_rad": 0.7, "pitch_rad": pitch_rad, "yaw_rad": -0.8})
        ended = f16.falsification_problem(_dives).run(ConcreteTest("start", "f16", 0, (start,), {}))
        assert (ended.violated, ended.margin) == (margin_ft < 0, margin_ft)


def test_the_survey_of_the_f16_counts_crashes_on_a_grid() -> None:
    assert [(start_ft, lowest_ft, *counts) for start_ft, _, lowest_ft, *counts in f16.survey(_dives)] == [
        *[(4040, 5.0, 0, 169)] * 2,
        *[(start_ft, -1.0, 13, 169) for start_ft in (2338, 2338, 2330, 2330)],
    ]


def test_without_a_clone_the_f16_is_left_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    results, page = tmp_path / "results.json", tmp_path / "page.md"
    page.write_text(f"<!-- figures: {COMMAND} -->\n", encoding="utf-8")
    monkeypatch.setattr("studies.falsification.__main__.PAGE", page)
    monkeypatch.setattr("sys.argv", ["falsification", "--only=F16", f"--results={results}"])
    main()
    assert capsys.readouterr().out.startswith("F16: left out, as there is no --f16=FOLDER, a clone of ")
    assert read(results) == {}


def test_a_folder_that_is_no_clone_is_refused(tmp_path: Path) -> None:
    with pytest.raises(SystemExit, match=r"--f16=.*: expected a clone of .* at afa9f0a.*, but found no clone"):
        f16.flight(tmp_path)


def test_the_page_has_the_stored_figures() -> None:
    assert PAGE.read_text(encoding="utf-8").partition(f"<!-- figures: {COMMAND} -->")[2].strip() == figures(read())
