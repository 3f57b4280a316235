"""Whole recordings in memory, for tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.recordings.message_order import RecordedSample
from pytest_hricdv.recordings.recording import recording_readers


@dataclass(frozen=True)
class Recording:
    """The content of one file or folder: its messages in the order of time, a part for each stretch of its clock."""

    parts: tuple[tuple[RecordedSample, ...], ...]
    problems: tuple[str, ...]
    notes: tuple[str, ...]
    is_cut: bool


def read_recordings(paths: Sequence[Path]) -> list[Recording]:
    """Read bags and MCAP files."""
    recordings = []
    for reader in recording_readers(paths, lambda kind: None):
        parts: dict[int, list[RecordedSample]] = {}
        for number, sample in reader.samples(lambda topic: {}):
            parts.setdefault(number, []).append(sample)
        problems = (*reader.problems, *reader.unreadable_lines(), *reader.jumps)
        made = tuple(map(tuple, parts.values()))
        recordings.append(Recording(made, problems, tuple(reader.notes) if reader.count else (), reader.is_cut))
    return recordings
