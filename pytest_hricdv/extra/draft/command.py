"""`python -m pytest_hricdv init --from PACKAGE[:FUNCTION]`, `--ros2 "PACKAGE EXECUTABLE"`: a testbench, from code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.extra.draft.analysis import analyse
from pytest_hricdv.extra.draft.first_runs.session import Trial
from pytest_hricdv.extra.draft.first_runs.transitions import with_transitions
from pytest_hricdv.extra.draft.first_runs.trial import LATE, mend, tried
from pytest_hricdv.extra.draft.found.findings import Findings
from pytest_hricdv.extra.draft.found.nodes import ros_lines
from pytest_hricdv.extra.draft.launch_analysis import launch_findings, launched
from pytest_hricdv.extra.draft.node_analysis import ros_findings
from pytest_hricdv.extra.draft.reading.sources import DraftError
from pytest_hricdv.extra.draft.ros.executable import executable
from pytest_hricdv.extra.draft.writing.drafted import Draft, robot_name
from pytest_hricdv.extra.draft.writing.project import check, write
from pytest_hricdv.extra.recordings.observed import Observed
from pytest_hricdv.extra.ros2.packages import SourcePackage
from pytest_hricdv.skeleton.skeleton import name_like

NO_NODES = (
    "--from drafts no testbench for nodes of ROS 2, and lists what they say and hear: draft one with "
    '--ros2 "PACKAGE EXECUTABLE", or see docs/ros2.md'
)


@dataclass(frozen=True)
class Asked:
    """What a draft is asked for.

    Args:
        folder: where it is written.
        robot: name of the project; empty for that of the code.
        person: name of the person's agent.
        runs: whether first runs are made.
        recordings: of the real system, whose ranges it has.
    """

    folder: Path
    robot: str = ""
    person: str = "person"
    runs: bool = True
    recordings: tuple[Path, ...] = ()


def draft(package: str, asked: Asked) -> Iterator[str]:
    """Read the code, run a draft where nothing outside is touched, and write it; yields lines for the terminal.

    Raises:
        DraftError: there is no such code, or a file of the draft exists.
    """
    findings = analyse(package)
    findings = with_transitions(findings) if asked.runs else findings
    findings, observed = _observed(findings, asked, {})
    name = asked.robot or robot_name(findings)
    made = Draft(findings, name, asked.person, asked.folder.resolve(), observed=observed)
    check(made, asked.folder)
    yield from _read(findings)
    if findings.ros.nodes or findings.ros.endpoints:
        yield NO_NODES
    yield from _written(made, asked.folder, asked.runs)


def _observed(
    findings: Findings, asked: Asked, packages: Mapping[str, SourcePackage]
) -> tuple[Findings, Observed | None]:
    if not asked.recordings:
        return findings, None
    missing = next((path for path in asked.recordings if not path.exists()), None)
    if missing is not None:
        raise DraftError(f"--recording={missing}: there is no file or folder {missing.absolute()}")
    try:
        from pytest_hricdv.extra.draft.recorded import with_recordings  # the readers of bags need an extra
    except ModuleNotFoundError as error:
        extra = 'pip install "pytest-hricdv[ros2,traces]"'
        raise DraftError(f"--recording: {error.name} is needed to read bags; install the extras: {extra}") from None
    return with_recordings(findings, asked.recordings, packages)


def draft_node(node: str, asked: Asked) -> Iterator[str]:
    """The same for a node of ROS 2, "PACKAGE EXECUTABLE" or the path of its file.

    Raises:
        DraftError: there is no such executable of Python, or a file of the draft exists.
    """
    program = executable(node, Path.cwd().resolve())
    findings, start = ros_findings(program)
    findings, observed = _observed(findings, asked, program.packages)
    name = asked.robot or name_like(node.split()[-1].partition(":")[0].rpartition("/")[2].removesuffix(".py"))
    made = Draft(findings, name, asked.person, asked.folder.resolve(), ros=start, observed=observed)
    check(made, asked.folder)
    yield from _read(findings)
    is_runnable = all(problem.kind not in ("missing module", "hardware") for problem in findings.problems)
    yield from _written(made, asked.folder, asked.runs and is_runnable)


def draft_launch(file: str, asked: Asked) -> Iterator[str]:
    """The same for the nodes that a launch file starts, "FILE [name:=value ...]".

    Raises:
        DraftError: there is no such launch file, it cannot be read here, or it starts no node of Python; or a file of
            the draft exists.
    """
    start = Path.cwd().resolve()
    nodes = launched(file, start)
    findings, how, program = launch_findings(nodes, start)
    findings, observed = _observed(findings, asked, program.packages)
    name = asked.robot or name_like(nodes.file.name.partition(".")[0])
    made = Draft(findings, name, asked.person, asked.folder.resolve(), ros=how, observed=observed)
    check(made, asked.folder)
    yield f"{nodes.file}: starts {len(nodes.nodes)} processes, {len(how.nodes)} of them nodes of Python"
    yield from _read(findings)
    is_runnable = all(problem.kind not in ("missing module", "hardware") for problem in findings.problems)
    yield from _written(made, asked.folder, asked.runs and is_runnable)


def _written(made: Draft, folder: Path, runs: bool) -> Iterator[str]:
    if runs:
        made, trials = tried(made)
        yield from _came_of(trials, made)
    for name in write(made, folder):
        yield str(folder / name)


def _read(findings: Findings) -> Iterator[str]:
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


def _came_of(trials: tuple[Trial, ...], made: Draft) -> Iterator[str]:
    if made.dialogs:
        dialogs = "1 dialog leads" if len(made.dialogs) == 1 else f"{len(made.dialogs)} dialogs lead"
        yield f"first runs: {dialogs} further into the code than other runs: `@dialog_1` in models/{made.person}.asl"
    yield from (f"first runs: {problem.text}" for problem in made.findings.problems if problem.kind == LATE)
    for trial in trials:
        for effect in trial.effects:
            yield f"{effect.place}: {effect.text}"
        if trial.error:
            place = f"{trial.raised_at}: " if trial.raised_at is not None else ""
            yield f"first runs: {place}{' '.join(trial.error.split())}: the draft is not green; {mend(made, trial)}"
        elif trial.is_ended:
            yield (
                f"first runs: they take long, and were ended at {trial.tests} tests: so many has the draft; pytest.ini"
            )
        else:
            yield f"first runs: {trial.tests} tests, {trial.passed} of them passed before requirements were settled"
