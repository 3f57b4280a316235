"""The corpus of drafts: how its elements are compared, counted and summed up."""

from __future__ import annotations

from pathlib import Path

from studies.draft_corpus import FOLDER, Element, Robot, counts, robots
from studies.draft_corpus.__main__ import Measurement, code_of, measure, totals


def element(kind: str, *names: str) -> Element:
    return Element(kind, frozenset(names))


def test_each_robot_of_this_project_has_its_code_and_seven_of_all_are_sealed() -> None:
    every = list(robots())
    assert len(every) == 16
    assert sum(robot.sealed for robot in every) == 7
    assert all(robot.repository or (FOLDER / "robots" / robot.key).is_dir() for robot in every)


def test_a_kind_of_message_may_be_a_value_that_tells_kinds_apart_but_no_state() -> None:
    truth = (element("message", "order"), element("value", "tea"), element("state", "busy"))
    robot = Robot("a", "a", ("--from", "a"), truth, (element("value", "cup"),))
    found = [element("value", "order"), element("message", "tea"), element("value", "busy"), element("value", "cup")]
    assert counts(found, robot) == (2, 3, 2, 3)


def test_a_robot_is_measured_from_its_code(tmp_path: Path) -> None:
    robot = next(robot for robot in robots() if robot.key == "tea_cart")
    code = code_of(robot, None, tmp_path)
    assert code is not None
    made = measure(robot, "code", code, say=False)
    assert made.found[1] == 10
    assert totals([made, Measurement((0, 10, 0, 0), False, True, 3.2)])[-3:] == ("0 of 1", "1 of 1", "3 s")


def test_public_code_needs_a_folder_for_its_clone(tmp_path: Path) -> None:
    robot = next(robot for robot in robots() if robot.repository)
    assert code_of(robot, None, tmp_path) is None
