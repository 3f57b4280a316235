"""The study of localization: its planted faults fit the code of their testbenches, which changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.localization.faults import planted
from studies.localization.projects import HELD_OUT, PROJECTS, Project


@pytest.mark.parametrize("project", [*PROJECTS, *HELD_OUT], ids=lambda project: project.name)
def test_each_planted_fault_changes_a_text_that_stands_once(project: Project, tmp_path: Path) -> None:
    project.fill(tmp_path)
    faults = [*planted(project.name, project.map(tmp_path))]  # raises FaultError for one that does not fit
    assert len(faults) >= 8
    assert all(fault.text != fault.before for fault in faults)
    assert len({fault.id for fault in faults}) == len(faults)
