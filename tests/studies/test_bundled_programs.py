"""What packages bring along beside Python is listed, whatever they say of their licence."""

from __future__ import annotations

from importlib.metadata import distributions
from pathlib import Path

import pytest

from studies.bundled_programs import bundled

ELF, EXE = b"\x7fELF\x02\x01", b"MZ\x90\x00"


@pytest.mark.parametrize(
    ("file", "content", "listed"),
    [
        ("film/binaries/ffmpeg", ELF, [True]),
        ("film/ffmpeg.exe", EXE, [True]),
        ("../../../bin/tool", ELF, [True]),
        ("film.libs/libx264-1a.so.164", ELF, [False]),
        ("film/.dylibs/libx264.dylib", b"\xcf\xfa\xed\xfe", [False]),
        ("film/_core.cpython-311-x86_64-linux-gnu.so", ELF, []),
        ("film/_core.pyd", EXE, []),
        ("film/ffmpeg.py", b"#!/usr/bin/python", []),
        ("film/t64-arm.exe", EXE, []),
        ("film/gui-arm64.exe", EXE, []),
        ("film/empty", b"", []),
    ],
)
def test_programs_and_libraries_of_others(tmp_path: Path, file: str, content: bytes, listed: list[bool]) -> None:
    packages = tmp_path / "lib" / "python" / "site-packages"
    description = packages / "film-1.0.dist-info"
    description.mkdir(parents=True)
    (description / "METADATA").write_text("Metadata-Version: 2.1\nName: film\nVersion: 1.0\n", encoding="utf-8")
    (description / "RECORD").write_text(f"{file},,\nfilm/gone,,\n", encoding="utf-8")
    (packages / file).parent.mkdir(parents=True, exist_ok=True)
    (packages / file).write_bytes(content)
    assert list(bundled(distributions(path=[str(packages)]))) == [("film", file, is_program) for is_program in listed]
