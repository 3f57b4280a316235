"""What a person who writes a testbench for the porter by hand declares. Written before a draft of it was made."""

from __future__ import annotations

MESSAGES = ("Request", "Pin", "Lid", "Obstacle", "Status", "Spoken")

STATES = ("parked", "loading", "driving", "blocked", "waiting", "unloading", "returning")

TRANSITIONS = (
    ("parked", "loading"),
    ("loading", "driving"),
    ("loading", "parked"),
    ("driving", "blocked"),
    ("driving", "waiting"),
    ("driving", "returning"),
    ("blocked", "driving"),
    ("blocked", "returning"),
    ("waiting", "unloading"),
    ("waiting", "returning"),
    ("unloading", "returning"),
    ("returning", "parked"),
)

VALUES = {
    "request.kind": ("load", "send", "abort", "where"),
    "status.phase": STATES,
    "spoken.text": (
        "no such room",
        "please close the lid",
        "too many attempts",
        "wrong pin",
        "put the parcel in",
        "excuse me",
        "please type the pin",
        "take the parcel out",
        "goodbye",
    ),
}
