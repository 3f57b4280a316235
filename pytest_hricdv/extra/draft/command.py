"""`hricdv init --from PACKAGE[:FUNCTION]` and `--ros2 "PACKAGE EXECUTABLE"`: drafts a testbench from code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.draft.code.sources import DraftError
from pytest_hricdv.extra.draft.code_model import CodeModel
from pytest_hricdv.extra.draft.draft_analysis import CodeReader
from pytest_hricdv.extra.draft.node_analysis import analyse_node, with_state_topic
from pytest_hricdv.extra.draft.observe.observations import (
    Observations,
    is_observations,
    merge_observations,
    read_observations,
)
from pytest_hricdv.extra.draft.project.answers import find_edits, read_answers
from pytest_hricdv.extra.draft.project.draft import Draft, robot_name
from pytest_hricdv.extra.draft.project.files import check, write
from pytest_hricdv.extra.draft.record import add_command as add_command
from pytest_hricdv.extra.draft.ros.executable import find_executable
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
        recordings: files of `hricdv record`, and bags, from which it takes values.
        budget_s: processor time of the first runs.
    """

    folder: Path
    robot: str = ""
    person: str = "person"
    runs: bool = True
    recordings: tuple[Path, ...] = ()
    budget_s: float = BUDGET_S


@dataclass(frozen=True)
class FirstDraft:
    """A draft before its first runs.

    Args:
        lines: what was read, for the terminal.
        reread: reads the code again with what first runs show; None where nothing more can be known of it.
        is_runnable: whether first runs can be made.
    """

    draft: Draft
    lines: tuple[str, ...]
    reread: Reread | None = None
    is_runnable: bool = True


def draft(way: str, code: str, options: DraftOptions) -> Iterator[str]:
    """Read the code, run a draft where nothing outside is touched, and write it; yields lines for the terminal.

    Args:
        way: "from" or "ros2".
        code: PACKAGE[:FUNCTION]; "PACKAGE EXECUTABLE", or the path of a node's file.
        options: the draft's options.

    Raises:
        DraftError: there is no such code, it cannot be read here, or a file of the draft exists.
    """
    prepared = prepare(way, code, options)
    yield from prepared.lines
    yield from _write(prepared, options)


def prepare(way: str, code: str, options: DraftOptions) -> FirstDraft:
    """Read the code for a draft, and nothing more; see `draft`."""
    begin = _prepare_node if way == "ros2" else _prepare_package
    prepared = begin(code, options)
    made = replace(prepared.draft, earlier=read_answers(prepared.draft.folder))
    check(made, made.folder)
    lines = (*prepared.lines, *_summary(made.code))
    return replace(prepared, draft=made, lines=lines)


def _prepare_package(package: str, options: DraftOptions) -> FirstDraft:
    seen, bags = _observations(options.recordings)
    reader = CodeReader(package)

    def reread(more: Observations | None, faulty: frozenset[str]) -> CodeModel:
        both = merge_observations(part for part in (seen, more) if part is not None)
        return reader.model(both, faulty)

    model = reader.model(seen)
    if seen is not None and seen.modules and not seen.modules & {name.partition(".")[0] for name in model.modules}:
        raise DraftError(f"--recording: it is of {', '.join(sorted(seen.modules))}, and has nothing of {package}")
    if model.ros.nodes and not model.inputs:
        return _prepare_only_nodes(model, options)
    model = _with_recordings(model, bags, {})
    name = options.robot or robot_name(model)
    made = Draft(model, name, options.person, options.folder.resolve())
    has_nodes = bool(model.ros.nodes or model.ros.endpoints)
    return FirstDraft(made, (NO_NODES,) if has_nodes else (), reread)


def _prepare_only_nodes(model: CodeModel, options: DraftOptions) -> FirstDraft:
    """The draft of code that is a node of ROS 2; raises DraftError where it has several."""
    root, cwd = Path(model.root), Path.cwd().resolve()
    files = sorted({location.file for _, location in model.ros.nodes})
    paths = [
        str((root / file).relative_to(cwd)) if (root / file).is_relative_to(cwd) else str(root / file) for file in files
    ]
    if len(paths) > 1:
        ways = ", ".join(f"--ros2 {path}" for path in paths)
        raise DraftError(f"--from={model.package}: {len(paths)} nodes of ROS 2; draft one: {ways}")
    made = _prepare_node(paths[0], options)
    return replace(made, lines=(f"{files[0]} is a node of ROS 2: drafted as with --ros2 {paths[0]}", *made.lines))


def _prepare_node(node: str, options: DraftOptions) -> FirstDraft:
    program = find_executable(node, Path.cwd().resolve())
    model, start = analyse_node(program)
    model = _with_recordings(model, options.recordings, program.packages)
    name = options.robot or name_like(node.split()[-1].partition(":")[0].rpartition("/")[2].removesuffix(".py"))
    made = Draft(model, name, options.person, options.folder.resolve(), ros=start)

    def reread(seen: Observations | None, _: frozenset[str]) -> CodeModel:
        return with_state_topic(model, seen)

    is_runnable = all(problem.kind != "missing messages" for problem in model.problems)
    return FirstDraft(made, (), reread, is_runnable)


def _observations(paths: tuple[Path, ...]) -> tuple[Observations | None, tuple[Path, ...]]:
    """The observations of `record`'s recordings, and the other recordings: bags.

    Raises:
        DraftError: a recording cannot be read.
    """
    parts = []
    for path in paths:
        if is_observations(path):
            try:
                parts.append(read_observations(path))
            except (ValueError, OSError) as error:
                what = str(error).removeprefix(": ")
                raise DraftError(f"--recording={path}: {what}") from None
    bags = tuple(path for path in paths if not is_observations(path))
    return (merge_observations(parts) if parts else None), bags


def _with_recordings(model: CodeModel, recordings: tuple[Path, ...], packages: Mapping[str, Path]) -> CodeModel:
    if not recordings:
        return model
    missing = next((path for path in recordings if not path.exists()), None)
    if missing is not None:
        raise DraftError(f"--recording={missing}: there is no file or folder {missing.absolute()}")
    try:
        import mcap  # noqa: F401
        import rosbags  # noqa: F401

        from pytest_hricdv.extra.draft.recorded import with_recordings
    except ModuleNotFoundError as error:
        extra = 'pip install "pytest-hricdv[ros2,traces]"'
        raise DraftError(f"--recording: {error.name} is needed to read bags; install the extras: {extra}") from None
    return with_recordings(model, recordings, packages)


def _write(prepared: FirstDraft, options: DraftOptions) -> Iterator[str]:
    made = prepared.draft
    kept = find_edits(made.earlier)
    if kept:
        yield f"drafted before: what was changed since stays as it is, in {', '.join(kept)}"
    if options.runs and prepared.is_runnable:
        made, trials = settle(made, prepared.reread, options.budget_s, lambda line: print(visible(line), flush=True))
        for trial in trials:
            place = f"{trial.raised_at}: " if trial.raised_at is not None else ""
            yield from [f"first runs: {place}{trial.cause}: the draft is not green"] if trial.cause else []
    if made.hollow:
        yield f"hollow: {made.hollow}"
    for name in write(made, options.folder):
        yield str(options.folder / name)


def _summary(model: CodeModel) -> Iterator[str]:
    machine = model.machines[0] if model.machines else None
    yield (
        f"read: {len(model.inputs)} messages received, {len(model.outputs)} published, "
        f"{len(machine.states) if machine else 0} states, {len(machine.transitions) if machine else 0} transitions"
    )
    if model.ros.nodes or model.ros.endpoints:
        names = ", ".join(name or "without a name in the source" for name, _ in model.ros.nodes)
        yield f"nodes of ROS 2: {names}; {len(model.ros.endpoints)} topics, services and actions"
    for problem in model.problems:
        yield f"{problem.location}: {problem.text}" if problem.location is not None else problem.text


class InitCommand:
    """The command `hricdv init` for code."""

    def draft(self, asked: Mapping[str, str | None], options: Mapping[str, Any]) -> Iterator[str]:
        """Draft for the first way that is not None. Raises DraftError if it cannot."""
        way, code = next((way, code) for way, code in asked.items() if code is not None)
        return draft(way, code, DraftOptions(**options))

    def update(self, folder: Path) -> int:
        """Compare code and testbench of a project; returns the exit status."""
        from pytest_hricdv.extra.draft.update import update

        return update(folder)


INIT = InitCommand()
"""The command for `hricdv`."""
