"""The page of evidence, and the figures of README, are what the script writes."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies import evidence_page


def test_the_page_is_what_the_script_writes() -> None:
    assert evidence_page.EVIDENCE.read_text(encoding="utf-8") == evidence_page.evidence()


def test_the_page_is_short_and_has_two_tables() -> None:
    text = evidence_page.evidence()
    assert len(text.split()) <= 900
    assert text.count("| --- | --- |") == 2 or sum(line.startswith("| --- ") for line in text.splitlines()) == 2


def test_the_figures_of_the_readme_are_from_it() -> None:
    text = evidence_page.README.read_text(encoding="utf-8")
    assert evidence_page.readme(text) == text
    assert sum(line.startswith("| [") for line in text.splitlines()) == 4


def test_a_figure_that_is_not_on_its_page_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = evidence_page.QUOTED.read_text(encoding="utf-8").replace("0 of 5,192 runs have", "1 of 5,192 runs have")
    changed = tmp_path / "evidence.toml"
    changed.write_text(text, encoding="utf-8")
    monkeypatch.setattr(evidence_page, "QUOTED", changed)
    with pytest.raises(evidence_page.EvidenceError, match=r"false-alarms\.md has not the words"):
        evidence_page.evidence()
