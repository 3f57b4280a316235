"""A verification plan: what is to be shown, and how far it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from msgspec.structs import replace

from pytest_hricdv._base.record import Count, Names, Percent, PlainRecord
from pytest_hricdv.results.section import Section

PlanState = Literal["met", "waived", "open", "not checked", "failed"]
"""Of a goal; of a section, the last of this list that one of its goals has."""

STATES: tuple[PlanState, ...] = ("met", "waived", "open", "not checked", "failed")


class PlanFeature(PlainRecord, frozen=True, kw_only=True):
    """A goal of a plan, or a section, whose parts follow it with greater depth. The first part is the plan itself.

    Args:
        name: its path in the file, such as `safety.crush`.
        title: for people.
        owner: who answers for it; empty: whoever answers for the section.
        text: further words.
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

    def wanted(self) -> PlanFeature:
        """It without what it came to."""
        return replace(self, state="open", missing=(), goals=0, met=0)


PLAN: Section[tuple[PlanFeature, ...]] = Section("plan", tuple[PlanFeature, ...], ())
"""The parts of the verification plan, and how far they are; in a merged report, where all had the same one."""

SECTIONS = (PLAN,)
