"""Journals: every whole record is read, and nothing else."""

from __future__ import annotations

import os
import resource
from pathlib import Path

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv.results.folder_files import FolderLock
from pytest_hricdv.results.journal import (
    NAME,
    JournalWriter,
    NoResultRecord,
    ResultRecord,
    StartRecord,
    line,
    read,
    records,
)


def finished(number: int) -> ResultRecord:
    return ResultRecord(f"test[{number}]", float(number), msgspec.Raw(b'{"number":%d}' % number))


def written(path: Path, *numbers: int) -> JournalWriter:
    writer = JournalWriter(path)
    writer.append(StartRecord("2026-01-01T00:00:00", {}))
    for number in numbers:
        writer.append(finished(number))
    return writer


@given(st.integers(min_value=0), st.data())
def test_a_torn_record_is_recognized_wherever_it_is_torn(
    tmp_path_factory: pytest.TempPathFactory, number: int, data: st.DataObject
) -> None:
    path = tmp_path_factory.mktemp("torn") / NAME
    written(path, 1).close()
    whole, torn = path.read_bytes(), line(finished(number))
    path.write_bytes(whole + torn[: data.draw(st.integers(0, len(torn) - 1))])
    journal = read(path)
    assert [*journal.results] == ["test[1]"]
    assert journal.size == len(whole)


def test_a_journal_goes_on_behind_its_last_whole_record(tmp_path: Path) -> None:
    path = tmp_path / NAME
    written(path, 1).close()
    with path.open("ab") as file:
        file.write(line(finished(2))[:-5])
    writer = JournalWriter(path, read(path).size)
    writer.append(StartRecord("2026-01-02T00:00:00", {}))
    writer.append(finished(3))
    writer.close()
    journal = read(path)
    assert [*journal.results] == ["test[1]", "test[3]"]
    assert (len(journal.began), journal.damaged, journal.wall_s) == (2, 0, 4.0)


def test_what_a_full_disk_has_no_room_for_is_written_when_there_is_room(tmp_path: Path) -> None:
    path = tmp_path / NAME
    writer = written(path, 1)
    size, before = path.stat().st_size, resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size + 20, before[1]))
    try:
        writer.append(finished(2))
        assert path.stat().st_size == size  # no part of a record
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert NAME in writer.problem
    writer.append(finished(3))
    assert not writer.problem
    assert [*read(path).results] == ["test[1]", "test[2]", "test[3]"]


def test_a_test_with_an_error_after_its_result_is_not_done(tmp_path: Path) -> None:
    writer = written(tmp_path / NAME, 1, 2)
    writer.append(NoResultRecord("test[2]", 3.0, "the teardown failed"))
    journal = read(tmp_path / NAME)
    assert journal.complete_ids == {"test[1]"}
    assert journal.reasons == {"test[2]": "the teardown failed"}


def test_a_lock_is_released_when_its_process_dies(tmp_path: Path) -> None:
    child = os.fork()
    if child == 0:
        FolderLock(tmp_path)
        os._exit(0)
    os.waitpid(child, 0)
    FolderLock(tmp_path).release()


@pytest.mark.parametrize("size", [63, 64, 65, 127, 128, 129, 1000])
@pytest.mark.parametrize("end", [b"\n", b""])
def test_a_line_without_end_is_no_record_and_costs_no_memory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, size: int, end: bytes
) -> None:
    path = tmp_path / NAME
    written(path, 1).close()
    first = path.read_bytes()
    longest = max(map(len, first.splitlines(keepends=True)))
    monkeypatch.setattr("pytest_hricdv.results.journal.MAX_LINE_BYTES", longest)
    path.write_bytes(first + b"\0" * size + end + (line(finished(2)) if end else b""))
    journal = read(path)
    assert {*journal.results} == ({"test[1]", "test[2]"} if end else {"test[1]"})
    assert journal.damaged == 1
    assert journal.size == (path.stat().st_size if end else len(first))
    assert len(records(path)) == len(journal.results) + 1
