"""Sessions in this process, as in `tests/plugin`, which loads once what does not take well to being loaded again."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.plugin.conftest import ENVIRONMENT, cache_folder

__all__ = ["cache_folder"]

HOST = """
def test_ward(hri_case):
    hri_case.check(hri_case.run())
"""


@pytest.fixture
def project(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch, cache_folder: Path) -> pytest.Pytester:
    """A project without a testbench; its runs see nothing of the run they are part of."""
    for name in (*ENVIRONMENT, "PYTEST_XDIST_WORKER"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache_folder))
    monkeypatch.setenv("XDG_STATE_HOME", str(cache_folder))
    pytester.makeini("[pytest]\naddopts = -p no:hypothesispytest\nhri_audit = off\n")
    pytester.makepyfile(test_ward=HOST)
    return pytester
