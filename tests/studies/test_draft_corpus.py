"""The corpus of drafts: how its elements are compared, counted and summed up."""

from __future__ import annotations

from pathlib import Path

from studies.draft_corpus import FOLDER, robots
from studies.draft_corpus.__main__ import Measurement, code_of, measure, totals


def test_each_robot_of_this_project_has_its_code_and_seven_of_all_are_sealed() -> None:
    every = list(robots())
    assert len(every) == 25
    assert sum(robot.sealed for robot in every) == 7
    assert all(robot.repository or (FOLDER / "robots" / robot.key).is_dir() for robot in every)


def test_a_robot_is_measured_from_its_code(tmp_path: Path) -> None:
    robot = next(robot for robot in robots() if robot.key == "tea_cart")
    code = code_of(robot, None, tmp_path)
    assert code is not None
    made = measure(robot, "code", code, say=False)
    assert made.found[1] == 10
    assert totals([made, Measurement((0, 10, 0, 0), False, True, 3.2)])[-3:] == ("0 of 1", "1 of 1", "3 s")
