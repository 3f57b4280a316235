"""`hricdv init --from PACKAGE[:FUNCTION]`, `--ros2 "PACKAGE EXECUTABLE"`: a testbench, from code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.first_runs import FirstRuns
from pytest_hricdv.extra.draft.launch_analysis import analyse_launch, read_launch_file
from pytest_hricdv.extra.draft.node_analysis import analyse_node
from pytest_hricdv.extra.draft.observe.observations import (
    Observations,
    is_observations,
    merge_observations,
    read_observations,
)
from pytest_hricdv.extra.draft.observed import Observation
from pytest_hricdv.extra.draft.project.answers import find_edits, read_answers
from pytest_hricdv.extra.draft.project.draft import Draft, robot_name
from pytest_hricdv.extra.draft.project.files import check, write
from pytest_hricdv.extra.draft.record import add_command as add_command
from pytest_hricdv.extra.draft.ros.executable import find_executable
from pytest_hricdv.extra.draft.ros_model import ros_lines
from pytest_hricdv.extra.draft.settlement import BUDGET_S, Reread
from pytest_hricdv.extra.draft.settling import settle
from pytest_hricdv.skeleton.skeleton import name_like

NO_NODES = (
    "--from lists the topics, services and actions of ROS 2 nodes, and drafts no testbench for them: "
    'use --ros2 "PACKAGE EXECUTABLE"'
)


@dataclass(frozen=True)
class DraftOptions:
    """Options of a draft.

    Args:
        folder: where it is written.
        robot: name of the project; empty for that of the code.
        person: name of the person's agent.
        runs: whether first runs are made.
        recordings: of the real system, whose ranges it has.
        budget_s: processor time of the first runs.
    """

    folder: Path
    robot: str = ""
    person: str = "person"
    runs: bool = True
    recordings: tuple[Path, ...] = ()
    budget_s: float = BUDGET_S


def draft(package: str, options: DraftOptions) -> Iterator[str]:
    """Read the code, run a draft where nothing outside is touched, and write it; yields lines for the terminal.

    Raises:
        DraftError: there is no such code, or a file of the draft exists.
    """
    seen, bags = _observations(options.recordings)
    options = replace(options, recordings=bags)
    reader = CodeReader(package)

    def reread(more: Observations | None, faulty: frozenset[str]) -> CodeModel:
        both = merge_observations(part for part in (seen, more) if part is not None)
        return reader.model(both, faulty)

    model, observed = _with_recordings(reader.model(seen), options, {})
    name = options.robot or robot_name(model)
    made = _begin(Draft(model, name, options.person, options.folder.resolve(), observed=observed))
    yield from _summary(model)
    if model.ros.nodes or model.ros.endpoints:
        yield NO_NODES
    yield from _write(made, options, options.runs, reread)


def _observations(paths: tuple[Path, ...]) -> tuple[Observations | None, tuple[Path, ...]]:
    """What recordings of `record` have seen, and the other recordings: bags.

    Raises:
        DraftError: a recording cannot be read.
    """
    parts = []
    for path in paths:
        if is_observations(path):
            try:
                parts.append(read_observations(path))
            except (ValueError, OSError) as error:
                raise DraftError(f"--recording={path}: {error}") from None
    bags = tuple(path for path in paths if not is_observations(path))
    return (merge_observations(parts) if parts else None), bags


def _with_recordings(
    model: CodeModel, options: DraftOptions, packages: Mapping[str, Path]
) -> tuple[CodeModel, Observation | None]:
    if not options.recordings:
        return model, None
    missing = next((path for path in options.recordings if not path.exists()), None)
    if missing is not None:
        raise DraftError(f"--recording={missing}: there is no file or folder {missing.absolute()}")
    try:
        import mcap  # noqa: F401
        import rosbags  # noqa: F401

        from pytest_hricdv.extra.draft.recorded import with_recordings
    except ModuleNotFoundError as error:
        extra = 'pip install "pytest-hricdv[ros2,traces]"'
        raise DraftError(f"--recording: {error.name} is needed to read bags; install the extras: {extra}") from None
    return with_recordings(model, options.recordings, packages)


def draft_node(node: str, options: DraftOptions) -> Iterator[str]:
    """The same for a node of ROS 2, "PACKAGE EXECUTABLE" or the path of its file.

    Raises:
        DraftError: there is no such executable of Python, or a file of the draft exists.
    """
    program = find_executable(node, Path.cwd().resolve())
    model, start = analyse_node(program)
    model, observed = _with_recordings(model, options, program.packages)
    name = options.robot or name_like(node.split()[-1].partition(":")[0].rpartition("/")[2].removesuffix(".py"))
    made = _begin(Draft(model, name, options.person, options.folder.resolve(), ros=start, observed=observed))
    yield from _summary(model)
    is_runnable = all(problem.kind != "missing module" for problem in model.problems)
    yield from _write(made, options, options.runs and is_runnable)


def draft_launch(file: str, options: DraftOptions) -> Iterator[str]:
    """The same for the nodes that a launch file starts, "FILE [name:=value ...]".

    Raises:
        DraftError: there is no such launch file, it cannot be read here, or it starts no node of Python; or a file of
            the draft exists.
    """
    start = Path.cwd().resolve()
    nodes = read_launch_file(file, start)
    model, how, program = analyse_launch(nodes, start)
    model, observed = _with_recordings(model, options, program.packages)
    name = options.robot or name_like(nodes.file.name.partition(".")[0])
    made = _begin(Draft(model, name, options.person, options.folder.resolve(), ros=how, observed=observed))
    python = len(nodes.nodes) - len(how.left_out)
    yield f"{nodes.file}: starts {len(nodes.nodes)} processes, {python} of them nodes of Python"
    yield from _summary(model)
    is_runnable = all(problem.kind != "missing module" for problem in model.problems)
    yield from _write(made, options, options.runs and is_runnable)


def _begin(made: Draft) -> Draft:
    """The draft with what somebody has changed in the last one. Raises DraftError where it cannot be written."""
    made = replace(made, earlier=read_answers(made.folder))
    check(made, made.folder)
    return made


def _write(made: Draft, options: DraftOptions, runs: bool, reread: Reread | None = None) -> Iterator[str]:
    kept = find_edits(made.earlier)
    if kept:
        yield f"drafted before: what was changed since stays as it is, in {', '.join(kept)}"
    if runs:
        made, trials = settle(made, reread, options.budget_s, lambda line: print(visible(line), flush=True))
        yield from (
            f"first runs: {_place(trial)}{trial.cause}: the draft is not green" for trial in trials if trial.cause
        )
    if made.hollow:
        yield f"hollow: {made.hollow}"
    for name in write(made, options.folder):
        yield str(options.folder / name)


def _place(trial: FirstRuns) -> str:
    return f"{trial.raised_at}: " if trial.raised_at is not None else ""


def _summary(model: CodeModel) -> Iterator[str]:
    machine = model.machines[0] if model.machines else None
    yield (
        f"read: {len(model.inputs)} messages received, {len(model.outputs)} published, "
        f"{len(machine.states) if machine else 0} states, {len(machine.transitions) if machine else 0} transitions, "
        f"{len(model.waits)} waits"
    )
    if model.ros.nodes or model.ros.endpoints:
        yield from ros_lines(model.ros)
    elif not model.messages:
        yield (
            f"no messages found in {model.package}: its tests are nearly empty until conftest.py says what makes it "
            "act; QUESTIONS.md says what is missing"
        )
    for problem in model.problems:
        yield f"{problem.location}: {problem.text}" if problem.location is not None else problem.text


class InitCommand:
    """What `hricdv init` does with code."""

    def draft(self, asked: Mapping[str, str | None], options: Mapping[str, Any]) -> Iterator[str]:
        """Draft for "launch", "ros2" or "from", the first one that is not None. Raises DraftError where it cannot."""
        begin = {"launch": draft_launch, "ros2": draft_node, "from": draft}
        way, code = next((way, code) for way, code in asked.items() if code is not None)
        return begin[way](code, DraftOptions(**options))

    def update(self, folder: Path) -> int:
        """Compare code and testbench of a project; returns the exit status."""
        from pytest_hricdv.extra.draft.update import update

        return update(folder)


INIT = InitCommand()
"""For `hricdv`."""
