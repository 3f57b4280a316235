"""Plans, rules and conditions as terms, taken apart, added and asked: most lines are those that Jason 3.3 prints."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiSyntaxError
from pytest_hricdv.bdi.language.parser import parse_program
from tests.bdi.models import system_of

FAILED = " -!go[error(E)] <- .print(failed, E)."


def _prints(tmp_path: Path, **sources: str) -> list[str]:
    return system_of(tmp_path, **sources).run().prints


@pytest.mark.parametrize(
    ("source", "prints"),
    [
        # Plans that are added where they stand: before the others, or after them.
        (
            "+!go <- +{ +!l <- .print(one) }; +>{ +!l <- .print(two) }; !l; +{ +!l <- .print(three) }; !l.",
            ["one", "three"],
        ),
        # Plans taken apart, and built.
        (
            "+!go <- P = { @lab[k] +!g(A) : v(A) <- .print(A) }; P =.. [L,T,C,B]; .print(L, T, C, B).",
            ["lab[k]{ +!g(A) }v(A){ .print(A) }"],
        ),
        ("+!go <- P = { +!g(A) <- .print(A); b(A) }; P =.. [L,T,C,B]; .print(L).", ["failedconstraint_failed"]),
        ("+!go <- B = { .print(hello) }; P =.. [lab, { +!g }, true, B]; .add_plan(P); !g.", ["hello"]),
        (
            "v(1). +!go <- P =.. [lab, { +!g(X) }, v(X), { .print(X) }]; .add_plan(P); !g(1); !g(2). "
            "-!g(X) <- .print(none(X)).",
            ["1", "none(2)"],
        ),
        (
            "@orig[a1] +!g(X) : X > 2 <- .print(orig, X). "
            "+!go <- .relevant_plans({+!g(_)}, [P|_]); P =.. [L,T,C,B]; .print(L, C); !g(3).",
            ["orig[a1](_19 > 2)", "orig3"],
        ),
        # Rules as terms, added and removed.
        (
            "b(1). b(2). +!go <- R = { a(X) :- b(X) & X > 1 }; .print(R); +R; ?a(Y); .print(Y); +{ c(Z) :- b(Z) }; "
            ".findall(Z, c(Z), L); .print(L); -R; ?a(W); .print(still).",
            ["{ a(X) :- (b(X) & (X > 1)) }", "2", "[1,2]", "failedtest_goal_failed"],
        ),
        ("+!go <- X = 3; R = { a(X) :- b(X) }; .print(R); +R; +b(3); ?a(3); .print(yes).", ["{ a(3) :- b(3) }", "yes"]),
        # Conditions that are believed, and asked.
        (
            "n(1, p(X) & X > 3, q). n(2, p(X) & X < 3, not p(1)). p(1). p(5). q. "
            "+!go <- for (n(I, C, D)) { if (C & D) { .print(I, yes) } else { .print(I, no) } }.",
            ["1yes", "2no"],
        ),
        ("n(p(X) | r). r. +!go : n(C) & C <- .print(ok). +!go <- .print(no).", ["ok"]),
        ("+!go <- +n(3 > 2); ?n(C); .print(C); ?C; .print(holds).", ["(3 > 2)", "holds"]),
    ],
)
def test_plans_rules_and_conditions_as_terms(tmp_path: Path, source: str, prints: list[str]) -> None:
    assert _prints(tmp_path, a=f"!go. {source}{FAILED}") == [f"[a] {line}" for line in prints]


def test_plan_for_a_state_that_never_comes_is_read_with_a_warning(tmp_path: Path) -> None:
    system = system_of(tmp_path, a="!go.\n^!go[state(executing)] <- .print(never).\n+!go <- .print(done).")
    (warning,) = system.warnings
    assert "a.asl:2:1: the state executing of a goal never comes here" in warning
    assert system.run().prints == ["[a] done"]


def test_missing_semicolon_is_refused_and_said_to_be_missing() -> None:
    for text in ("+!g <- .print(1)\n !x.", "+!g <- if (p) { a\n .print(1) }.", "+!g <- a\n b."):
        with pytest.raises(BdiSyntaxError, match="a ';' is missing between two statements") as caught:
            parse_program(text)
        assert caught.value.line == 2
