"""A program takes off, flies and lands, over a link that becomes worse and better."""

from __future__ import annotations

from collections.abc import Mapping

START = "ground"

_LINKS = tuple(f"link {name}" for name in ("good", "loses", "slow", "garbled"))
_ANYWHERE = ("height", "stay", *_LINKS)

FOLLOWS: Mapping[str, Mapping[str, str]] = {
    "ground": {**dict.fromkeys(_ANYWHERE, "ground"), "takeoff": "air"},
    "air": {**dict.fromkeys((*_ANYWHERE, "move_forward", "rotate_clockwise"), "air"), "land": "ground"},
}
