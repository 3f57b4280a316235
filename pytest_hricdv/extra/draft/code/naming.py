"""What names in the code say (their unit), and names of topics, classes and beliefs made from them."""

from __future__ import annotations

import keyword
import re

UNITS = {
    "s": "s", "sec": "s", "secs": "s", "seconds": "s", "ms": "ms", "us": "us", "ns": "ns", "min": "min",
    "minutes": "min", "m": "m", "mm": "mm", "cm": "cm", "km": "km", "meters": "m", "metres": "m", "deg": "deg",
    "degrees": "deg", "rad": "rad", "radians": "rad", "n": "N", "nm": "Nm", "kg": "kg", "g": "g", "l": "l",
    "ml": "ml", "hz": "Hz", "v": "V", "volts": "V", "mv": "mV", "a": "A", "ma": "mA", "w": "W", "pa": "Pa",
    "bar": "bar", "celsius": "degC", "percent": "%", "pct": "%", "rpm": "rpm",
}  # fmt: skip
"""Last word of a name -> unit; `RATES` are those of two words."""

RATES = {
    "m_s": "m/s", "mm_s": "mm/s", "cm_s": "cm/s", "rad_s": "rad/s", "deg_s": "deg/s", "ml_s": "ml/s", "m_s2": "m/s2",
    "rad_s2": "rad/s2", "mps": "m/s",
}  # fmt: skip
"""Last words of a name -> unit of a speed or acceleration."""

TIMES = ("timeout", "time_out", "delay", "interval", "period", "duration", "patience", "deadline")
"""A number whose name ends in one of these is in seconds, as the calls that take it are."""


def unit_of(name: str) -> str:
    """The unit that a name ends in; empty if it has none.

    >>> unit_of("MAX_SPEED_M_S"), unit_of("level_ml"), unit_of("grip_timeout"), unit_of("s"), unit_of("count")
    ('m/s', 'ml', 's', '', '')
    """
    lower = name.lower().strip("_")
    for ending, unit in RATES.items():
        if lower.endswith("_" + ending):
            return unit
    head, _, last = lower.rpartition("_")
    if head and last in UNITS:
        return UNITS[last]
    return "s" if lower.endswith(TIMES) else ""


def snake(name: str) -> str:
    """The bus's topic for a class (`HumanReady` -> `human_ready`).

    >>> snake("GaveUp"), snake("URDFState")
    ('gave_up', 'urdfstate')
    """
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower()


def camel(text: str) -> str:
    """A name for a class of what a text names.

    >>> camel("robot/door_state"), camel("commands"), camel("2nd")
    ('RobotDoorState', 'Commands', 'Message2nd')
    """
    name = "".join(part[:1].upper() + part[1:] for part in re.split(r"[^A-Za-z0-9]+", text) if part)
    if not name or not name[0].isalpha():
        name = "Message" + name
    return name + "_" if keyword.iskeyword(name) else name


def word(text: str) -> str:
    """An atom of AgentSpeak, and a name of Python, that is like a text.

    >>> word("Move_hand"), word("I am ready!"), word("3d"), word("class")
    ('move_hand', 'i_am_ready', 'x3d', 'class_')
    """
    name = re.sub(r"[^a-z0-9]+", "_", snake(text)).strip("_")
    if not name or not name[0].isalpha():
        name = "x" + name
    return name + "_" if keyword.iskeyword(name) or name in ("mod", "div", "rdiv", "not", "true", "false") else name
