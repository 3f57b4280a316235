"""Statements side by side: branches that run in turn, and the intention that waits for them."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.bdi.models import prints_of, system_of

PLANS = """
+!a <- .print(a1); .print(a2). +!b <- .print(b1); .print(b2); .print(b3). +!get(X) <- X = 3.
+!bad <- .print(bad); .fail. +!slow <- .wait(50); .print(slow). +!twice <- !a |&| !b.
+!mended <- .fail. -!mended <- .print(mended).
"""


@pytest.mark.parametrize(
    ("body", "prints"),
    [
        ("!a |&| !b; .print(on)", ["a1", "b1", "a2", "b2", "b3", "on"]),
        ("!a ||| !b; .print(on)", ["a1", "b1", "a2", "b2", "on"]),
        ("!get(X) |&| !get(Y); .print(X, Y)", ["33"]),
        ("X = 1 |&| .print(x) |&| +p(4); ?p(P); .print(X, P)", ["x", "14"]),
        ("!slow ||| !a; .print(on); .wait(90)", ["a1", "a2", "on"]),
        ("!slow |&| !a; .print(on)", ["a1", "a2", "slow", "on"]),
        ("!a |&| !bad; .print(no)", ["a1", "bad", "a2", "failed"]),
        ("!slow |&| !bad; .print(no)", ["bad", "failed"]),
        ("!bad ||| !slow; .print(on)", ["bad", "slow", "on"]),
        ("!bad ||| !bad; .print(no)", ["bad", "bad"]),
        ("!mended |&| !get(X); .print(X)", ["mended", "3"]),
        ("!missing |&| !slow; .print(no)", ["failed"]),
        ("!twice |&| .print(x); .print(on)", ["x", "a1", "b1", "a2", "b2", "b3", "on"]),
        ("!twice ||| .print(x); .print(on); .wait(90)", ["x", "on"]),
        ("!twice |&| !bad; .print(no)", ["bad", "failed"]),
        ("for (.range(I, 1, 2)) { .print(I) |&| .print(i) }; .print(on)", ["1", "i", "2", "i", "on"]),
        ("!slow |&| .drop_intention(go); .print(no)", []),
        ("!slow |&| .succeed_goal(go); .print(no)", []),
        ("!slow |&| .fail_goal(go); .print(no)", ["failed"]),
        ("!slow |&| .fail_goal(slow); .print(no)", ["failed"]),
        ("!slow |&| .succeed_goal(slow); .print(on)", ["on"]),
        ("B = { !a |&| .print(b) }; B; .print(on)", ["b", "a1", "a2", "on"]),
        ("B = { .print(b); !a ||| !slow }; B; .print(on)", ["b", "a1", "a2", "on"]),
        ("!x[hard_deadline(5)]; .print(on)", ["late", "on"]),
    ],
)
def test_branches_run_side_by_side(tmp_path: Path, body: str, prints: list[str]) -> None:
    rest = "+!x <- !slow |&| !slow. -!x <- .print(late)."
    assert prints_of(tmp_path, f"!go. +!go <- {body}. -!go <- .print(failed). {PLANS} {rest}") == prints


def test_failure_within_a_fork_within_a_fork_ends_both(tmp_path: Path) -> None:
    source = """
    !top. +!top <- !go; .print(on).
    +!go <- !x |&| !slow; .print(no).
    -!go <- .print(failed); .wait(90).
    +!x <- !slow |&| .fail.
    +!slow <- .wait(50); .print(slow).
    """
    assert prints_of(tmp_path, source) == ["failed", "on"]


def test_atomic_plan_has_no_branches(tmp_path: Path) -> None:
    result = system_of(tmp_path, a="!go. @l[atomic] +!go <- !a |&| !a. +!a <- .print(a).").run()
    assert result.prints == []
    assert "an atomic plan has no statements side by side" in result.warnings[0]
