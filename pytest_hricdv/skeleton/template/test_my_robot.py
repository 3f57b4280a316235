"""The host test: runs once for each generated test."""

from __future__ import annotations

from typing import Any


def test_my_robot(hri_case: Any) -> None:
    """One generated test."""
    hri_case.check(hri_case.run())
