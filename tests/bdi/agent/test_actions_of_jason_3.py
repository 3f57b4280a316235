"""Internal actions that Jason 3.3 has beside those of 1.4.2, and what it printed for the same bodies."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

import pytest

from tests.bdi.models import prints_of, system_of

BEGINNING = "p(1). p(2). r(X) :- p(X) & X > 1. r(9)."
PLANS = """
+ev(X) <- .print(ev(X)). +sig(X)[source(S)] <- .print(sig(X),S). +provider(A,S)[source(Z)] <- .print(A," ",S," ",Z).
+!h(X) <- true. +!dn <- .print(d1); .done; .print(d2). +!dn2 <- !dn3; .print(no). +!dn3 <- .done(dn2); .print(no).
+!fut <- .wait(50); !hh; .print(no). +!hh <- .print(hh).
"""
PRINTED = [
    (".asserta(p(0)); .findall(X,p(X),L); .print(L)", ["[0,1,2]"]),
    (".assertz(p(5)); .findall(X,p(X),L); .print(L)", ["[0,1,2,5]"]),
    (".asserta(ev(1)); .wait(30)", ["ev(1)"]),
    (".assertz(ev(2)); .wait(30)", ["ev(2)"]),
    ("+p(7); .findall(X,p(X),L); .print(L)", ["[7,0,1,2,5]"]),
    (
        '.printf("%.2f and %s and %s|%5.1f|%-8s|%n",3.14159,abc,"x y",2,f(1)); .print(ok)',
        ["3.14 and abc and x y|  2.0|f(1)    |", "ok"],
    ),
    ('.printf("%s %s",1,1.5)', ["1.0 1.5"]),
    ('.printf("100%% %f",2)', ["100% 2.000000"]),
    ('.printf("plain")', ["plain"]),
    (".relevant_rules(r(_),L); .length(L,N); .print(N)", ["1"]),
    (".relevant_rules(r(_),L); .print(L)", ["[{ r(X) :- (p(X) & (X > 1)) }]"]),
    (".relevant_rules(zz(_),L); .print(L)", ["[]"]),
    (".relevant_plan({+!h(_)},P); .print(ok)", ["ok"]),
    (".relevant_plan({+!nope},P); .print(no)", ["failed ia_failed"]),
    (".remove_source_annot(a[source(b),c],X); .print(X)", ["a[c]"]),
    (".remove_source_annot([a[source(b)],1],X); .print(X)", ["[a,1]"]),
    (".internal_action(.print(a)); .print(yes)", ["yes"]),
    (".internal_action(a); .print(no)", ["failed ia_failed"]),
    (".namespace(default); .print(yes)", ["yes"]),
    (".namespace(nope); .print(no)", ["failed ia_failed"]),
    (".print_unifier", ["done"]),
    ("X = 1; .print_unifier", ["X=1", "done"]),
    (".nano_time(X); .number(X); .print(ok)", ["ok"]),
    (".version(V); .string(V); .print(ok)", ["ok"]),
    (".set_random_seed(3); .print(ok)", ["ok"]),
    (".signal({+sig(1)}); .wait(30); .print(after)", ["sig(1)self", "after"]),
    ('.signal("+sig(2)"); .wait(30); .print(after)', ["sig(2)self", "after"]),
    ("!dn; .print(after)", ["d1", "after"]),
    ("!dn2; .print(after2)", ["after2"]),
    ('.df_register("sell(book)"); .df_search("sell(book)",L); .print(L)', ["[a]"]),
    ('.df_register(buy(book)); .df_search("buy(book)",L); .print(L)', ["[a]"]),
    ('.df_search("nothing",L); .print(L)', ["[]"]),
    ('.df_deregister("sell(book)"); .df_search("sell(book)",L); .print(L)', ["[]"]),
    ('.df_subscribe("sell(x)"); .df_register("sell(x)"); .wait(100); .print(done)', ["a sell(x) df", "done"]),
    ('.df_subscribe("buy(book)","type"); .wait(100); .print(done2)', ["a buy(book) df", "done2"]),
    (".drop_future_intention(hh); .print(ok)", ["ok"]),
    ("!!fut; .wait(20); .drop_future_intention(hh); .wait(60); .print(ok)", ["ok"]),
    (".fork(and,{.print(a)},{.print(b)}); .print(c)", ["a", "b", "c"]),
    (".fork(or,{.wait(200);.print(a)},{.print(b)}); .print(c)", ["b", "c"]),
    (".rename_apart(f(X,Y),T); T = f(1,2); .print(T); X = 5; .print(X)", ["f(1,2)", "5"]),
    ("X = math.mean([1,2,3]); .print(X)", ["2"]),
]


@pytest.fixture(scope="module")
def printed(tmp_path_factory: pytest.TempPathFactory) -> list[list[str]]:
    """What one agent prints for each of the bodies."""
    calls = " ".join(f'.print("#"); !t{number};' for number in range(len(PRINTED)))
    plans = " ".join(
        f'+!t{number} <- {body}. -!t{number}[error(E)] <- .print("failed ", E).'
        for number, (body, _) in enumerate(PRINTED)
    )
    source = f'{BEGINNING} !run. +!run <- {calls} .print("#"). {plans} {PLANS}'
    lines = prints_of(tmp_path_factory.mktemp("bodies"), source)
    parts = ([*group] for between, group in groupby(["", *lines, ""], key=lambda line: line == "#") if not between)
    return list(parts)


@pytest.mark.parametrize("number", range(len(PRINTED)), ids=[body for body, _ in PRINTED])
def test_body_prints_what_jason_printed(printed: list[list[str]], number: int) -> None:
    assert printed[number + 1] == PRINTED[number][1]


def test_clone_has_the_beliefs_and_plans_of_its_original(tmp_path: Path) -> None:
    source = """
    p(1). !go.
    +!go <- +q(2); .clone("b"); .send(b, achieve, hello).
    +!hello[source(S)] <- .findall(X, p(X), L); ?q(Y); .my_name(N); .print(N, L, Y, S).
    """
    assert system_of(tmp_path, a=source).run().prints == ["[b] b[1]2a"]


def test_intentions_are_told_by_their_states(tmp_path: Path) -> None:
    source = """
    !go. !waits. !stops(1). !event.
    +!go <- .wait(10); .findall(S, .intention(_, S), L); .print(L); .intention(I, S1, P, current); .length(P, N);
       .print(S1, N).
    +!waits <- .wait(300).
    +!stops(X) <- !inner(X).
    +!inner(X) <- .suspend.
    +!event <- .wait("+never").
    """
    states = '[running,waiting[reason(wait(2)[time(300)])],waiting[reason(wait(4)["+never"])],suspended]'
    assert prints_of(tmp_path, source) == [states, "running1"]


def test_plans_and_rules_are_listed_as_written(tmp_path: Path) -> None:
    source = """
    r(X) :- p(X) & X > 1.
    !go. +!go <- .list_plans({+!h(_)}); .list_rules.
    @l1 +!h(X) : X > 1 <- act(X).
    +!h(_).
    """
    first, second, rule = prints_of(tmp_path, source)
    assert first == "@l1 +!h(X) : (X > 1) <- act(X)."
    assert "+!h(_" in second
    assert rule == "r(X) :- (p(X) & (X > 1))"


def test_what_would_write_a_file_or_set_a_seed_is_ignored_with_a_warning(tmp_path: Path) -> None:
    calls = '.save_agent("a.out"); .save_stats; .set_random_seed(3)'
    result = system_of(tmp_path, a=f"!go. +!go <- {calls}; .print(on).").run()
    assert result.prints == ["[a] on"]
    assert [warning.partition("ignored: ")[2] for warning in result.warnings] == calls.split("; ")
    assert not (tmp_path / "a.out").exists()
