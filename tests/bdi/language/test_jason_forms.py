"""Forms of Jason's language that public models use: labels without names, namespaces, directives, quoted names."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError
from pytest_hricdv.bdi.language.errors import BdiSyntaxError
from pytest_hricdv.bdi.language.parser import parse_program, parse_term
from pytest_hricdv.bdi.language.terms import PlanTerm
from tests.bdi.models import system_of


def _prints(tmp_path: Path, **sources: str) -> list[str]:
    return system_of(tmp_path, **sources).run(max_rounds=1_000).prints


def test_empty_braces_are_an_empty_body(tmp_path: Path) -> None:
    assert parse_term("{}") == PlanTerm(())
    assert _prints(tmp_path, a="!go. +!go <- !do({}); .print(done). +!do(B) <- B.") == ["[a] done"]


def test_registered_function_without_an_answer_fails_its_goal(tmp_path: Path) -> None:
    source = '{ register_function("m.f", 1, "f") } f(1, 2). !go. +!go <- X = m.f(3); .print(X). -!go <- .print(failed).'
    assert _prints(tmp_path, a=source) == ["[a] failed"]


def test_registered_function_in_java_is_refused_with_advice() -> None:
    with pytest.raises(BdiSyntaxError, match=r"sinus is a function in Java; expected one of a rule"):
        parse_program('{ register_function("sinus") } !go.')


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("dg(g)", ["[a] one"]),
        ("bdg(g)", ["[a] one", "[a] two", "[a] end"]),
        ("ebdg(g)", ["[a] one", "[a] two", "[a] end"]),
        ("bc(g)", ["[a] one", "[a] two", "[a] end"]),
        ("bc(g, ebdg)", ["[a] one", "[a] two", "[a] end"]),
        ("smc(g, f)", ["[a] one", "[a] two", "[a] end"]),
        ("rc(g, m)", ["[a] one", "[a] two", "[a] end"]),
        ("omc(g, f, m)", ["[a] one", "[a] two", "[a] end"]),
    ],
)
def test_pattern_pursues_its_goal_as_long_as_it_is_committed(tmp_path: Path, pattern: str, expected: list[str]) -> None:
    source = (
        f"k(0). !go. +!go <- !g; .print(end). {{ begin {pattern} }} "
        "+!g : k(0) <- -+k(1); .print(one). +!g : k(1) <- .print(two); +g; .print(never). { end }"
    )
    assert _prints(tmp_path, a=source) == expected


def test_single_minded_goal_is_given_up_and_an_unmotivated_one_ends(tmp_path: Path) -> None:
    body = "+!g <- .print(try); .wait(10). { end }"
    plans = "+!go <- !g; .print(end). +!stop <- .wait(35);"
    result = system_of(tmp_path, a=f"!go. !stop. {plans} +f. {{ begin smc(g,f) }} {body}").run(max_rounds=1_000)
    assert (set(result.prints), result.ended) == ({"[a] try"}, "idle")
    assert "the intention is dropped" in result.warnings[-1]
    assert _prints(tmp_path, a=f"m. !go. !stop. {plans} -m. {{ begin rc(g,m) }} {body}")[-1] == "[a] end"


def test_maintained_goal_is_achieved_again_when_it_ends(tmp_path: Path) -> None:
    source = "!go. +!go <- -g[source(percept)]. { begin mg(g) } +!g <- .print(again); +g. { end }"
    assert _prints(tmp_path, a=source) == ["[a] again"]


def test_goals_of_a_sequence_are_adopted_one_after_the_other(tmp_path: Path) -> None:
    source = (
        "!go. +!go <- +t(1); +t(2). { begin sga(t(X), true, g(X)) } { end } "
        "+!g(X) <- .print(begin, X); .wait(20); .print(end, X)."
    )
    assert _prints(tmp_path, a=source) == ["[a] begin1", "[a] end1", "[a] begin2", "[a] end2"]


@pytest.mark.parametrize(
    ("directive", "message"),
    [
        ("ld", "unknown directive { begin ld }"),
        ("namespace(x, private)", "expected namespace(name), or namespace(name, local)"),
        ("dg", "expected 1 literals"),
        ("omc(g)", "expected 3 or 4 literals"),
        ("dg(X)", "expected 1 literals"),
        ("bc(g, nothing)", "unknown directive { begin nothing"),
    ],
)
def test_unknown_directive_is_refused_with_those_that_there_are(directive: str, message: str) -> None:
    with pytest.raises(BdiSyntaxError) as caught:
        parse_program(f"!g.\n{{ begin {directive} }} +!g. {{ end }}")
    assert message in str(caught.value)
    assert caught.value.line == 2


def test_source_beside_the_project_is_found_where_the_source_path_has_none(tmp_path: Path) -> None:
    from pytest_hricdv.bdi import MultiAgentSystem

    (tmp_path / "a.asl").write_text("!go. +!go <- .print(found).")
    (tmp_path / "m.mas2j").write_text('MAS m { agents: a; aslSourcePath: "src/agt"; }')
    assert MultiAgentSystem.load(tmp_path / "m.mas2j").run().prints == ["[a] found"]
    (tmp_path / "src" / "agt").mkdir(parents=True)
    (tmp_path / "src" / "agt" / "a.asl").write_text("!go. +!go <- .print(named).")
    assert MultiAgentSystem.load(tmp_path / "m.mas2j").run().prints == ["[a] named"]
    (tmp_path / "m.mas2j").write_text('MAS m { agents: b; aslSourcePath: "src/agt"; }')
    with pytest.raises(BdiError, match=r"no such file: .*src.agt.b\.asl"):
        MultiAgentSystem.load(tmp_path / "m.mas2j")
