"""What names of readings and commands say of how a device moves."""

from __future__ import annotations

import re

AXES = {
    "x": ("x",),
    "y": ("y",),
    "heading": ("heading", "theta", "yaw", "phi", "th", "angle", "orientation", "bearing", "rotation", "azimuth"),
}
"""Part of a pose in the plane -> how it is called."""

SPEEDS = {
    "forward": ("forward", "forwards", "linear", "lin", "v", "vx", "speed", "velocity", "translation", "surge",
                "linear_x", "x_dot"),
    "turn": ("turn", "angular", "ang", "w", "wz", "vth", "vtheta", "omega", "rotation", "rotate", "yaw_rate",
             "turn_rate", "angular_z", "steer", "spin"),
    "left": ("left", "l", "vl", "left_wheel", "wheel_left", "left_speed"),
    "right": ("right", "r", "vr", "right_wheel", "wheel_right", "right_speed"),
}  # fmt: skip
"""Part of a speed in the plane, or of the speeds of two wheels -> how it is called."""

DRIVES = ("drive", "move", "go", "cmd_vel", "velocity", "speed", "twist", "run")
"""A method that is called so and takes two numbers takes speeds: forward, and turning."""

HALTS = ("stop", "halt", "stand", "brake", "hold")
"""A method that is called so lets what moves stay where it is."""

POSES = ("pose", "position", "odometry", "odom", "location", "localization", "where")
"""A reading that is called so and has three items has x, y and a heading."""

PAIRS = (
    (("open", "opened", "release", "released", "opening"), ("close", "closed", "shut", "grip", "gripped", "grasp")),
    (("raise", "raised", "lift", "lifted", "up"), ("lower", "lowered", "down")),
    (("extend", "extended", "out"), ("retract", "retracted", "in")),
    (("lock", "locked"), ("unlock", "unlocked")),
    (("on", "start", "started", "enable", "enabled", "running"), ("off", "stop", "stopped", "disable", "disabled")),
)
"""Methods, switches that are true, and readings, by which something is as far as it can be, or is back again."""

GOES = ("go", "goto", "move", "set", "to", "command", "target", "drive")
"""Words of a method that takes a number to go to, beside the name of the reading that follows."""

STORES = ("battery", "charge", "voltage", "current", "power", "fuel")
"""A reading with one of these words follows nothing that a device is told at once."""

DEEDS = ("open", "close", "grip", "grasp", "release", "raise", "lift", "lower", "extend", "retract", "lock", "unlock",
         "start", "stop", "enable", "disable", "set", "move", "go", "drive")  # fmt: skip
"""A method that is called so does something, and what it returns says whether it has done it, not where it is."""

HANDS = ("grip", "hand", "claw", "jaw", "finger")
"""A device, or a reading, whose name has one of these is open at first: what it does first is to take something."""

_UNITS = re.compile(r"_(m|mm|cm|rad|deg|m_s|mm_s|rad_s|deg_s|mps)$")


def bare(name: str) -> str:
    """The name without its unit, `get_` and underscores around it.

    >>> bare("_forward_m_s"), bare("get_pose"), bare("theta_rad")
    ('forward', 'pose', 'theta')
    """
    return _UNITS.sub("", name.strip("_").lower()).removeprefix("get_").removeprefix("read_").removeprefix("current_")


def axis(name: str) -> str:
    """The part of a pose that is called so; empty where none is."""
    return next((part for part, names in AXES.items() if bare(name) in names), "")


def speed(name: str) -> str:
    """The part of a speed that is called so; empty where none is."""
    return next((part for part, names in SPEEDS.items() if bare(name) in names), "")


def is_open_first(name: str) -> bool:
    """Whether something of this name is open before the robot has done anything."""
    return any(hand in name.lower() for hand in HANDS)


def words(name: str) -> tuple[str, ...]:
    """The words of a name, without its unit.

    >>> words("is_open"), words("set_height_m")
    (('is', 'open'), ('set', 'height'))
    """
    return tuple(bare(name).split("_"))


def way(name: str) -> tuple[int, int]:
    """Which of `PAIRS` a name has a word of, and 1 for the first side, -1 for the second; (0, 0) where it has none.

    >>> way("is_open"), way("close"), way("lift_up"), way("scan")
    ((0, 1), (0, -1), (1, 1), (0, 0))
    """
    for word in words(name):
        for number, (up, down) in enumerate(PAIRS):
            if word in (*up, *down):
                return number, 1 if word in up else -1
    return 0, 0
