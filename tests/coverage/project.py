"""A small package under test, written into a folder."""

from __future__ import annotations

from pathlib import Path

SOURCE = '''\
"""Code under test."""

LIMIT = 3


def grade(number):
    if number > LIMIT:
        return "high"
    if number == 0:
        return "zero"
    return "low"


def never():
    return 1  # unreachable: never called
'''


def write_package(folder: Path, name: str, source: str = SOURCE) -> Path:
    """Write `name/__init__.py` and return its path."""
    package = folder / name
    package.mkdir()
    file = package / "__init__.py"
    file.write_text(source, encoding="utf-8")
    return file
