"""What the person does to each robot, what is required of it, and its project on disk."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from pathlib import Path

_HERE = Path(__file__).parent

_AT_REST = "always(on(stop) -> always[0.3:0.8](not moving))"
_SOON_AT_REST = "always(on(stop) -> always[0.6:0.95](not moving))"
_EACH_SERVED = "always(on(go) -> eventually[0:0.95](count(on(done)) == {}count(on(go))))"
_GO_STOP = ("go", "stop")
_ALL_SERVED = "always(on(go) -> eventually[0:0.8](count(on(done)) == 2 * count(on(go))))"


@dataclass(frozen=True)
class Race:
    """A robot with a planted race.

    Args:
        name: of its module in `robots`.
        title: what is required.
        formula: the requirement that the race violates.
        pause_s: shortest and longest pause of the person before each action.
        commands: what the person can do.
        is_held_out: whether nothing may be tuned on it.
        ros2: whether it is a node of ROS 2.
        code: packages whose statements may be held up, besides its own.
    """

    name: str
    title: str
    formula: str
    pause_s: tuple[float, float]
    commands: tuple[str, ...] = ("go",)
    is_held_out: bool = False
    ros2: bool = False
    code: tuple[str, ...] = ()

    def write(self, folder: Path, *, repaired: bool) -> None:
        """Write its project to a folder, which is emptied."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(_HERE / "bench", folder, ignore=shutil.ignore_patterns("__pycache__"))
        shutil.copyfile(_HERE / "robots" / f"{self.name}.py", folder / "robot.py")
        person = folder / "person.asl"
        person.write_text(person.read_text(encoding="utf-8").replace("{command}", self.commands[-1]), encoding="utf-8")
        requirement = f'[R1]\ntitle = "{self.title}"\nformula = "{self.formula}"\n'
        (folder / "requirements.toml").write_text(requirement, encoding="utf-8")
        race = {
            "class": "Repaired" if repaired else "Robot",
            "pause_s": self.pause_s,
            "commands": self.commands,
            "ros2": self.ros2,
            "code": ("robot", *self.code),
        }
        (folder / "race.json").write_text(json.dumps(race), encoding="utf-8")


RACES = (
    Race(
        "check_then_act",
        "It gives no cup that it does not have",
        "always(on(go) -> always[0:0.8](given <= 1))",
        (0.5, 1.5),
    ),
    Race("late_cancel", "It rests after a stop", _AT_REST, (0.9, 1.1), ("go", "stop")),
    Race("await_between", "It rests after a stop", _AT_REST, (0.9, 2.0), ("stop",)),
    Race("queue_and_event", "Each order is served", _ALL_SERVED, (1.0, 1.5)),
    Race("reentrant_group", "It rests after a stop", _AT_REST, (0.9, 2.0), ("stop",), ros2=True),
    Race("two_locks", "It does what it is told", "always(on(go) -> eventually[0:0.8](on(done)))", (1.0, 1.5)),
    Race("emergency_stop", "It rests after a stop", _AT_REST, (0.9, 2.0), ("stop",)),
    Race(
        "watchdog_reset",
        "It moves on a beat",
        "always(on(go) -> always[0.2:0.8](moving))",
        (0.9, 1.2),
    ),
    Race("lost_wake_up", "Each order is served", _ALL_SERVED, (1.0, 1.5)),
    Race("double_start", "It runs one mixer at most", "always(on(go) -> always[0:0.8](active <= 1))", (0.2, 1.5)),
    Race("stale_cache", "It rests after a stop", _AT_REST, (0.9, 2.0), ("stop",)),
    Race("lost_update", "It counts everybody", "always(on(go) -> eventually[0.3:0.8](lost == 0))", (1.0, 1.5)),
    Race("wiper_modes", "It rests after a stop", _SOON_AT_REST, (1.0, 1.6), _GO_STOP, is_held_out=True),
    Race("order_list", "Each order is served", _EACH_SERVED.format(""), (1.0, 1.5), is_held_out=True),
    Race(
        "goal_table",
        "It moves when it is told to",
        "always(on(go) -> always[0.6:1.1](moving))",
        (1.2, 1.7),
        _GO_STOP,
        is_held_out=True,
    ),
    Race("lazy_driver", "Each order is served", _EACH_SERVED.format("2 * "), (1.0, 1.5), is_held_out=True),
    Race(
        "belt_counter",
        "It counts everything",
        "always(on(go) -> eventually[0.4:0.95](lost == 0))",
        (1.0, 1.5),
    ),
    Race(
        "busy_arms",
        "One arm at most is over the table",
        "always(on(go) -> always[0:0.95](active <= 1))",
        (1.0, 1.5),
        is_held_out=True,
    ),
    Race("packers", "Each order is served", _EACH_SERVED.format(""), (1.0, 1.5)),
    Race(
        "contact_timer",
        "It moves for a second after each contact",
        "always(on(go) -> always[0.5:1.1](moving))",
        (0.6, 1.1),
        is_held_out=True,
    ),
    Race("shared_goal", "It rests after a stop", _SOON_AT_REST, (1.0, 1.6), _GO_STOP, is_held_out=True, ros2=True),
    Race(
        "planned_move",
        "It rests after a stop",
        "always(on(stop) -> always[0.6:1.2](not moving))",
        (0.9, 1.1),
        _GO_STOP,
        is_held_out=True,
    ),
    Race("taken_part", "Each order is served", _EACH_SERVED.format(""), (1.0, 1.5), is_held_out=True),
    Race("full_tray", "It is served", "always(on(go) -> eventually[0:0.8](on(done)))", (1.0, 1.5)),
    Race("cleared_event", "Each order is served", _ALL_SERVED, (1.0, 1.5), is_held_out=True),
    Race("changing_goals", "Each goal is met", _EACH_SERVED.format(""), (1.0, 1.5)),
    Race("second_grip", "It grips once", "always(on(go) -> always[0:0.8](active <= 1))", (1.0, 1.5), is_held_out=True),
    Race(
        "twice_pressed",
        "A press is a cup",
        "always(on(go) -> always[0:0.8](given <= count(on(go))))",
        (1.0, 1.5),
        is_held_out=True,
    ),
    Race("shared_steps", "Each wheel turns", _ALL_SERVED, (1.0, 1.5), is_held_out=True),
    Race(
        "between_queues",
        "What is done is given",
        "always(on(done) -> given >= 2 * count(on(done)))",
        (1.0, 1.5),
    ),
    Race("one_reply", "Each order is served", _EACH_SERVED.format("2 * "), (1.0, 1.5), is_held_out=True),
    Race("wrong_waiter", "Each order is served", _EACH_SERVED.format("2 * "), (1.0, 1.5), is_held_out=True),
    Race("too_polite", "Each order is served", _EACH_SERVED.format(""), (1.0, 1.5)),
    Race(
        "even_version",
        "A pose is read whole",
        "always(on(go) -> always[0:0.6](lost == 0))",
        (1.0, 1.5),
        is_held_out=True,
    ),
    Race("two_of_three", "It sees everybody", _EACH_SERVED.format(""), (1.0, 1.5), is_held_out=True),
    Race(
        "late_callback",
        "It shows all cups",
        "always(on(go) -> eventually[0.4:0.95](lost == 0))",
        (1.0, 1.5),
        is_held_out=True,
    ),
    Race(
        "wiped_answer",
        "It moves when it is told to",
        "always(on(go) -> always[0.6:0.95](moving))",
        (1.0, 1.6),
        _GO_STOP,
        is_held_out=True,
    ),
    Race("listed_goals", "Each goal is met", _EACH_SERVED.format(""), (1.0, 1.5)),
)

_NOTHING_LOST = "always(on(go) -> eventually[0.1:0.4](lost == 0))"
_ALWAYS = "always(on(go) -> always[0:0.4](lost == 0))"

ANCHORS = (
    Race("two_purses", "No coin is lost", _NOTHING_LOST, (0.5, 1.5)),
    Race("lazy_camera", "One camera at most is open", "always(on(go) -> always[0:0.4](active <= 1))", (0.5, 1.5)),
    Race("shared_address", "Each letter has its address", _ALWAYS, (0.5, 1.5)),
    Race("guest_rooms", "Both guests are listed", _NOTHING_LOST, (0.5, 1.5)),
    Race("one_ticket", "A ticket is taken once", _ALWAYS, (0.5, 1.5)),
    Race("torn_pose", "A pose is read whole", _ALWAYS, (0.5, 1.5)),
    Race(
        "three_tools",
        "Each order is served",
        "always(on(go) -> eventually[0:0.45](count(on(done)) == 3 * count(on(go))))",
        (0.5, 1.5),
    ),
    Race(
        "swallowed_cancel",
        "It rests after a stop",
        "always(on(stop) -> always[0.6:0.95](not moving))",
        (0.9, 2.0),
        ("stop",),
    ),
    Race("lost_notify", "Each order is served", _EACH_SERVED.format(""), (1.0, 1.5)),
    Race(
        "two_spinners",
        "It moves when it is told to",
        "always(on(go) -> eventually[0:0.5](moving))",
        (0.5, 1.5),
        ros2=True,
        code=("rclpy.executors",),
    ),
)
"""Kinds of races that others publish, written anew and small: those of explorers for Python (frontrun,
https://pypi.org/project/frontrun/), two of asyncio itself, cpython#86296 and cpython#112202, and rclpy#1393."""
