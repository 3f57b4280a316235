"""Tests that pages name exist, and every optional feature is in the list of behaviours."""

from __future__ import annotations

import re

from pytest_hricdv.registry import FEATURES
from tests.docs.page import DOCS

TEXT = (DOCS / "behaviours.md").read_text(encoding="utf-8")


def test_each_feature_has_a_row() -> None:
    assert set(re.findall(r"^\| `(\w+)` \|", TEXT, re.MULTILINE)) == set(FEATURES)


def test_each_test_file_that_a_page_names_exists() -> None:
    pages = [*DOCS.rglob("*.md"), *DOCS.parent.glob("*.md")]
    named = [path for page in pages for path in re.findall(r"`(tests/[\w/]+\.py)`", page.read_text(encoding="utf-8"))]
    assert len(named) > 50
    assert [path for path in named if not (DOCS.parent / path).is_file()] == []
