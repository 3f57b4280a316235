"""The figures on suggestions: shares of faults."""

from __future__ import annotations

from studies.suggestions.__main__ import COMMAND, PAGE, PROJECTS, figures
from tests.report import sample, sample_sections


def test_the_table_has_what_the_first_ten_notice() -> None:
    data = sample.data(tests=2) | {"suggestions": sample_sections.SUGGESTIONS}
    text = figures({"table": sample.typed(data)})
    assert "| table | 10 | 9 | 2 | 1 | 8 | 3 | 5 (62 %) | 5 (62 %) |" in text


def test_the_page_has_the_mark_below_which_the_figures_stand() -> None:
    assert f"<!-- figures: {COMMAND} -->" in PAGE.read_text(encoding="utf-8")
    assert [*PROJECTS] == ["coffee", "vacuum", "table"]
