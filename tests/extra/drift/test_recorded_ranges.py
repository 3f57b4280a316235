"""What a recording has that a testbench lacks is told, with the ranges that hold it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from pytest_hricdv.extra.drift.recorded import refined
from pytest_hricdv.extra.recordings.observed import Observed, observe
from pytest_hricdv.extra.recordings.recording import read
from tests.docs.page import blocks, write_files
from tests.extra.recordings.bags import write_mcap

CONFTEST = """
SAYS = {
    "order_tea": {"level_ml": Range(0.0, 1.0, "ml")},  # TODO: between which numbers?
    "order": {
        "level_ml": Range(100.0, 900.0, "ml"),  # as the cups are
        "cups": Range(1, 2),
    },
    "leave": {"level_ml": Range(0.0, 1.0)},
}
COMMANDS = {"order milk in_time": {"after_s": Range(0.5, 2.0, "s"), "cups": Range(1, 9), "level_ml": Range(200, 900)}}
"""


def observed(tmp_path: Path, first: int = 0) -> Observed:
    entries = [
        (10.0 * n, "/order", {"drink": "tea" if n else "milk", "level_ml": 150.0 + 10 * n, "cups": 1 + n % 3})
        for n in range(first, 12)
    ]
    file = write_mcap(tmp_path / "day.mcap", entries)
    return observe(read([file], lambda topic: True, lambda kind: None))


def test_a_range_with_a_question_is_replaced_and_others_are_only_widened(tmp_path: Path) -> None:
    after, told = refined(CONFTEST, observed(tmp_path))
    seen = "observed 150 to 260 (5 to 95 %: 160 to 250) in 12 messages of day.mcap; margin 10 %"
    whole = "observed 1 to 3 (5 to 95 %: 1 to 3) in 12 messages of day.mcap"
    assert after.splitlines()[2] == f'    "order_tea": {{"level_ml": Range(139.0, 271.0, "ml")}},  # {seen}'
    assert '        "level_ml": Range(100.0, 900.0, "ml"),  # as the cups are\n' in after
    assert f'        "cups": Range(1.0, 3.0),  # {whole}\n' in after
    assert '    "leave": {"level_ml": Range(0.0, 1.0)},\n' in after
    assert '"cups": Range(1, 9), "level_ml": Range(150.0, 900.0)}}' in after
    assert told[0] == f"conftest.py:3: level_ml: Range(0.0, 1.0, 'ml') to 139.0, 271.0: {seen}"
    assert len(told) == 3


def test_what_is_in_its_ranges_is_left_as_it_is(tmp_path: Path) -> None:
    after, _ = refined(CONFTEST, observed(tmp_path))
    assert refined(after, observed(tmp_path)) == (after, [])


def test_few_messages_are_marked(tmp_path: Path) -> None:
    after, _ = refined(CONFTEST, observed(tmp_path, 10))
    assert "# TODO: observed 250 to 260 in 2 messages of day.mcap; margin 10 %: too few to trust" in after


def test_a_file_that_is_no_python_is_left_as_it_is(tmp_path: Path) -> None:
    assert refined("SAYS = {", observed(tmp_path)) == ("SAYS = {", [])


@pytest.mark.slow
def test_an_update_with_a_recording_shows_the_difference(tmp_path: Path) -> None:
    write_files(blocks("tutorial.md"), tmp_path)
    file = write_mcap(
        tmp_path / "day.mcap", [(5.0 * n, "/order", {}) for n in range(12)] + [(70.0, "/joy", {"x": 1.0})]
    )
    command = [sys.executable, "-m", "pytest_hricdv", "init", "--update", "--recording", str(file)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "order: between messages of it, observed 5 to 5 s (5 to 95 %: 5 to 5) in 11 gaps of day.mcap" in done.stdout
    assert "/joy: 1 in day.mcap, and it is none of the testbench's messages" in done.stdout
    assert "served: no message of it in day.mcap" in done.stdout
    assert done.returncode in (0, 1), done.stderr
