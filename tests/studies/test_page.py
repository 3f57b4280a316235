"""Pages that have measured figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies import page


def test_figures_take_the_place_of_those_of_their_command_only(tmp_path: Path) -> None:
    path = tmp_path / "page.md"
    path.write_text(
        "Text\n\n<!-- figures: study -->\n\nold\n\n<!-- figures: study --more -->\n\nkept\n", encoding="utf-8"
    )
    page.replace_figures(path, "study", "new")
    page.replace_figures(path, "study --more", "newer")
    expected = "Text\n\n<!-- figures: study -->\n\nnew\n\n<!-- figures: study --more -->\n\nnewer\n"
    assert path.read_text(encoding="utf-8") == expected
    with pytest.raises(ValueError, match="expected a line"):
        page.replace_figures(path, "another study", "new")
