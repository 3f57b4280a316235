"""The study of localization: its planted faults fit the code of their testbenches, which changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from studies.localization import tables
from studies.localization.faults import planted
from studies.localization.measuring import Measured
from studies.localization.projects import HELD_OUT, PROJECTS, Project
from studies.localization.ranking import Hit


@pytest.mark.parametrize("project", [*PROJECTS, *HELD_OUT], ids=lambda project: project.name)
def test_each_planted_fault_changes_a_text_that_stands_once(project: Project, tmp_path: Path) -> None:
    project.fill(tmp_path)
    faults = [*planted(project.name, project.map(tmp_path))]  # raises FaultError for one that does not fit
    assert len(faults) >= 8
    assert all(fault.text != fault.before for fault in faults)
    assert len({fault.id for fault in faults}) == len(faults)


@pytest.mark.parametrize(
    ("runs", "said"), [(None, "that were tried"), (40, "that were tried with `--hri-diagnose=40`")]
)
def test_the_figures_say_of_how_many_faults_and_runs_they_are(runs: int | None, said: str) -> None:
    hit, miss = Hit(function=1.0, statements=(0.0, 1.0, 1.0)), Hit(function=0.0, statements=(0.0, 0.0, 1.0))
    measured = [
        Measured(project="coffee", fault=name, kind=kind, code="", hits=dict.fromkeys(tables.RANKINGS, found))
        for name, kind, found in (("a", "planted", hit), ("b", "wait skipped", miss))
    ]
    text = tables.text([*measured, Measured(project="coffee", fault="c", kind="planted", code="")], runs)
    assert text.startswith(f"Of 3 faults {said}, 2 make tests fail (2 of coffee):")
    assert "| places of a cause | 50 % | 0 % | 50 % | 100 % |" in text
    assert "| mutants | 1 | 0 % | 0 % | 0 % | 100 % | 0 % | 100 % |" in text
