"""Somebody asks for a leg, waits or gets bored, takes a pose, says so, and asks again."""

from __future__ import annotations

from collections.abc import Mapping

START = "idle"

_POSE = {f"set_param {what} = {value}": "posing" for what in ("gaze", "pressure", "location") for value in (0, 1)}

FOLLOWS: Mapping[str, Mapping[str, str]] = {
    "idle": {"tell leg": "asked"},
    "asked": {"receivesignal": "offered", "bored": "idle"},
    "offered": {**_POSE, "bored": "idle"},
    "posing": {**_POSE, "tell humanReady": "idle"},
}
