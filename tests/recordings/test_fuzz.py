"""Whatever is changed in the bytes of a recording, reading it ends, with what is wrong in words."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_hricdv.recordings.recording import read_recordings
from tests.recordings.bags import STRING, text, tray, write_mcap, write_sqlite

ENTRIES = [(0.1 * n, "/tray", tray(n, -n / 2, n % 3, [n, n + 0.5], n > 5)) for n in range(12)]
ENTRIES += [(0.1 * n + 0.05, "/said", text(f"word {n}")) for n in range(12)]
TYPES = {"/tray": "cell_msgs/msg/Tray", "/said": STRING}
CHANGES = st.lists(st.tuples(st.floats(0.0, 1.0, exclude_max=True), st.binary(max_size=9)), min_size=1, max_size=6)


@pytest.fixture(scope="module")
def recordings(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("fuzz")
    made = [write_mcap(folder / "cdr.mcap", ENTRIES, TYPES), write_sqlite(folder / "bag", ENTRIES, TYPES)]
    json = [(0.1 * n, "/said", {"a": [n, {"b": math.pi}], "c": "d" * n}) for n in range(12)]
    made += [write_mcap(folder / "json.mcap", json), write_mcap(folder / "packed.mcap", json, packed=True)]
    return [next(path.glob("*.db3")) if path.is_dir() else path for path in made]


@pytest.mark.parametrize("number", range(4), ids=["CDR", "SQLite", "JSON", "packed"])
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(changes=CHANGES, cut=st.floats(0.5, 1.0))
def test_damage_ends_in_words(
    recordings: list[Path], tmp_path: Path, number: int, changes: list[tuple[float, bytes]], cut: float
) -> None:
    data = bytearray(recordings[number].read_bytes())
    for where, new in changes:
        place = int(where * len(data))
        data[place : place + len(new)] = new
    damaged = tmp_path / f"run{recordings[number].suffix}"
    damaged.write_bytes(data[: int(cut * len(data))] if cut < 0.9 else data)
    (recording,) = read_recordings([damaged], lambda topic: True, lambda kind: None)
    assert recording.parts or recording.problems
