"""Suggestions in sessions of pytest."""

from __future__ import annotations

from pathlib import Path
from typing import Any, cast

import pytest

from pytest_hricdv.__main__ import main
from pytest_hricdv.extra.suggestion import suggest
from pytest_hricdv.extra.suggestion.options import SuggestionOptions
from pytest_hricdv.monitor import RequirementError, Vocabulary, load_requirements
from tests.docs.page import blocks, write_files


def test_the_help_teaches_to_accept(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["suggest", "--help"])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    assert "accepted_by" in text
    assert "What all runs do may be what all runs do wrong" in text


@pytest.mark.parametrize("date", ['"soon"', "true", "2026-11-26T10:00:00"])
def test_a_date_that_is_none_is_refused(tmp_path: Path, date: str) -> None:
    file = tmp_path / "requirements.toml"
    file.write_text(f'[S1]\ntitle = "x"\nformula = "always(on(a) -> b)"\naccepted_on = {date}\n', encoding="utf-8")
    with pytest.raises(RequirementError, match=r"'accepted_on' has to be a date, as 2026-11-26, got"):
        load_requirements(file, Vocabulary(signals={"b": bool}, messages={"a": {}}))


def test_suggestions_without_a_suite_are_refused_before_the_first_test(pytester: pytest.Pytester) -> None:
    result = pytester.runpytest_inprocess("--hri-suggest")
    result.stderr.fnmatch_lines(["ERROR: --hri-suggest: expected a suite to learn of, as --hri-suite=rl *"])
    assert result.ret == pytest.ExitCode.USAGE_ERROR


def test_without_the_feature_mutation_a_note_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(suggest, "offers", lambda role, name: ())
    suggester = suggest.Suggester(cast("Any", None), SuggestionOptions(), ())
    assert suggester._runs_of_faults(cast("Any", None)) == ({}, 0, "done")
    assert suggester._notes == ["not ranked by seeded bugs: the feature mutation is not installed"]


@pytest.mark.slow
def test_the_coffee_robot_has_suggestions_which_are_the_same_again(pytester: pytest.Pytester) -> None:
    write_files(
        (block for block in blocks("tutorial.md") if "/" not in block.name or "models" in block.name), pytester.path
    )
    few = ("-p", "no:xdist", "--hri-suite=rl", "--hri-tests=6", "--hri-audit=off", "test_coffee.py")
    arguments = (*few, "--hri-suggest", "--hri-suggest-anew")
    budget = ("--hri-suggest-faults=4", "--hri-suggest-further=4")
    first = pytester.runpytest_subprocess(*arguments, *budget)
    first.stdout.fnmatch_lines(["suggestions: * requirements, of * runs*", "[[]S1[]]", "formula = 'always(*"])
    again = pytester.runpytest_subprocess(*arguments, *budget)

    def shown(lines: list[str]) -> list[str]:
        return [line for line in lines if line.startswith(("title =", "formula =", "suggested ="))]

    assert shown(again.outlines) == shown(first.outlines)
    assert "recording" not in again.stdout.str()
