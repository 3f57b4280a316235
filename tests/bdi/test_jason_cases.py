"""Small programs print what Jason printed for them, 1.4.2 or 3.3; where they do not, the documentation says why."""

from __future__ import annotations

import json
import re
from collections import defaultdict
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem
from pytest_hricdv.bdi.run.environment import NoEnvironment

FILE = Path(__file__).parent / "data" / "jason_cases.json"
CASES: dict[str, dict[str, Any]] = json.loads(FILE.read_text(encoding="utf-8"))
"""Programs by name: their files, and the lines that either Jason printed; None where it refused the program."""
TABLE = Path(__file__).parents[2] / "docs" / "studies" / "jason.md"

DIFFERENT = (
    *("achieve_fail_remote", "ask_how", "belief_event_failure", "default_action"),
    *("error_kinds_of_internal", "string_concat"),
)
"""What comes otherwise than in both Jasons, on purpose: each has its row in the table of the two Jasons."""
STRICT = ("default_action",)
"""Of these, what comes as in both Jasons where actions that nobody implements fail: with `bdi run --strict-actions`."""


def _by_agent(lines: list[str]) -> dict[str, list[str]]:
    """The lines of each agent: in Jason, agents are threads, so that only the order within each is the program's."""
    own = defaultdict(list)
    for line in lines:
        agent = re.match(r"\[\w+\]", line)
        if line.strip():
            own[agent[0] if agent else ""].append(line.rstrip())
    return dict(own)


def _printed(name: str, folder: Path, environment: Environment | None = None) -> dict[str, list[str]] | None:
    """What the agents of a case print; None if it is refused."""
    for file, text in CASES[name]["files"].items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    try:
        return _by_agent(MultiAgentSystem.load(folder / "mas.mas2j", environment).run(max_rounds=10_000).prints)
    except BdiError:
        return None


def _expected(name: str) -> list[dict[str, list[str]]]:
    printed = (CASES[name]["jason_1_4_2"], CASES[name]["jason_3_3"])
    return [_by_agent(lines) for lines in printed if lines is not None]


@pytest.mark.parametrize("name", [name for name in CASES if name not in DIFFERENT])
def test_case_prints_what_a_jason_printed(name: str, tmp_path: Path) -> None:
    assert _printed(name, tmp_path) in _expected(name)


@pytest.mark.parametrize("name", DIFFERENT)
def test_case_that_is_said_to_differ_does(name: str, tmp_path: Path) -> None:
    assert _printed(name, tmp_path) not in _expected(name), "it is as in Jason now: take it from the list"


@pytest.mark.parametrize("name", STRICT)
def test_case_prints_what_a_jason_printed_where_actions_are_strict(name: str, tmp_path: Path) -> None:
    assert _printed(name, tmp_path, NoEnvironment()) in _expected(name)


def test_each_row_of_the_table_is_a_program_and_each_program_that_differs_has_its_row() -> None:
    rows = [line.split(" | ") for line in TABLE.read_text(encoding="utf-8").splitlines() if line.startswith("|")][2:]
    programs = [re.findall(r"`(\w+)`", row[-1]) for row in rows]
    assert all(programs)
    named = {name for names in programs for name in names}
    assert named <= CASES.keys()
    assert set(DIFFERENT) <= named
