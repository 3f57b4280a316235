"""How a test went on a second physics engine, as a report has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from msgspec import Struct

from pytest_hricdv._base.record import Count, Names, Number, PlainRecord
from pytest_hricdv.results.section import TestSection


class OtherVerdict(PlainRecord, frozen=True, kw_only=True):
    """A requirement on the second engine: verdict, margin, and how often it was triggered."""

    verdict: Literal["Passed", "Failed", "NC"]
    margin: Number | None
    triggers: Count


class EngineDifference(PlainRecord, frozen=True, kw_only=True):
    """What depends on the engine: a requirement, or how the run or its interactions ended.

    Args:
        what: the name of the requirement, `end`, or what the testbench calls the interactions.
        text: how it was on which engine, for people.
        tolerated: margins differ by no more than the testbench allows engines to differ.
    """

    what: str
    text: str
    tolerated: bool


class EngineComparison(PlainRecord, frozen=True, kw_only=True):
    """The same test on a second engine.

    Args:
        engine: its name.
        outcomes: how each interaction ended there, in order.
        record_sha256: of its run.
        requirements: requirement -> how it went there.
        faults: what is wrong with that run beside its requirements, a sentence each.
        differences: what depends on the engine.
    """

    engine: str
    outcomes: Names
    record_sha256: str
    requirements: Mapping[str, OtherVerdict]
    faults: Names
    differences: tuple[EngineDifference, ...]


BESIDE: TestSection[EngineComparison | None] = TestSection("beside", EngineComparison | None, None, identifies=True)
"""How the same test went on a second engine, in a session in which engines check each other."""

TEST_SECTIONS = (BESIDE,)


def further_engines(test: Struct) -> Names:
    """Of a test that ran on a second engine."""
    beside = BESIDE.of(test)
    return (beside.engine,) if beside is not None else ()
