"""What a test is worth whose verdict depends on the physics engine: never a pass."""

from __future__ import annotations

from collections.abc import Container

import pytest

from pytest_hricdv.execution.case import CaseResult
from pytest_hricdv.extra.engines.records import EngineComparison

__tracebackhide__ = True  # a failing test shows its author's own frames; pytest's --full-trace shows these, too

ENGINE_SENSITIVE = "engine-sensitive: "
"""Begins the reason why such a test is expected to fail."""


def unknown_on_any(result: CaseResult, known: Container[str]) -> tuple[str, ...]:
    """The requirements that a test violated on an engine, and that are not known to fail, or not as they did there."""
    beside = result.beside.unknown(known) if result.beside is not None else ()
    return tuple(dict.fromkeys((*result.unknown(known), *beside)))


def judge_engines(result: CaseResult, compared: EngineComparison, known: Container[str]) -> None:
    """End a test of which something depends on the engine, unless it failed on both: then that is what it is.

    Where margins explain it, the test ends as one that is expected to fail (`pytest.xfail`). A failure on one engine
    only that they do not explain is one, as is another course of the run.

    Args:
        result: on the first engine.
        compared: how it was on the second.
        known: requirements whose violations are known.
    """
    if not (compared.differences or compared.faults):
        return
    depends = {each.what for each in compared.differences}
    unknown = unknown_on_any(result, known)
    if any(each not in depends for each in unknown):
        return
    texts = [*(each.text for each in compared.differences), *(f"{compared.engine}: {each}" for each in compared.faults)]
    text = ENGINE_SENSITIVE + "; ".join(texts)
    if compared.faults or any(
        not each.tolerated and (each.what in unknown or each.what not in known) for each in compared.differences
    ):
        pytest.fail(text, pytrace=False)
    pytest.xfail(text)
