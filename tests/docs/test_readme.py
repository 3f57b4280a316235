"""The example in the README runs: its files replace those of the tutorial's project, which it is an extract of."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.docs.page import blocks, commands, differences, run, write_files


@pytest.mark.slow
def test_the_example_finds_the_bug(tmp_path: Path) -> None:
    first_run = next(number for number, block in enumerate(blocks("tutorial.md")) if "hri-tests" in block.text)
    write_files(blocks("tutorial.md")[:first_run], tmp_path)
    example = blocks("../README.md")
    assert write_files(example, tmp_path) == ["models/person.asl", "requirements.toml", "test_coffee.py"]
    ((command, shown),) = [each for block in example if block.kind == "console" for each in commands(block.text)]
    status, printed = run(command, tmp_path)
    assert not (found := differences(shown, status, printed)), found


def test_the_example_is_short() -> None:
    assert sum(len(block.text.splitlines()) for block in blocks("../README.md") if block.name) <= 15
