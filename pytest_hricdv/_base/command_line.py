"""`CommandParser` parses `hricdv` commands, and suggests the nearest name for a misspelt command or option.

The commands call `work_on_unread` so that they continue if the reader of their output ends before them, as in
`hricdv init hri --from robot | head -3`.
"""

from __future__ import annotations

import argparse
import io
import os
import re
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from difflib import get_close_matches
from typing import Any, NoReturn

_CHOICE = re.compile(r"invalid choice: '([^']*)'")
_UNKNOWN = re.compile(r"unrecognized arguments: (-[^ =]*)")


class CommandParser(argparse.ArgumentParser):
    """A parser that prints descriptions with their line breaks, also those of its subcommands."""

    def __init__(self, *arguments: object, **options: object) -> None:
        options.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(*arguments, **options)  # type: ignore[arg-type]

    def error(self, message: str) -> NoReturn:
        """Exit with status 2, the usage, and the nearest known name."""
        asked = _CHOICE.search(message) or _UNKNOWN.search(message)
        near = get_close_matches(asked[1], [*self._list_names()]) if asked else []
        if not (near and asked):
            super().error(message)
        # Two letters may be swapped, and the first one is seldom wrong.
        best = max(near, key=lambda name: (sorted(name) == sorted(asked[1]), name[0] == asked[1][0]))
        what = f"no {asked[1]!r} here" if _CHOICE.search(message) else message
        super().error(f"{what}; did you mean {best}?")

    def _list_names(self) -> Iterator[str]:
        """Commands and options, also those of subcommands."""
        for action in self._actions:
            yield from action.option_strings
            if isinstance(action, argparse._SubParsersAction):
                for name, parser in action.choices.items():
                    yield name
                    yield from parser._list_names()


class _StreamWriter(io.RawIOBase):
    """A standard stream of this process. Output without a reader is discarded, also that of child processes."""

    def __init__(self, descriptor: int) -> None:
        super().__init__()
        self._descriptor = descriptor

    def writable(self) -> bool:
        """It is for output."""
        return True

    def fileno(self) -> int:
        """The descriptor, which processes inherit."""
        return self._descriptor

    def isatty(self) -> bool:
        """Whether a person reads it."""
        return os.isatty(self._descriptor)

    def write(self, data: Any) -> int:
        """Write bytes."""
        try:
            return os.write(self._descriptor, data)
        except BrokenPipeError:
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._descriptor)
            os.close(nowhere)
            return len(data)


def work_on_unread() -> None:
    """Let this process continue and exit with its usual status when its output has no reader any more.

    For commands that make or judge something: their result is complete, and a failed gate still shows.
    """
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if isinstance(stream, io.TextIOWrapper):  # none if the process was started without it
            stream.flush()
            written = io.BufferedWriter(_StreamWriter(stream.fileno()))
            setattr(sys, name, io.TextIOWrapper(written, stream.encoding, stream.errors, None, stream.line_buffering))


class UnreadStream:
    """A text stream whose reader may leave, as in `pytest | head`: later texts are discarded."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text."""
        with suppress(BrokenPipeError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Write what waits."""
        with suppress(BrokenPipeError):
            self._stream.flush()


def end_with_reader() -> None:
    """Let this process end at once, as Unix programs do (status 141), when its output has no reader any more.

    For commands that only print, perhaps without end.
    """
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
