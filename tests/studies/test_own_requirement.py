"""A requirement of one's own in a draft: which lines count as edited, and when it is checked."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import pytest

from studies.code_bases import code_bases, ros2
from studies.own_requirement import FOLDER, own_requirement, verdict


def report(*results: tuple[int, int]) -> dict[str, Any]:
    return {"tests": [{"requirements": {"OWN": {"triggers": t, "failures": ["at 3 s"] * f}}} for t, f in results]}


@pytest.mark.parametrize(
    ("results", "text"),
    [
        (((2, 0), (0, 0)), "passed in 1 of 2 tests"),
        (((2, 1), (1, 0)), "failed in 1 of 2 tests"),
        (((0, 0), (0, 0)), "not checked"),
    ],
)
def test_a_verdict_needs_a_test_that_triggers_it(results: tuple[tuple[int, int], ...], text: str) -> None:
    assert verdict("OWN", report(*results)) == text


def test_each_code_base_has_a_requirement_of_its_own(tmp_path: Path) -> None:
    keys = [*(code.key for code in code_bases(tmp_path)), *ros2.KEYS]
    assert {path.stem for path in FOLDER.glob("*.toml")} == set(keys)
    for key in keys:
        own = own_requirement(key)
        added = tomllib.loads("".join(edit.new for edit in own.edits if edit.file == "requirements.toml"))
        assert added[own.id]["formula"].startswith("always(")
