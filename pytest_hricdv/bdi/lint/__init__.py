"""`lint` checks BDI models: it finds probable mistakes in models that can be loaded and run, without running them.

``hricdv lint`` prints the `Mistake`s that it returns. Example::

    from pytest_hricdv.bdi.lint import lint

    for finding in lint(["models_bdi/table_assembly.mas2j"]):
        print(finding)

A remark ``// lint: ignore NAME reason`` in the same line or in a comment line just above ignores a finding. The remark
``// lint: percepts name, ...`` declares percepts.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from os import PathLike
from pathlib import Path

from pytest_hricdv.bdi.actions import check_calls
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, Location
from pytest_hricdv.bdi.language.parser import read_program
from pytest_hricdv.bdi.language.project import beliefs_and_goals, read_project
from pytest_hricdv.bdi.language.syntax import ExternalAction, Program
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.lint import name_checks, plan_checks, portability_checks, variable_checks  # noqa: F401
from pytest_hricdv.bdi.lint.model import CHECKS, AgentModel, System
from pytest_hricdv.bdi.lint.model_builder import build_model, clear_cache, files_of, text_of

__all__ = ["CHECKS", "Mistake", "external_actions", "lint"]

_REMARK = re.compile(r"//\s*lint:\s*(?P<directive>\w+)(?P<rest>[^\n]*)")
_BAD_REMARK = "bad-remark"
_WHY_BAD_REMARK = "It is not read: it neither ignores a finding nor declares a percept."


@dataclass(frozen=True, slots=True)
class Mistake:
    """A probable mistake in a model.

    Args:
        check: the name of the check that found it.
        location: its place in the source.
        message: what is wrong.
        why: its consequence, in one sentence.
        source: the text of the file, which supplies the line to show.
    """

    check: str
    location: Location
    message: str
    why: str
    source: str

    def __str__(self) -> str:
        shown = BdiSyntaxError.at(f"{self.check}: {self.message}", self.location, self.source)
        return f"{shown}\n    {self.why}"


@dataclass(frozen=True, slots=True)
class _Remark:
    """A remark that justifies the findings of one check in one line."""

    file: str
    line: int
    name: str


def lint(paths: Iterable[str | PathLike[str]], percepts: Iterable[str] = ()) -> list[Mistake]:
    """Find probable mistakes in models.

    Args:
        paths: project files, whose agents are checked together, and source files of single agents.
        percepts: names of the percepts of the environment.

    Returns:
        The findings, sorted by file and line.

    Raises:
        BdiError: a file cannot be read.
    """
    clear_cache()
    declared = frozenset((name, None) for name in percepts)
    findings: dict[tuple[str, Location], Mistake] = {}
    for path in paths:
        agents, closed = _agents(Path(path))
        files = dict.fromkeys(file for agent in agents for file in files_of(agent))
        ignored: set[_Remark] = set()
        perceived: set[tuple[str, str | None]] = set(declared)
        for file in files:
            for finding in _read_remarks(file, ignored, perceived):
                findings[finding.check, finding.location] = finding
        # Agents that are created may send anything, as those may that a single source file does not know.
        closed = closed and not any(".create_agent" in agent.actions for agent in agents)
        system = System(agents, closed, frozenset(perceived))
        for check in CHECKS:
            for place, message in check.find(system):
                if _Remark(place.file, place.line, check.name) not in ignored:
                    text = text_of(place.file)
                    findings.setdefault((check.name, place), Mistake(check.name, place, message, check.why, text))
    return sorted(findings.values(), key=_position)


def external_actions(paths: Iterable[str | PathLike[str]]) -> list[str]:
    """The names of the external actions in models, which an environment has to implement.

    Raises:
        BdiError: a file cannot be read.
    """
    plans = tuple(plan for path in paths for agent in _agents(Path(path))[0] for plan in agent.plans)
    actions = [part.action for part in parts_of(plans) if isinstance(part, ExternalAction)]
    return sorted({action.functor for action in actions if isinstance(action, Structure)})


def _position(finding: Mistake) -> tuple[str, int, int, str]:
    place = finding.location
    return place.file, place.line, place.column, finding.check


def _agents(path: Path) -> tuple[tuple[AgentModel, ...], bool]:
    """The agents of a project or of a single source file, and whether there are no others."""
    if path.suffix != ".mas2j":
        return (build_model(path.stem, str(path), _check_calls(read_program(path))),), False
    try:
        project = read_project(path)
    except FileNotFoundError:
        raise BdiError(f"{path}: no such file") from None
    agents = []
    for entry in project.agents:
        program = _check_calls(read_program(entry.source, entry.location, project.text))
        beliefs, goals = beliefs_and_goals(entry)
        with_options = replace(program, beliefs=(*program.beliefs, *beliefs), goals=(*program.goals, *goals))
        agents.append(build_model(entry.name, str(entry.source), with_options))
    return tuple(agents), True


def _check_calls(program: Program) -> Program:
    check_calls(program)
    return program


def _read_remarks(file: str, ignored: set[_Remark], percepts: set[tuple[str, str | None]]) -> list[Mistake]:
    """Collect the remarks of a source file; returns findings for those that cannot be read."""
    text = text_of(file)
    bad: list[Mistake] = []
    check_names = {check.name for check in CHECKS}
    for number, line in enumerate(text.split("\n"), start=1):
        remark = _REMARK.search(line)
        if remark is None:
            continue
        words = remark["rest"].replace(",", " ").split()
        message = ""
        if remark["directive"] == "percepts" and words:
            percepts.update((word, file) for word in words)
        elif remark["directive"] != "ignore":
            message = "expected 'lint: ignore NAME why' or 'lint: percepts name, ...'"
        elif not words or words[0] not in check_names:
            message = f"expected the name of a check to ignore, one of {', '.join(sorted(check_names))}"
        elif len(words) == 1:
            message = f"expected a reason to ignore {words[0]}"
        else:
            alone = not line[: remark.start()].strip()
            ignored.add(_Remark(file, number + alone, words[0]))
        if message:
            place = Location(file, number, remark.start() + 1)
            bad.append(Mistake(_BAD_REMARK, place, message, _WHY_BAD_REMARK, text))
    return bad
