"""`python -m pytest_hricdv init --from PACKAGE[:FUNCTION]`, `--ros2 "PACKAGE EXECUTABLE"`: a testbench, from code."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.drafted import Draft, robot_name
from pytest_hricdv.extra.draft.findings import Findings
from pytest_hricdv.extra.draft.project import check, write
from pytest_hricdv.extra.draft.ros_draft import ros_findings
from pytest_hricdv.extra.draft.ros_executable import executable
from pytest_hricdv.extra.draft.ros_findings import ros_lines
from pytest_hricdv.extra.draft.running import with_transitions
from pytest_hricdv.extra.draft.trial import Trial, mend, tried
from pytest_hricdv.skeleton.skeleton import name_like

NO_NODES = (
    "--from drafts no testbench for nodes of ROS 2, and lists what they say and hear: draft one with "
    '--ros2 "PACKAGE EXECUTABLE", or see docs/ros2.md'
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
    if findings.ros.nodes or findings.ros.endpoints:
        yield NO_NODES
    yield from _written(made, folder, runs)


def draft_node(asked: str, folder: Path, robot: str, person: str, runs: bool = True) -> Iterator[str]:
    """The same for a node of ROS 2, "PACKAGE EXECUTABLE" or the path of its file.

    Raises:
        DraftError: there is no such executable of Python, or a file of the draft exists.
    """
    findings, start = ros_findings(executable(asked, Path.cwd().resolve()))
    name = robot or name_like(asked.split()[-1].partition(":")[0].rpartition("/")[2].removesuffix(".py"))
    made = Draft(findings, name, person, folder.resolve(), ros=start)
    check(made, folder)
    yield from _found(findings)
    is_runnable = all(problem.kind not in ("missing module", "hardware") for problem in findings.problems)
    yield from _written(made, folder, runs and is_runnable)


def _written(made: Draft, folder: Path, runs: bool) -> Iterator[str]:
    if runs:
        made, trials = tried(made)
        yield from _came_of(trials, mend(made))
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
    elif not findings.messages:
        yield (
            f"nothing was found that {findings.package} hears or says: its tests are nearly empty until "
            "conftest.py says what makes it act; the README lists what could not be read"
        )
    for problem in findings.problems:
        yield f"{problem.place}: {problem.text}" if problem.place is not None else problem.text


def _came_of(trials: tuple[Trial, ...], mending: str) -> Iterator[str]:
    for trial in trials:
        for effect in trial.effects:
            yield f"{effect.place}: {effect.text}"
        if trial.error:
            place = f"{trial.raised_at}: " if trial.raised_at is not None else ""
            yield f"first runs: {place}{' '.join(trial.error.split())}: the draft is not green; {mending}"
        else:
            yield f"first runs: {trial.tests} tests, {trial.passed} of them passed before requirements were settled"
