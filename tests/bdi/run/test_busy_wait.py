"""Agents that wait busily: ``+!w : not x <- !w``."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bdi.models import system_of

WAITS = "!w. @look +!w : not x <- !w. @seen +!w <- .print(seen)."


def test_run_ends_as_soon_as_all_agents_only_wait_busily(tmp_path: Path) -> None:
    result = system_of(tmp_path, a=WAITS, b="!go. +!go <- +p; +q; +r.").run()
    assert result.ended == "spin"
    assert result.plans["a"] == ["look"] * result.rounds
    assert result.rounds < 6


@pytest.mark.parametrize(
    ("plan", "ended", "rounds"),
    [
        # A random number is drawn in each cycle, the second has no number to add to, the others come to the same state.
        ("+!w : .random(X) & X < 2 <- !w.", "round limit", 60),
        ("+!w : p(A) & A + 1 > 0 <- !w.", "idle", 1),
        ("+!w[source(self)] <- !w.", "spin", 42),
        ("@x[atomic] +!w <- !w.", "spin", 42),
    ],
)
def test_run_does_not_end_at_once_if_selecting_the_plan_again_may_have_an_effect(
    tmp_path: Path, plan: str, ended: str, rounds: int
) -> None:
    result = system_of(tmp_path, a=f"p(a). !w. {plan} +!w.").run(max_rounds=60)
    assert (result.ended, result.rounds) == (ended, rounds)
