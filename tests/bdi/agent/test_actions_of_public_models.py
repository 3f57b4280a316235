"""Internal actions that public models use, and what is said of those that there are not."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.lint import lint
from tests.bdi.models import system_of


@pytest.mark.parametrize(
    ("body", "prints"),
    [
        (".foreach(b(X), { .print(X) })", ["1", "2"]),
        (".loop(b(X) & X < 9, { -b(X) }); .print(.count(b(_)))", ["0"]),
        (".foreach(.member(X, [3, 4]), { .print(X); .print(x) })", ["3", "x", "4", "x"]),
        (".if_then_else(b(1), { .print(yes) }, { .print(no) })", ["yes"]),
        (".if_then_else(b(9), { .print(yes) }, { .print(no) })", ["no"]),
        (".if_then_else(b(9), { .print(yes) }); .print(on)", ["on"]),
        (".loop(b(X) & X > 1, { -b(X); .print(X) })", ["2"]),
        (".copy_term(f(X, Y, X), f(1, 2, A)); .print(A)", ["1"]),
        (".copy_term(f(X), Z); X = 1; Z = f(2); .print(X, Z)", ["1f(2)"]),
        ("Y = 3; .copy_term(f(Y, X), Z); Z = f(A, b); .print(A)", ["3"]),
        (".wait(1234); .time(H, M, S, Ms); .print(H, M, S); .print(Ms)", ["001", "234"]),
        (".verbose(2); .print(on)", ["on"]),
    ],
)
def test_action_does_what_jason_does(tmp_path: Path, body: str, prints: list[str]) -> None:
    result = system_of(tmp_path, a=f"b(1). b(2). !go. +!go <- {body}.").run()
    assert [line.removeprefix("[a] ") for line in result.prints] == prints


NEW = "!s. +!s <- .my_name(N); .print(up). +!hi[source(S)] <- .print(hi, S)."


@pytest.mark.parametrize(
    ("body", "prints"),
    [
        ('.create_agent(c, "b.asl"); .wait(9)', ["[c] up"]),
        ('N = c; .create_agent(N, "b.asl"); .send(N, achieve, hi); .wait(9)', ["[c] up", "[c] hia"]),
        ('.create_agent(c, "b.asl"); .broadcast(achieve, hi); .wait(9)', ["[c] up", "[c] hia"]),
        ('.create_agent(c, "b.asl"); .kill_agent(c); .wait(9)', []),
        ('.create_agent(c, "b.asl"); .wait(9); .all_names(L); .print(L)', ["[c] up", "[a] [a,c]"]),
        ('.create_agent(c, "b.asl"); .kill_agent(c); .all_names(L); .print(L)', ["[a] [a]"]),
        ('.create_agent(a, "b.asl")', ["[a] there is an agent a already"]),
        ('.create_agent(c, "b.asl"); .kill_agent(c); .send(c, achieve, hi)', ["[a] there is no agent c to send to"]),
        (".kill_agent(c)", ["[a] "]),
        ('for (.range(I, 1, 3)) { .concat(c, I, N); .create_agent(N, "b.asl") }', ["[c1] up", "[c2] up", "[c3] up"]),
        (".kill_agent(a); .print(no)", []),
    ],
)
@pytest.mark.parametrize("jitter", [0, 3])
def test_agents_are_created_and_killed(tmp_path: Path, body: str, prints: list[str], jitter: int) -> None:
    (tmp_path / "b.asl").write_text(NEW, encoding="utf-8")
    system = system_of(tmp_path, a=f"!go. +!go <- {body}. -!go[error_msg(M)] <- .print(M).")
    result = system.run(jitter=jitter, trace=jitter > 0)
    assert sorted(result.prints) == sorted(prints)
    assert jitter or result.prints == prints
    if "create_agent" in body:
        assert not [finding for finding in lint([tmp_path / "mas.mas2j"]) if "no agent" in str(finding)]


@pytest.mark.parametrize(
    ("call", "source", "message"),
    [
        ('.create_agent(c, "no.asl")', "", r"a\.asl:1:14: no such file: .*no\.asl"),
        ('.create_agent(c, "b.asl")', "+!g <- .prnt(x).", r"b\.asl:1:8: unknown internal action \.prnt"),
        ('.create_agent(c, "b.asl")', "+!g <- ", r"b\.asl:1:7: expected"),
    ],
)
def test_source_of_a_new_agent_that_cannot_be_read_ends_the_run(
    tmp_path: Path, call: str, source: str, message: str
) -> None:
    (tmp_path / "b.asl").write_text(source, encoding="utf-8")
    with pytest.raises(BdiError, match=message):
        system_of(tmp_path, a=f"!go. +!go <- {call}.").run()


@pytest.mark.parametrize(
    ("call", "advice"),
    [
        (".foreach(1)", "unknown internal action .foreach; use for (condition) { ... }"),
        (".if_then_else(1)", "use if (condition) { ... } else { ... }"),
        (".namespace_get_prop(ns, X)", "a belief in it, as ns::kind(local)"),
        (".join(1)", "write .fork(and, { ... }, { ... })"),
        (".sleep(3)", "use .wait(milliseconds)"),
        ("X = math.pow(2, 3)", "powers are written X ** Y"),
        ('gui.yes_no("ok?")', "gui.yes_no is an internal action in Java"),
        ("jia.move_to(X)", "an external action jia_move_to(...) of a Python environment"),
        (".prnt(x)", "did you mean .print"),
        ("X = math.sqr(4)", "did you mean math.sqrt"),
        (".qqq", "known are .abolish"),
    ],
)
def test_unknown_action_says_what_it_is_and_what_to_write_instead(tmp_path: Path, call: str, advice: str) -> None:
    with pytest.raises(BdiError) as caught:  # slips when they are loaded, what is elsewhere when it is called
        system_of(tmp_path, a=f"!go.\n+!go <- {call}.").run()
    assert "a.asl:2:" in str(caught.value)
    assert advice in str(caught.value)
    assert "value_by_rule" not in str(caught.value)


@pytest.mark.parametrize(
    "source",
    [
        '+!g <- gui.yes_no("ok?").',
        "+!g : jia.free(X, Y) <- act(X).",
        "near(X) :- jia.distance(X, D) & D < 3.",
        "+!g <- .list_files(s, L); .print(L).",
        "+!g <- X = my.fun(2) + 1; .print(X).",
        '{ register_function("myf.sin") } +!g <- .print(myf.sin(2)).',
    ],
)
def test_actions_of_java_are_read_and_announced_and_end_the_run_only_where_they_are_called(
    tmp_path: Path, source: str
) -> None:
    quiet = system_of(tmp_path, a=f"{source} !go. +!go <- .print(1).")
    (warning,) = quiet.warnings
    assert re.search(r"a\.asl:1:\d+: .*; a run ends where it is called$", warning)
    assert quiet.run().prints == ["[a] 1"]
    (finding,) = [finding for finding in lint([tmp_path / "mas.mas2j"]) if finding.check == "foreign-action"]
    assert warning.startswith(f"{finding.location}: {finding.message}")
    calling = "?near(1)" if "near" in source else "!g"
    with pytest.raises(BdiError, match=r"a\.asl:1:\d+: .*(Java|list_files)"):
        system_of(tmp_path, a=f"{source} !go. +!go <- {calling}.").run()
