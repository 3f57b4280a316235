"""Parameters of which only some belong to the fast tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import pytest


def mostly_slow(cases: Mapping[str, Any] | Iterable[Any], few: int) -> list[Any]:
    """The cases as parameters: `few` of them, evenly spaced, are fast tests, and the others slow ones.

    Args:
        cases: id -> parameter, or parameters, of which tuples are several.
        few: how many are fast.
    """
    named = [*cases.items()] if isinstance(cases, Mapping) else [(None, case) for case in cases]
    fast = {number * len(named) // few for number in range(few)}
    return [
        pytest.param(
            *(case if isinstance(case, tuple) else (case,)), id=name, marks=() if number in fast else pytest.mark.slow
        )
        for number, (name, case) in enumerate(named)
    ]
