"""The tests that the list of behaviours names exist, and every optional feature is in it."""

from __future__ import annotations

import re

from pytest_hricdv.registry import FEATURES
from tests.docs.page import DOCS

TEXT = (DOCS / "behaviours.md").read_text(encoding="utf-8")


def test_each_named_test_file_exists() -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)`", TEXT)
    assert named
    assert [path for path in named if not (DOCS.parent / path).is_file()] == []


def test_each_feature_has_a_row() -> None:
    assert set(re.findall(r"^\| `(\w+)` \|", TEXT, re.MULTILINE)) == set(FEATURES)
