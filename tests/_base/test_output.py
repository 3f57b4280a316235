"""Nobody reads the output of a command any more: it goes on with its work, or ends, and says nothing of it."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv._base.command_line import UnreadStream, _StreamWriter

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="no SIGPIPE")


def test_what_nobody_reads_goes_nowhere() -> None:
    reading, writing = os.pipe()
    stream = _StreamWriter(writing)
    assert stream.write(b"first\n") == 6
    assert os.read(reading, 6) == b"first\n"
    os.close(reading)
    assert stream.write(b"second\n") == 7
    assert os.write(writing, b"of a process that it starts\n") == 28
    os.close(writing)


def test_nor_do_texts_of_a_stream() -> None:
    reading, writing = os.pipe()
    stream = UnreadStream(os.fdopen(writing, "w"))
    os.close(reading)
    assert stream.write("text\n") == 5
    stream.flush()
    assert not stream.isatty()
    with contextlib.suppress(BrokenPipeError):
        stream.close()


def unread(command: list[str], folder: Path, *, errors_too: bool = False) -> tuple[int, str]:
    """Exit status of a command whose output nobody reads, and what it says on the other stream."""
    arguments = [sys.executable, "-m", *command]
    errors = subprocess.STDOUT if errors_too else subprocess.PIPE
    with subprocess.Popen(arguments, cwd=folder, stdout=subprocess.PIPE, stderr=errors) as process:
        assert process.stdout is not None
        process.stdout.close()
        said = b"" if process.stderr is None else process.stderr.read()
        return process.wait(), said.decode()


@pytest.mark.slow
@pytest.mark.parametrize("errors_too", [False, True])
def test_a_project_is_written_though_nobody_reads_its_files(tmp_path: Path, errors_too: bool) -> None:
    assert unread(["pytest_hricdv", "init", "kitchen"], tmp_path, errors_too=errors_too) == (0, "")
    assert (tmp_path / "kitchen" / "conftest.py").exists()


@pytest.mark.slow
def test_the_status_of_an_error_stays(tmp_path: Path) -> None:
    assert unread(["pytest_hricdv.report", "gate", "gone"], tmp_path, errors_too=True) == (2, "")
    assert unread(["pytest_hricdv", "init", "hri", "--from", "gone"], tmp_path, errors_too=True) == (2, "")
