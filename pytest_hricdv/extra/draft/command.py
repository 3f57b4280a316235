"""`python -m pytest_hricdv init --from PACKAGE[:FUNCTION]`: a draft of a testbench, made of code."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.drafted import Draft, robot_name
from pytest_hricdv.extra.draft.findings import Findings
from pytest_hricdv.extra.draft.project import check, write
from pytest_hricdv.extra.draft.ros_findings import ros_lines
from pytest_hricdv.extra.draft.running import with_transitions
from pytest_hricdv.extra.draft.trial import MEND, Trial, tried

NO_NODES = (
    "--from drafts no testbench for nodes of ROS 2: what they say and hear is listed here, and docs/ros2.md says how "
    "they are tested"
)


def draft(package: str, folder: Path, robot: str, person: str, runs: bool = True) -> Iterator[str]:
    """Read the code, run a draft where nothing outside is touched, and write it; yields lines for the terminal.

    Raises:
        DraftError: there is no such code, or a file of the draft exists.
    """
    findings = analyse(package)
    findings = with_transitions(findings) if runs else findings
    made = Draft(findings, robot or robot_name(findings), person, folder.resolve())
    check(made, folder)
    yield from _found(findings)
    if runs:
        made, trials = tried(made)
        yield from _came_of(trials)
    for name in write(made, folder):
        yield str(folder / name)


def _found(findings: Findings) -> Iterator[str]:
    machine = findings.machines[0] if findings.machines else None
    yield (
        f"read: {len(findings.heard)} messages heard, {len(findings.said)} said, "
        f"{len(machine.states) if machine else 0} states, {len(machine.transitions) if machine else 0} transitions, "
        f"{len(findings.waits)} waits"
    )
    if findings.ros.nodes or findings.ros.endpoints:
        yield from ros_lines(findings.ros)
        yield NO_NODES
    elif not findings.messages:
        yield (
            f"nothing was found that {findings.package} hears or says: its tests are nearly empty until "
            "conftest.py says what makes it act; the README lists what could not be read"
        )
    for problem in findings.problems:
        yield f"{problem.place}: {problem.text}" if problem.place is not None else problem.text


def _came_of(trials: tuple[Trial, ...]) -> Iterator[str]:
    for trial in trials:
        for effect in trial.effects:
            yield f"{effect.place}: {effect.text}"
        if trial.error:
            place = f"{trial.raised_at}: " if trial.raised_at is not None else ""
            yield f"first runs: {place}{' '.join(trial.error.split())}: the draft is not green; {MEND}"
        else:
            yield f"first runs: {trial.tests} tests, {trial.passed} of them passed before requirements were settled"
