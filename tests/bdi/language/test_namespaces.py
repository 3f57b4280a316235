"""Namespaces: sources included in one, local ones, variables for them; most lines are those that Jason 3.3 prints."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.language.parser import parse_program
from tests.bdi.models import system_of

MODULE = """
price(3). kind(hot).
big(X) :- price(X) & X > 2.
!init.
+!init <- .print("init in module").
+!g(T) : T == hot & kind(K) <- .print("hot ", T, K); ?kind(hot); ?big(B); .print(B); +seen(T); ?seen(W); .print(W).
+!g(T) <- .print("not hot ", T).
+!all <- .findall(X, price(X), L); .print(L); .findall(X, ::price(X), L2); .print(L2);
   .findall(X, this_ns::price(X), L4); .print(L4).
+!v <- X = hot; .print(X); ?kind(X); .print(same); +default::done(1).
+seen(X)[source(S)] <- .print("event ", X, S).
+!cond(X) : X = f(Y) <- .print(Y).
+!cond(X) <- .print(nocond(X)).
"""


def _prints(tmp_path: Path, **sources: str) -> list[str]:
    for name, text in sources.items():
        (tmp_path / f"{name}.asl").write_text(text, encoding="utf-8")
    return [line.removeprefix("[a] ") for line in system_of(tmp_path, a=sources["a"]).run().prints]


def test_source_included_in_a_namespace_has_its_own_beliefs_goals_and_plans(tmp_path: Path) -> None:
    agent = """
    { include("mod.asl", hall) }
    { include("mod.asl", comm) }
    price(100).
    !go.
    +!go <- .wait(50); !hall::g(hot); !comm::g(cold); !hall::all; !comm::v; ?done(D); .print(D);
       ?hall::price(P); .print(P); N = comm; ?N::price(P2); .print(P2);
       .findall(p(M,Q), M::price(Q), L3); .sort(L3, L4); .print(L4);
       -hall::price(_); +hall::price(7); !N::g(warm);
       for (Z::price(V) & V > 3) { .print(Z, " ", V) }; !hall::cond(f(3)); .print("end").
    +hall::price(X) <- .print("new price in hall ", X).
    """
    assert _prints(tmp_path, a=agent, mod=MODULE) == [
        "new price in hall 3",
        *["init in module"] * 2,
        *[
            "hot hothot",
            "3",
            "event hotself",
            "hot",
            "not hot cold",
            "[100]",
            "[3]",
            "[3]",
            "hot",
            "same",
            "1",
            "3",
            "3",
        ],
        "[p(comm,3),p(default,100),p(hall,3)]",
        "new price in hall 7",
        "not hot warm",
        "default 100",
        "hall 7",
        "3",
        "end",
    ]


@pytest.mark.parametrize(
    ("source", "prints"),
    [
        # A variable as the namespace of an event is bound to that of the event.
        ("!go. +!go <- +x::p(1); +p(2). +N::p(X) <- .print(N, X).", ["x1", "default2"]),
        # A bare variable stands for what is in the default namespace.
        ("!go. +!go <- !x::g. +!G <- .print(any). -!go <- .print(failed).", ["failed"]),
        ("!go. +!go <- !x::g. +!x::G <- .print(G).", ["g[source(self)]"]),
        ("!go. +!go <- !x::g(1). +!N::G <- .print(N, G).", ["xg(1)[source(self)]"]),
        # Goals, tests, updates and negation.
        ("!go. +!go <- N = x; +N::p(1); -N::p(1); ?not N::p(_); .print(gone).", ["gone"]),
        ("x::p(1). y::p(2). !go. +!go <- -+x::p(3); .findall(A, x::p(A), L); .print(L).", ["[3]"]),
        ("!go. +!go <- +x::~p(1); ?x::~p(A); .print(A); ?x::~B; .print(B).", ["1", "p(1)[source(self)]"]),
        ("!go. +!go <- ?N::nothing. -!go <- .print(failed).", ["failed"]),
        # Printed and read again as written.
        ('!go. +!go <- X = x::p(1); .print(X); .term2string(T, "x::~q"); .print(T).', ["x::p(1)", "x::~q"]),
        # Taken apart and built.
        ("!go. +!go <- x::p(1)[a] =.. L; .print(L); q(2) =.. [N,F,_,_]; .print(N, F).", ["[x,p,[1],[a]]", "defaultq"]),
        ("!go. +!go <- N = x; L =.. [N,~p,[1],[a]]; .print(L).", ["x::~p(1)[a]"]),
        # Blocks.
        ("{ begin namespace(x) } p(1). !g. +!g : p(A) <- .print(A, ::p). { end } p(2).", ["1x::p"]),
        ("{ begin namespace(x) } p(1). +!g <- ?default::p(A); .print(A). { end } p(2). !x::g.", ["2"]),
    ],
)
def test_namespaces_of_literals(tmp_path: Path, source: str, prints: list[str]) -> None:
    assert _prints(tmp_path, a=source) == prints


def test_local_namespace_is_known_in_its_own_source_only(tmp_path: Path) -> None:
    module = (
        "{ namespace(priv, local) } priv::p(1). q(2). +!g <- ?priv::p(X); .print(X); !priv::h. +!priv::h <- .print(h)."
    )
    agent = """
    { include("one.asl", one) }
    { include("one.asl", two) }
    !go.
    +!go <- !one::g; +priv::p(9); !two::g; .findall(N, N::p(_), L); .print(L); .count(N::q(_), C); .print(C).
    """
    assert _prints(tmp_path, a=agent, one=module) == ["1", "h", "1", "h", "[priv]", "2"]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("N::p(1).", "a.asl:1:1: expected a literal with a name as its namespace, found N::p"),
        ("{ namespace(x, privat) }", r"a.asl:1:1: expected namespace\(name\), or namespace\(name, local\), found"),
        ("{ begin dg(g) } p. { end }", r"a.asl:1:1: expected plans only in { begin dg\(g\) }"),
        ('!go. +!go <- N = "x"; +N::p(1).', None),
        ("!go. +!go <- +N::p(1).", None),
    ],
)
def test_mistakes_with_namespaces_say_where_they_are(tmp_path: Path, text: str, message: str | None) -> None:
    if message is None:
        (warning,) = system_of(tmp_path, a=text).run().warnings
        assert "name" in warning
        assert "a.asl:1:" in warning
        return
    with pytest.raises(BdiError, match=message):
        parse_program(text, "a.asl")
