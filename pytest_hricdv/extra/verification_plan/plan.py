"""`load_plan` reads a verification plan, sections and goals in TOML, and checks it before any test runs.

`VerificationPlanFeature` calls it. The plan is a list of `PlanItem`, which are also its records in reports.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta, Struct, ValidationError, convert, structs

from pytest_hricdv._base.input_file import MAX_TOML_BYTES, MalformedError, check_keys_of, from_toml, read_text
from pytest_hricdv._base.message import InputError, nearest, quote
from pytest_hricdv._base.record import Count, Names, Percent, PlainRecord
from pytest_hricdv.results.section import Section

PlanState = Literal["met", "waived", "open", "not checked", "failed"]
"""The state of a goal. A section has the last state of this list that one of its goals has."""

STATES: tuple[PlanState, ...] = ("met", "waived", "open", "not checked", "failed")


class PlanItem(PlainRecord, frozen=True, kw_only=True):
    """A goal or a section of a plan; what a section contains follows it with greater depth. The first item is the plan.

    Args:
        name: its path in the file, such as `safety.crush`.
        title: for people.
        owner: who is responsible; empty for the owner of the section.
        text: a longer description.
        depth: number of sections around it.
        requirements: the requirements that have to be checked and to pass.
        triggers: minimum number of triggers of each of these requirements.
        statements: minimum percentage of the reachable statements of the files.
        branches: minimum percentage of their branches.
        files: globs; empty for all of the code under test.
        cross: cross product -> percentage of its possible bins, over all suites.
        plans: agent -> percentage of its plans, over all suites.
        state: the state of the goal, or the worst in the section.
        missing: what it lacks, a sentence each.
        goals: number of goals in it.
        met: number of those that are met or waived.
    """

    name: str
    title: str
    owner: str = ""
    text: str = ""
    depth: Count = 0
    is_goal: bool = False
    requirements: Names = ()
    triggers: Count = 1
    statements: Percent | None = None
    branches: Percent | None = None
    files: Names = ()
    cross: Mapping[str, Percent] = {}
    plans: Mapping[str, Percent] = {}
    state: PlanState = "open"
    missing: Names = ()
    goals: Count = 0
    met: Count = 0

    def without_state(self) -> PlanItem:
        """The item without its state."""
        return structs.replace(self, state="open", missing=(), goals=0, met=0)


PLAN: Section[tuple[PlanItem, ...]] = Section("plan", tuple[PlanItem, ...], ())
"""The items of the verification plan with their states; in a merged report, where all had the same plan."""


class _Table(Struct, forbid_unknown_fields=True):
    """The keys of a section."""

    title: str = ""
    owner: str = ""
    text: str = ""


class _GoalTable(_Table, forbid_unknown_fields=True):
    """The keys of a goal."""

    requirements: Names = ()
    triggers: Annotated[int, Meta(ge=1)] = 1
    statements: Percent | None = None
    branches: Percent | None = None
    files: Names = ()
    cross: Mapping[str, Percent] = {}
    plans: Mapping[str, Percent] = {}


class PlanError(InputError):
    """A plan cannot be read, or names what does not exist; the message says where, and what was expected."""


_SHARES = ("cross", "plans")


@dataclass(frozen=True)
class Subjects:
    """What goals may name."""

    requirements: Collection[str]
    cross: Collection[str]
    agents: Collection[str]


def load_plan(path: Path, subjects: Subjects) -> tuple[PlanItem, ...]:
    """The plan of a file; its first item is a section with the file's title, which contains all others.

    Raises:
        PlanError: the file cannot be read, is not TOML, has no goal, or has a wrong one.
    """
    try:
        text = read_text(path, MAX_TOML_BYTES)
        tables = from_toml(text)
    except OSError as error:
        raise PlanError(f"{path}: {error.strerror or error}") from None
    except MalformedError as error:
        raise PlanError(f"{path}{error}") from None
    parts = tuple(_PlanReader(path, text, subjects).parts("", tables, 0))
    if len(parts) == 1:
        raise PlanError(f'{path}: no goal in this plan; expected a table each: [crush], requirements = ["R3"]')
    return parts


@dataclass(frozen=True)
class _PlanReader:
    path: Path
    text: str
    subjects: Subjects

    def parts(self, name: str, table: Mapping[str, Any], depth: int) -> Iterator[PlanItem]:
        """A section, which has tables, with its content; or a goal."""
        tables = {key: value for key, value in table.items() if isinstance(value, dict) and key not in _SHARES}
        is_goal = bool(name) and not tables
        kind = _GoalTable if is_goal else _Table
        try:
            keys = {key: value for key, value in table.items() if key not in tables}
            check_keys_of(kind, keys)
            read = convert(keys, kind)
        except (MalformedError, ValidationError) as error:
            what = "goal" if is_goal else "section, which contains tables"
            raise self._error(name, f"{str(error).removeprefix(': ')} of a {what}") from None
        title = read.title or name.rpartition(".")[2] or self.path.stem
        part = PlanItem(name=name, depth=depth, is_goal=is_goal, **{**structs.asdict(read), "title": title})
        if is_goal:
            self._check(part)
        yield part
        for key, value in tables.items():
            yield from self.parts(f"{name}.{key}" if name else key, value, depth + 1)

    def _check(self, goal: PlanItem) -> None:
        """See that a goal asks for something, and that it exists."""
        percents = (goal.statements, goal.branches)
        if not (goal.requirements or goal.cross or goal.plans or any(percent is not None for percent in percents)):
            raise self._error(goal.name, "a goal without criteria; expected requirements, statements, cross ...")
        for key, names, allowed in (
            ("requirements", goal.requirements, self.subjects.requirements),
            ("cross", goal.cross, self.subjects.cross),
            ("plans", goal.plans, self.subjects.agents),
        ):
            for item in names:
                if item not in allowed:
                    raise self._error(goal.name, f"{key}: there is no {quote(item)}{nearest(item, allowed)}")

    def _error(self, name: str, problem: str) -> PlanError:
        header = f"[{name}]"
        lines = [number for number, line in enumerate(self.text.splitlines(), 1) if line.strip().startswith(header)]
        return PlanError(f"{self.path}:{lines[0] if lines else 1}: {header if name else 'plan'}: {problem}")
