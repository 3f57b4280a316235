"""Atomic file writes: a reader sees either the old content or the new one, never a mixture.

All modules that write a file for users call `write_text`, `write_bytes` or, to write it in steps, `replace_file`.
"""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

_OPEN, _REPLACE = open, os.replace  # as they are now: the code under test may replace them for the whole process


def write_text(path: Path, text: str) -> Path:
    """Write `text` as UTF-8 to `path`, whose folder is created where it is missing; returns `path`.

    A lone surrogate, which has no UTF-8, is written as its escape.

    Raises:
        OSError: the folder or the file cannot be written; an old file is left as it was.
    """
    return write_bytes(path, text.encode("utf-8", "backslashreplace"))


def write_bytes(path: Path, data: bytes) -> Path:
    """Write `data` to `path`; see `write_text`."""
    with replace_file(path) as temporary, _OPEN(temporary, "wb") as file:
        file.write(data)
    return path


@contextlib.contextmanager
def replace_file(path: Path) -> Iterator[Path]:
    """A temporary file to write, which replaces `path` unless writing fails. Raises the same errors as `write_text`."""
    temporary = temporary_path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _make_own(temporary)
        yield temporary
        _REPLACE(temporary, path)
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def _make_own(path: Path) -> None:
    """Make a new empty file. Remove an existing one first: it may be a link laid by somebody who guessed the name."""
    with contextlib.suppress(FileNotFoundError):
        path.unlink()
    os.close(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666))


def temporary_path(path: Path) -> Path:
    """The temporary file for `path`, in the same folder, since renaming is atomic only there."""
    return path.with_name(f".{path.name}.{os.getpid()}.part")
