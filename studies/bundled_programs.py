"""Lists the programs and libraries that installed packages bring along, whose licences no package index knows.

    python -m studies.bundled_programs

A check of licences reads what packages say of themselves. A wheel can contain a program of others, under a licence of
its own, as `imageio-ffmpeg` has ffmpeg. Exit status 1: there is a program that docs/trust.md does not name.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from importlib.metadata import Distribution, distributions
from pathlib import Path

PROGRAMS: Mapping[str, str] = {"imageio-ffmpeg": "ffmpeg, GPL 3 or later (it is built with --enable-gpl)"}
"""Distribution -> what it brings along, as docs/trust.md says. `ffmpeg -L` writes its licence."""

_BEGINNINGS = (b"\x7fELF", b"MZ", b"\xcf\xfa\xed\xfe", b"\xca\xfe\xba\xbe")
"""Of programs and libraries of Linux, Windows, macOS, and macOS for two kinds of processors."""
_LAUNCHER = re.compile(r"(cli|gui|t|w)-?(32|64)?(-?arm(64)?)?\.exe")
"""Of pip and setuptools: they start scripts on Windows."""


def bundled(packages: Iterable[Distribution]) -> Iterator[tuple[str, str, bool]]:
    """Distribution, name of a file, and whether it is a program: else a library of others, in a folder `NAME.libs`."""
    for package in packages:
        for file in package.files or ():
            path = Path(str(package.locate_file(file)))
            of_others = any(part.endswith((".libs", ".dylibs")) for part in file.parts)
            if not path.is_file() or _LAUNCHER.fullmatch(path.name) or not _is_binary(path):
                continue
            if of_others or not _is_library(path.name):
                yield package.metadata["Name"], file.as_posix(), not of_others


def main() -> int:
    """Print them; returns the exit status."""
    status = 0
    for name, file, is_program in sorted(set(bundled(distributions()))):
        licence = PROGRAMS.get(name, "UNKNOWN: name it in docs/trust.md") if is_program else "library, see its package"
        status |= int(is_program and name not in PROGRAMS)
        print(f"{name:24} {file}: {licence}")
    return status


def _is_binary(path: Path) -> bool:
    with path.open("rb") as file:
        return file.read(4).startswith(_BEGINNINGS)


def _is_library(name: str) -> bool:
    return ".so" in name or name.endswith((".pyd", ".dll", ".dylib", ".a", ".o"))


if __name__ == "__main__":
    sys.exit(main())
