"""The page about two fidelities says what a report has."""

from __future__ import annotations

from typing import Any

import pytest
from studies.fidelities import FidelityError, fidelities, page


def run_of(name: str, one: tuple[str, float | None, int], other: tuple[str, float | None, int]) -> dict[str, Any]:
    verdicts = [dict(zip(("verdict", "margin", "triggers"), said, strict=True)) for said in (one, other)]
    beside = {"engine": "mujoco", "outcomes": ["completed", "refused"], "requirements": {"S4": verdicts[1]}}
    return {
        "id": name,
        "suite": "rl",
        "engine": "planar",
        "outcomes": ["completed"],
        "requirements": {"S4": verdicts[0]},
        "cross_check": beside,
    }


def test_what_differs_is_listed_with_both_margins() -> None:
    compared = fidelities(
        {
            "tests": [
                run_of("rl-1", ("Passed", 4.0, 1), ("Passed", 6.5, 2)),
                run_of("rl-2", ("Passed", 3.0, 1), ("Failed", -1.0, 1)),
                run_of("rl-3", ("NC", None, 0), ("NC", None, 0)),
            ]
        }
    )
    text = page(compared)
    assert "| S4 | 2 of 3 | 2 of 3 | 2.5 |" in text
    assert "| rl-2 | S4 | Passed by +3 | Failed by -1 |" in text
    assert "- S4: The planar force is" in text
    assert "Verdicts that agree: 2 of 3. Orders that end alike: 3 of 6." in text


def test_where_nothing_differs_the_page_says_so() -> None:
    assert page(fidelities({"tests": [run_of("rl-1", ("NC", None, 0), ("NC", None, 0))]})).endswith("None.\n")


def test_a_report_of_one_engine_is_refused() -> None:
    with pytest.raises(FidelityError, match="run it with --hri-engine=both"):
        fidelities({"tests": [run_of("rl-1", ("NC", None, 0), ("NC", None, 0)) | {"cross_check": None}]})
