"""A file of requirements may have as many tables as the reference says, and not one more."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.monitor import RequirementError, Vocabulary, load_requirements

VOCABULARY = Vocabulary(signals={"distance": float})


def written(path: Path, count: int) -> str:
    formula = "always(distance > 1 -> distance > 0)"
    tables = (f'[R{number}]\ntitle = "Away"\nsource = "ISO"\nformula = "{formula}"\n' for number in range(count))
    path.write_text("".join(tables), encoding="utf-8")
    return str(path)


def test_the_limit_of_requirements_is_as_documented(tmp_path: Path) -> None:
    assert len(load_requirements(written(tmp_path / "most.toml", 1_000), VOCABULARY)) == 1_000
    with pytest.raises(RequirementError, match="expected at most 1000 requirements, and as many definitions"):
        load_requirements(written(tmp_path / "more.toml", 1_001), VOCABULARY)
    assert "1,000 requirements" in (Path(__file__).parents[2] / "docs" / "reference.md").read_text(encoding="utf-8")
