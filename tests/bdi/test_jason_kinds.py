"""Small programs by kind print what Jason's documentation and public tests have them print: a row a program."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import MultiAgentSystem

TABLE = Path(__file__).parent / "data" / "jason_kinds.txt"
"""A row: kind, what is printed (`b:` before the lines of another agent than a), and the program, parted by ` ## `.

The source of agent b follows that of a after ` --b-- `.
"""
ROWS = [tuple(line.split(" ## ")) for line in TABLE.read_text(encoding="utf-8").splitlines() if line]


@pytest.mark.parametrize(("kind", "printed", "program"), ROWS, ids=[f"{row[0]}-{i}" for i, row in enumerate(ROWS)])
def test_program_prints_what_jason_prints(kind: str, printed: str, program: str, tmp_path: Path) -> None:
    sources = program.split(" --b-- ")
    for name, source in zip("ab", sources, strict=False):
        (tmp_path / f"{name}.asl").write_text(source, encoding="utf-8")
    agents = " ".join(f"{name};" for name, _ in zip("ab", sources, strict=False))
    (tmp_path / "m.mas2j").write_text(f"MAS m {{ agents: {agents} }}", encoding="utf-8")
    lines = MultiAgentSystem.load(tmp_path / "m.mas2j").run(max_rounds=5_000).prints
    assert " | ".join(line.removeprefix("[a] ").replace("[b] ", "b: ") for line in lines) == printed
