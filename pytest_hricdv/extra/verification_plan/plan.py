"""Verification plans: sections and goals in TOML, checked before any test runs, and their records in reports."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from msgspec.structs import replace

from pytest_hricdv._base.input_file import MAX_TOML_BYTES, MalformedError, from_toml, read_text
from pytest_hricdv._base.message import InputError, quote
from pytest_hricdv._base.record import Count, Names, Percent, PlainRecord
from pytest_hricdv._base.suggestion import nearest
from pytest_hricdv.results.section import Section

PlanState = Literal["met", "waived", "open", "not checked", "failed"]
"""The state of a goal. A section has the last state of this list that one of its goals has."""

STATES: tuple[PlanState, ...] = ("met", "waived", "open", "not checked", "failed")


class PlanItem(PlainRecord, frozen=True, kw_only=True):
    """A goal or a section of a plan; what a section contains follows it with greater depth. The first item is the plan.

    Args:
        name: its path in the file, such as `safety.crush`.
        title: for people.
        owner: who answers for it; empty: whoever answers for the section.
        text: a longer description.
        depth: in how many sections it is.
        is_goal: it is no section.
        requirements: that have to pass, and to be checked.
        triggers: at least so often, each of them.
        statements: per cent of those that can be reached, of the files.
        branches: the same.
        files: globs; empty: all of the code under test.
        cross: cross product -> per cent of its possible bins, over all suites.
        plans: agent -> per cent of its plans, over all suites.
        state: how far it is.
        missing: what it lacks, a sentence each.
        goals: how many goals it has, of a section.
        met: how many of them are met or waived.
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
        return replace(self, state="open", missing=(), goals=0, met=0)


PLAN: Section[tuple[PlanItem, ...]] = Section("plan", tuple[PlanItem, ...], ())
"""The items of the verification plan with their states; in a merged report, where all had the same plan."""


_TEXTS = ("title", "owner", "text")
_LISTS = ("requirements", "files")
_SHARES = ("cross", "plans")
_PERCENTS = ("statements", "branches")
_GOAL = (*_LISTS, *_SHARES, *_PERCENTS, "triggers")


class PlanError(InputError):
    """A plan cannot be read, or names what does not exist; the text says where, and what was expected."""


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
        """A section, which has tables, with what is in it; or a goal."""
        tables = {key: value for key, value in table.items() if isinstance(value, dict) and key not in _SHARES}
        is_goal = bool(name) and not tables
        allowed = (*_TEXTS, *_GOAL) if is_goal else _TEXTS
        for key in table.keys() - tables.keys():
            if key not in allowed:
                owner = "a goal" if is_goal else "a section, whose goals are its tables"
                raise self._error(name, f"{quote(key)} is not a key of {owner}{nearest(key, allowed)}")
        texts = {key: self._text(name, key, table) for key in _TEXTS if key in table}
        part = PlanItem(
            name=name,
            title=texts.get("title", name.rpartition(".")[2] or self.path.stem),
            owner=texts.get("owner", ""),
            text=texts.get("text", ""),
            depth=depth,
        )
        yield self._goal(part, table) if is_goal else part
        for key, value in tables.items():
            yield from self.parts(f"{name}.{key}" if name else key, value, depth + 1)

    def _goal(self, part: PlanItem, table: Mapping[str, Any]) -> PlanItem:
        name = part.name
        if not any(key in table for key in (*_SHARES, *_PERCENTS, "requirements")):
            raise self._error(name, "a goal without anything to show; expected requirements, statements, cross ...")
        requirements = self._names(name, "requirements", table, self.subjects.requirements)
        triggers = table.get("triggers", 1)
        if not isinstance(triggers, int) or isinstance(triggers, bool) or triggers < 1:
            raise self._error(name, f"triggers is {triggers!r}; expected a whole number from 1 on")
        return replace(
            part,
            is_goal=True,
            requirements=requirements,
            triggers=triggers,
            files=self._names(name, "files", table, None),
            statements=self._percent(name, "statements", table),
            branches=self._percent(name, "branches", table),
            cross=self._shares(name, "cross", table, self.subjects.cross),
            plans=self._shares(name, "plans", table, self.subjects.agents),
        )

    def _text(self, name: str, key: str, table: Mapping[str, Any]) -> str:
        value = table[key]
        if not isinstance(value, str):
            raise self._error(name, f"{key} is {value!r}; expected a text")
        return value

    def _names(self, name: str, key: str, table: Mapping[str, Any], allowed: Collection[str] | None) -> tuple[str, ...]:
        names = table.get(key, [])
        if not isinstance(names, list) or not all(isinstance(item, str) for item in names):
            raise self._error(name, f'{key} is {names!r}; expected a list of texts, such as ["R1"]')
        for item in names if allowed is not None else ():
            if item not in (allowed or ()):
                raise self._error(name, f"{key}: there is no {quote(item)}{nearest(item, allowed or ())}")
        return tuple(names)

    def _shares(self, name: str, key: str, table: Mapping[str, Any], allowed: Collection[str]) -> dict[str, float]:
        percents = table.get(key, {})
        if not isinstance(percents, dict):
            raise self._error(name, f"{key} is {percents!r}; expected names with per cent, such as {{ NAME = 80 }}")
        for item in percents:
            if item not in allowed:
                raise self._error(name, f"{key}: there is no {quote(item)}{nearest(item, allowed)}")
        return {item: self._percent(name, item, percents) or 0.0 for item in percents}

    def _percent(self, name: str, key: str, table: Mapping[str, Any]) -> float | None:
        value = table.get(key)
        if value is None:
            return None
        if not isinstance(value, int | float) or isinstance(value, bool) or not 0 <= value <= 100:
            raise self._error(name, f"{key} is {value!r}; expected per cent, from 0 to 100")
        return float(value)

    def _error(self, name: str, problem: str) -> PlanError:
        header = f"[{name}]"
        lines = [number for number, line in enumerate(self.text.splitlines(), 1) if line.strip().startswith(header)]
        return PlanError(f"{self.path}:{lines[0] if lines else 1}: {header if name else 'plan'}: {problem}")
