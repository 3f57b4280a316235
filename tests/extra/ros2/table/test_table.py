"""The host test: each generated test of the table assembly, with the nodes of ROS 2."""

from __future__ import annotations

from typing import Any


def test_table(hri_case: Any) -> None:
    """The nodes hand over table legs in the simulated workshop; the same monitors watch."""
    hri_case.check(hri_case.run())
