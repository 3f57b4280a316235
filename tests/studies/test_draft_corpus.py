"""The corpus of drafts: how its elements are compared, counted and summed up."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.draft_corpus import FOLDER, robots
from studies.draft_corpus.__main__ import Measurement, code_of, measure, totals


def test_each_robot_of_this_project_has_its_code_and_fourteen_of_all_are_sealed() -> None:
    every = list(robots())
    assert len(every) == 39
    assert sum(robot.sealed for robot in every) == 14
    assert all(robot.repository or (FOLDER / "robots" / robot.key).is_dir() for robot in every)


FOUND = {
    "courier": (16, 0),  # threads, a queue of dicts
    "kiosk": (12, 0),  # streams of asyncio, JSON, an enumeration
    "lamp": (13, 0),  # callbacks of an MQTT client, JSON
    "tea_cart": (10, 0),  # dataclasses on a bus, `python-statemachine`
    "hostess": (10, 0),  # a tree of `py_trees`, polled devices
    "shelf": (4, 0),  # a control loop, messages in a list
    "sorter": (21, 0),  # a dispatcher, handlers by name
    "rover": (16, 0),  # a handler of websockets
    "patrol": (11, 0),  # callbacks of a blackboard
    "walker": (13, 0),  # `match` on enumerations and models
    "usher": (12, 0),  # a hierarchy of devices, callbacks in dicts
}
"""Elements that the code of each of these robots says, and wrong ones."""


@pytest.mark.parametrize("key", FOUND)
def test_the_code_of_a_robot_says_what_it_receives(key: str, tmp_path: Path) -> None:
    robot = next(robot for robot in robots() if robot.key == key)
    code = code_of(robot, None, tmp_path)
    assert code is not None
    found, _, right, judged = measure(robot, "code", code, say=False).found
    assert (found, judged - right) == FOUND[key]


def test_totals_are_those_of_all_robots() -> None:
    rows = [Measurement((10, 10, 9, 10)), Measurement((0, 10, 0, 0), False, True, 3.2)]
    assert totals(rows) == ("2", "50 % of 20", "90 % of 10", "0 of 1", "1 of 1", "3 s")
