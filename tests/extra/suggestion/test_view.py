"""Suggestions in the terminal: four lines each, which the file of requirements takes as they are."""

from __future__ import annotations

from pathlib import Path

from pytest_hricdv.extra.suggestion.feature import VIEW, toml_lines
from pytest_hricdv.extra.suggestion.records import SUGGESTIONS
from pytest_hricdv.monitor import Vocabulary, load_requirements
from tests.report import sample, sample_sections

REPORT = sample.typed(sample.data(tests=2) | {"suggestions": sample_sections.SUGGESTIONS})
VOCABULARY = Vocabulary(messages={"order": {}, "served": {}})


def test_what_is_pasted_is_read(tmp_path: Path) -> None:
    result = SUGGESTIONS.of(REPORT)
    assert result is not None
    lines = toml_lines(result.suggestions[0])
    assert len(lines) == 4
    file = tmp_path / "requirements.toml"
    file.write_text("\n".join([*lines, 'accepted_by = "Jo"', "accepted_on = 2026-11-26"]), encoding="utf-8")
    [requirement] = load_requirements(file, VOCABULARY)
    assert (requirement.accepted_by, requirement.accepted_on) == ("Jo", "2026-11-26")
    assert requirement.suggested.startswith("12 triggers, decisive in 5 runs")


def test_the_terminal_has_what_they_rest_on_and_then_the_lines() -> None:
    assert [line.text for line in VIEW.lines(REPORT, 100)] == [
        "suggestions: 1 requirement, of 10 runs, in 12.5 s",
        "  9 candidates held in all runs; 2 not when runs continued, 5 redundant, 1 not shown",
        "  8 seeded bugs changed a run: 3 noticed by requirements and exceptions, 2 more by these suggestions",
        "  2 of 10 seeded bugs not tried: time ran out",
    ]
    assert [line.text for line in VIEW.findings(REPORT)][2] == "[S1]"


def test_a_suggestion_that_nobody_has_accepted_is_said() -> None:
    data = sample.data(tests=2)
    name = next(iter(data["requirements"]))
    data["requirements"][name]["suggested"] = "3 triggers"
    report = sample.typed(data)
    [line] = VIEW.lines(report, 100)
    assert line.text == f"{name} was suggested from runs, and nobody has accepted it: add accepted_by and accepted_on"
    data["requirements"][name]["accepted"] = "Jo on 2026-11-26"
    assert [*VIEW.lines(sample.typed(data), 100)] == []
