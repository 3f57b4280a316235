"""What runs read is noticed at the project's own lines, and can be made to stand still."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from types import ModuleType

import pytest

from pytest_hricdv.extra.audit.sources import CLOCK, FILE_TIMES, FILES, RANDOM, SourceWatch

OWN = """
import os
import random
import time
from pathlib import Path
from time import time as now

HERE = Path(__file__)


def clock():
    return now()


def moment():
    import datetime

    return datetime.datetime.now().timestamp()


def system():
    return os.urandom(8)


def unseeded():
    return random.Random().random()


def written():
    return HERE.stat().st_mtime_ns


def is_there():
    return (HERE.with_name("data.txt")).exists()


def read():
    return HERE.with_name("data.txt").read_text()
"""


@pytest.fixture
def own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[ModuleType]:
    """A module of a project in a folder, with a file beside it."""
    (tmp_path / "own_module.py").write_text(OWN, encoding="utf-8")
    (tmp_path / "data.txt").write_text("data", encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))
    yield importlib.import_module("own_module")
    del sys.modules["own_module"]


def sources(own: ModuleType, *still: str, watched: bool = False, hidden: tuple[str, ...] = ()) -> SourceWatch:
    """Of the module's project."""
    return SourceWatch(str(Path(str(own.__file__)).parent), still=still, watched=watched, hidden=hidden)


@pytest.mark.parametrize(
    ("name", "kind"),
    [("clock", CLOCK), ("moment", CLOCK), ("system", RANDOM), ("unseeded", RANDOM), ("written", FILE_TIMES)],
)
def test_what_stands_still_is_the_same_each_time(own: ModuleType, name: str, kind: str) -> None:
    function: Callable[[], object] = getattr(own, name)
    values = []
    for _ in range(2):
        with sources(own, kind):
            values.append(function())
    assert values[0] == values[1]
    assert function() != values[0]


def test_readings_have_the_line_of_the_project(own: ModuleType) -> None:
    with sources(own, watched=True) as watching:
        own.clock()
        own.read()
        time.time()  # not of the project
    readings = {(reading.kind, reading.what, reading.place) for reading in watching.readings()}
    assert (CLOCK, "time.time", "own_module.py:12") in readings
    assert (FILES, "open", "own_module.py:38") in readings
    assert {place.partition(":")[0] for _, _, place in readings} == {"own_module.py"}


def test_a_hidden_file_is_not_there(own: ModuleType, tmp_path: Path) -> None:
    assert own.is_there()
    with sources(own, hidden=(str(tmp_path / "data.txt"),)):
        assert not own.is_there()
        with pytest.raises(FileNotFoundError):
            own.read()
    assert own.read() == "data"


def test_all_is_as_it_was_afterwards(own: ModuleType) -> None:
    before = {name: vars(time)[name] for name in ("time", "monotonic", "perf_counter")}
    with sources(own, *(CLOCK, RANDOM, FILE_TIMES), watched=True):
        assert own.now is not before["time"]
    assert {name: vars(time)[name] for name in before} == before
    assert own.now is before["time"]
