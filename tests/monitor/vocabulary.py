"""The vocabulary of the table assembly, over which most of these tests are written, and how a run is fed."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from pytest_hricdv.monitor import (
    MonitorSet,
    Requirement,
    RequirementError,
    Value,
    Verdict,
    Vocabulary,
    load_requirements,
    parse_formula,
)

TABLE = Vocabulary(
    signals={
        "leg_held": bool,
        "leg_torn": bool,
        "leg_offset": float,
        "hand_closing": bool,
        "hand_distance": float,
        "hand_contact_force": float,
        "arm_speed": float,
    },
    messages={
        "reading": {"gaze": bool, "pressure": bool, "location": bool},
        "request": {},
        "signal": {},
        "ready": {},
        "table_done": {"released": float, "duration_s": float, "on_time": bool},
    },
)

REQUIREMENTS_FILE = Path(__file__).parent / "case_study.toml"
R1, R2, R3, R4, R5 = load_requirements(REQUIREMENTS_FILE, TABLE)

# p, q: conditions; x, y: numbers; s: a text; a, b: events; m: a message with fields; n, w: such with a single one.
SMALL = Vocabulary(
    signals={"p": bool, "q": bool, "x": float, "y": float, "s": str},
    messages={"a": {}, "b": {}, "m": {"ok": bool, "level": float}, "n": {"level": float}, "w": {"name": str}},
    values={"w.name": ("i", "j", "k")},
)

Update = tuple[float, str, "Value | Mapping[str, Value]"]


def requirement(text: str, vocabulary: Vocabulary = SMALL) -> Requirement:
    return Requirement("R", "A requirement", "", text, parse_formula(text, vocabulary))


def marked(error: RequirementError) -> str:
    """What the carets below the text of an error mark."""
    lines = str(error).splitlines()
    [place] = [number for number, line in enumerate(lines) if line.strip() and set(line.strip()) == {"^"}]
    return lines[place - 1][lines[place].index("^") : lines[place].rindex("^") + 1]


def judge(watched: Requirement | str, updates: Sequence[Update], end_s: float) -> Verdict:
    """The verdict on a run: an update of a topic is written with a dict, of a signal with its value."""
    watched = requirement(watched) if isinstance(watched, str) else watched
    monitors = MonitorSet([watched])
    feed(monitors, updates)
    [verdict] = monitors.finish(end_s)
    return verdict


def feed(monitors: MonitorSet, updates: Iterable[Update]) -> None:
    for time_s, name, value in updates:
        if isinstance(value, Mapping):
            monitors.message(time_s, name, value)
        else:
            monitors.signal(time_s, name, value)
