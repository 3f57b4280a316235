from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest


@pytest.fixture
def cell_msgs(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Packages of interfaces that can be imported, as those of a workspace that is sourced."""
    monkeypatch.syspath_prepend(Path(__file__).parent / "interfaces")
    yield
    for name in [each for each in sys.modules if each.partition(".")[0] == "cell_msgs"]:
        del sys.modules[name]


collect_ignore = ["table"]  # a project of its own, which test_table.py runs
