"""The figures on suggestions: shares of faults, and requirements with the suggestions that are like them."""

from __future__ import annotations

from studies.suggestions.__main__ import COMMAND, PAGE, PROJECTS, figures
from tests.report import sample, sample_sections


def test_the_table_has_what_the_first_ten_notice() -> None:
    data = sample.data(tests=2)
    name = next(iter(data["requirements"]))
    suggestions = {**sample_sections.SUGGESTIONS}
    suggestions["suggestions"] = [{**sample_sections.SUGGESTIONS["suggestions"][0], "like": [name]}]  # type: ignore[index]
    text = figures({"table": sample.typed(data | {"suggestions": suggestions})})
    assert "| table | 10 | 9 | 2 | 1 | 8 | 3 | 5 (62 %) | 5 (62 %) |" in text
    assert f"| {name} | " in text
    assert "| S1 | After order, served follows within 9 s |" in text


def test_the_page_has_the_mark_below_which_the_figures_stand() -> None:
    assert f"<!-- figures: {COMMAND} -->" in PAGE.read_text(encoding="utf-8")
    assert [*PROJECTS] == ["coffee", "vacuum", "table"]
