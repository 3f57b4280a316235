"""What is to be known of a run of a ROS 2 system, though it fails nothing: a sentence each, and each one once."""

from __future__ import annotations

from pytest_hricdv.runtime import Kernel

_NOTES = "ros2 notes"


def note(kernel: Kernel, sentence: str) -> None:
    """Keep a sentence for the report; it names no time, so that runs say the same of the same."""
    notes = kernel.own.setdefault(_NOTES, {})
    assert isinstance(notes, dict)
    notes.setdefault(sentence)


def notes_of(kernel: Kernel) -> tuple[str, ...]:
    """Those of a run, in the order in which they came."""
    notes = kernel.own.get(_NOTES, {})
    assert isinstance(notes, dict)
    return tuple(notes)
