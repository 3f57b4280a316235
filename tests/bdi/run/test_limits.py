"""Models that never end, or grow without end, end with an error that names the rule or plan and the limit."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.language import limits, syntax_tree, terms
from pytest_hricdv.bdi.run import system_run
from tests.bdi.models import system_of

WORK = r"does not come to an end within 100,000 steps"
SIZE = r"makes a term of more than 20,000 parts"
ANSWERS = r"has more than 20,000 answers"
TEXT = r"makes a string of more than 320,000 characters"
ENDLESS = {
    "a rule with an ever larger term": (
        "p(X) :- p(f(X)).\n!g.\n@a +!g <- ?p(1).",
        rf"a: rule p\(X\) \(.*a\.asl:1:1\), in plan @a \(.*a\.asl:3:11\): {WORK}",
    ),
    "in a context": (
        "p(X) :- p(f(X)).\n!g.\n@a +!g : p(1).",
        rf"a: rule p\(X\) \(.*a\.asl:1:1\), in the context of plan @a \(.*a\.asl:3:1\): {WORK}",
    ),
    "rules that call each other": (
        "p(X) :- q(f(X)). q(X) :- p(g(X)). !g. @a +!g <- ?p(1).",
        rf"a: rule [pq]\(X\) \(.*\), in plan @a \(.*\): {WORK}",
    ),
    "a rule with choices that all fail": (
        "d(1). d(2). d(3). d(4). d(5). d(6). d(7). d(8).\n"
        "p(A,B,C,D,E,F,G) :- d(A) & d(B) & d(C) & d(D) & d(E) & d(F) & d(G) & A > 9. !g. @a +!g <- ?p(A,B,C,D,E,F,G).",
        rf"rule p.*a\.asl:2:1.*in plan @a.*{WORK}",
    ),
    "rules with negation": (
        "p(X) :- not q(f(X)). q(X) :- not p(g(X)). !g. @a +!g <- ?p(1).",
        r"runaway recursion while looking for .*more than 60 queries within queries: in plan @a",
    ),
    "negation of an endless rule": ("p(X) :- p(f(X)). !g. @a +!g : not p(1).", rf"rule p.* plan @a .*{WORK}"),
    "a text concatenated with itself": (
        '!g("ab"). @a +!g(S) <- .concat(S,S,T); !g(T).',
        rf"in plan @a \(.*a\.asl:1:24\): {TEXT}",
    ),
    "a list concatenated with itself": ("!g([a,b]). @a +!g(S) <- .concat(S,S,T); !g(T).", rf"in plan @a .*: {SIZE}"),
    "a belief with an ever larger list": (
        "b([1,2]). !g. @a +!g <- ?b(L); .concat(L,L,M); -+b(M); !g.",
        rf"in plan @a .*: {SIZE}",
    ),
    "a loop over more than there is room for": (
        "!g. @a +!g <- for (.range(I,1,100000000)) { +b(I) }.",
        rf"in plan @a \(.*a\.asl:1:15\): {ANSWERS}",
    ),
    "all answers to a query": ("!g. @a +!g <- .findall(I,.range(I,1,100000000),L).", rf"in plan @a .*: {ANSWERS}"),
    "a set of answers": ("!g. @a +!g <- .setof(I,.range(I,1,100000000),L).", rf"in plan @a .*: {ANSWERS}"),
    "answers that are counted": ("!g. @a +!g <- .count(.range(I,1,100000000),N).", rf"in plan @a .*: {WORK}"),
    "a function that counts": ("!g. @a +!g <- X = .count(.range(I,1,100000000)).", rf"in plan @a .*: {WORK}"),
    "a range without the number wanted": ("!g. @a +!g <- .range(0,1,100000000).", rf"in plan @a .*: {WORK}"),
    "random numbers without end": ("!g. @a +!g <- ?.random(7,0).", rf"in plan @a .*: {WORK}"),
    "a goal with a doubled term": ("!g(x). @a +!g(X) <- !g(f(X,X)).", rf"in plan @a .*: {SIZE}"),
    "a goal with a doubled expression": ("!g. @a +!g <- !h(X). @b +!h(X) <- !h(X+X).", rf"in plan @b .*: {SIZE}"),
    "a goal with a doubled function": (
        "!g. @a +!g <- !h(X). @b +!h(X) <- !h(math.max(X,X)).",
        rf"in plan @b .*: {SIZE}",
    ),
    "doubling through unification": (
        "c(0,X,X). c(N,X,Y) :- N > 0 & c(N-1,f(X,X),Y). !g. @a +!g <- ?c(40,X,Y); .print(Y).",
        rf"in plan @a .*: ({SIZE}|{WORK})",
    ),
    "two doubled terms unified": (
        "c(0,X,X). c(N,X,Y) :- N > 0 & c(N-1,f(X,X),Y). eq(X,X). same(N) :- c(N,X,A) & c(N,Y,B) & eq(A,B)."
        "!g. @a +!g <- ?same(40).",
        rf"in plan @a .*: ({SIZE}|{WORK})",
    ),
    "a body that holds itself twice": (
        "!g({ .print(x) }). @a +!g(B) <- !g({ B; B }).",
        rf"in plan @a .*: {SIZE}",
    ),
    "annotations in all their orders": (
        "b[x(1),x(2),x(3),x(4),x(5),x(6),x(7),x(8),x(9),x(10)]. !g. "
        "@a +!g <- .findall(A,b[x(A),x(B),x(C),x(D),x(E),x(F),x(G),x(H)],L).",
        rf"in plan @a .*: {WORK}",
    ),
    "plans that add plans": (
        '!g(0). @a +!g(N) <- .concat("+!h(",N,") <- true.",P); .add_plan(P); !g(N+1).',
        rf"in plan @a .*: {WORK}",
    ),
    "beliefs round by round": (
        "!g(0). @a +!g(N) <- +b(N); !g(N+1).",
        r"after \d+ rounds, agents have more than 4,000 beliefs, most of them a: ",
    ),
    "goals that double": (
        "!g. @a +!g <- !!g; !!g; .print(x).",
        r"after \d+ rounds, agents have more than 4,000 messages, events and intentions, most of them a: ",
    ),
    "a list sorted again and again": (
        "!g. @a +!g <- .findall(I,.range(I,1,5000),L); !h(L). @b +!h(L) <- .sort(L,M); +n; -n; !h(M).",
        rf"in plan @b .*: {WORK}",
    ),
    "long prints": (
        "!g. @a +!g <- .findall(I,.range(I,1,5000),L); !h(L). @b +!h(L) <- .print(L); !h(L).",
        rf"in plan @b .*: {WORK}",
    ),
    "a text replaced by longer ones": (
        '!g("aa"). @a +!g(S) <- .replace(S,"a","aaaaaaaa",T); !g(T).',
        rf"in plan @a .*: {TEXT}",
    ),
    "a wait with an ever larger list": (
        "!g([1]). @a +!g(L) <- .wait(1); .concat(L,L,M); !g(M).",
        rf"in plan @a .*: {SIZE}",
    ),
    "a condition waited for": ("p(X) :- p(f(X)). !g. @a +!g <- .wait(p(1)).", rf"rule p.*in plan @a .*: {WORK}"),
    "a long list searched again and again": (
        "!g. @a +!g <- .findall(I,.range(I,1,5000),L); !h(L). @b +!h(L) <- .member(5000,L); +n; -n; !h(L).",
        rf"in plan @b .*: {WORK}",
    ),
    "sublists of a long list": (
        "!g. @a +!g <- .findall(I,.range(I,1,5000),L); .sublist([0],L).",
        rf"in plan @a .*: {WORK}",
    ),
}


@pytest.fixture
def low(monkeypatch: pytest.MonkeyPatch) -> None:
    """Limits that are reached in milliseconds; a test at the limits themselves is among the slow ones."""
    for module in (limits, system_run):
        monkeypatch.setattr(module, "MAX_WORK", 100_000)
    for module in (limits, terms, syntax_tree):
        monkeypatch.setattr(module, "MAX_SIZE", 20_000)
    monkeypatch.setattr(limits, "MAX_ANSWERS", 20_000)
    monkeypatch.setattr(system_run, "MAX_HELD", 4_000)


@pytest.mark.usefixtures("low")
@pytest.mark.parametrize(("source", "message"), ENDLESS.values(), ids=ENDLESS)
def test_model_without_end_ends_with_its_place_and_the_limit(tmp_path: Path, source: str, message: str) -> None:
    with pytest.raises(BdiError, match=message):
        system_of(tmp_path, a=source).run()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["a rule with an ever larger term", "a text concatenated with itself"])
def test_the_limits_themselves_are_reached(tmp_path: Path, name: str) -> None:
    with pytest.raises(BdiError, match=r"within 10,000,000 steps|more than 16,000,000 characters"):
        system_of(tmp_path, a=ENDLESS[name][0]).run()
