"""The reasoning cycle: percepts, sources, failures, the environment, and how runs end."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import BdiError, Environment, Structure
from tests.bdi.models import prints_of, system_of


class Switch(Environment):
    """A world in which agents can show each other lights and take them away."""

    def execute(self, agent: str, action: Structure) -> bool:
        if action.functor == "show":
            self.add_percept(agent, str(action.args[0]))
        elif action.functor == "hide":
            return self.remove_percept(agent, str(action.args[0]))
        elif action.functor == "explode":
            raise ValueError("boom")
        return action.functor != "refuse"


PROGRAMS = {
    "believing again from the same source is no event": (
        "!go. +!go <- +p; +p; +p[source(x)]; +p[source(x)]. +p[source(S)] <- .print(S).",
        [
            "self",
            "x",
        ],
    ),
    "deleting without a source deletes only what the agent itself told": (
        "p[source(bob)]. !go. +!go <- -p; ?p; .print(still); -p[source(bob)]; if (not p) { .print(gone) }.",
        ["still", "gone"],
    ),
    "unbound variable is greater than any number": (
        "!go. +!go <- if (X > 1000000) { .print(greater) }; if (not (Y < 3)) { .print(ok) }.",
        ["greater", "ok"],
    ),
    "first plan with an applicable context is taken": (
        "p(1). p(2). !g. +!g : p(X) & X > 1 <- .print(X). +!g <- .print(no).",
        ["2"],
    ),
    "arithmetic with what is no number has none as its value, without a value it stays": (
        '!go. +!go <- A = "a"; X = A + 1; .print(X); Z = Y + 1; .print(Z); Y = 2; .print(Z, -W, math.abs(A)).',
        ["NaN", "(Y+1)", "3(-W)math.abs(A)"],
    ),
    "sending to nobody fails": (
        "!go. +!go <- .send(ghost, tell, p). -!go[error_msg(M)] <- .print(M).",
        ["there is no agent ghost to send to"],
    ),
    "deep but finite rules are no problem": (
        "down(0). down(N) :- N > 0 & down(N - 1). !go. +!go : down(3000) <- .print(done).",
        ["done"],
    ),
    "event of a belief that is held carries only its new annotations": (
        "p. !go. +!go <- +p[w(1)]; +p[w(2),source(bob)]. +p[source(S)] <- .print(S). +p[w(X)] <- .print(w, X).",
        ["self", "w1", "bob"],
    ),
    "no plan is selected while an atomic intention waits": (
        "!x. !y. @l[atomic] +!x <- .wait(10); +seen; .print(x). +!y : seen <- .print(late). +!y <- .print(early).",
        ["x", "late"],
    ),
    "kinds of failure are named as jason names them": (
        """
    !go.
    +!go <- !t(1); !t(2); !t(3); !t(4); !t(5); !t(6).
    +!t(1) <- ?p(1).
    +!t(2) <- X = 1; X > 2.
    +!t(3) <- .nth(7, [a], X).
    +!t(4) <- !X.
    +!t(5) <- .send(ghost, tell, p).
    +!t(6) <- !nowhere.
    -!t(N)[error(E), code(C)] <- .print(E, " ", C).
    """,
        [
            "test_goal_failed p(1)",
            "constraint_failed (1 > 2)",
            "internal_action .nth(7,[a],X)",
            "body_var_without_value C<no-value>",
            "receiver_not_found .send(ghost,tell,p)",
            "no_relevant nowhere[source(self)]",
        ],
    ),
    "sums in initial beliefs and goals are computed": (
        "p(1 + 2)[w(3 - 4)]. big(X) :- p(X) & X > 2. !g(1 + 1). +!g(2) : p(3)[w(-1)] & big(3) <- .print(yes).",
        ["yes"],
    ),
}
"""What is shown -> the source of one agent, and what it prints."""


@pytest.mark.parametrize(("source", "prints"), PROGRAMS.values(), ids=PROGRAMS.keys())
def test_one_agent_prints(tmp_path: Path, source: str, prints: list[str]) -> None:
    assert prints_of(tmp_path, source) == prints


def test_percepts_present_at_the_start_are_perceived_before_the_first_goal(tmp_path: Path) -> None:
    environment = Environment()
    environment.add_percept("a", "light(7)")
    system = system_of(tmp_path, environment, a="!go. +!go : light(X) <- .print(saw, X).")
    assert system.run().prints == ["[a] saw7"]


def test_percept_the_agent_deleted_stays_deleted_until_its_percepts_change(tmp_path: Path) -> None:
    source = """
    !go.
    +!go <- -light(1)[source(percept)]; .wait(5); !look; show(light(2)); .wait(5); !look.
    +!look <- .findall(X, light(X), L); .sort(L, S); .print(S).
    """
    system = system_of(tmp_path, Switch(), a=source)
    assert system.run(percepts={"a": ["light(1)"]}).prints == ["[a] []", "[a] [1,2]"]


def test_action_that_raises_names_agent_plan_and_line(tmp_path: Path) -> None:
    system = system_of(tmp_path, Switch(), a="!go.\n@boom\n+!go\n   <- explode(now).")
    message = r"agent a, plan @boom \(.*a\.asl:4:7\): action explode\(now\) raised ValueError: boom"
    with pytest.raises(BdiError, match=message):
        system.run()


@pytest.mark.slow
@pytest.mark.parametrize(
    "source",
    [
        "p(X) :- p(X). !go. +!go : p(1) <- .print(no).",
        "p(N) :- p(N + 1). !go. +!go <- ?p(1).",
        "p :- not q. q :- not p. !go. +!go : p <- .print(no).",
    ],
    ids=["left-recursive", "endless", "through negation"],
)
def test_runaway_rule_is_an_error_that_names_it(tmp_path: Path, source: str) -> None:
    with pytest.raises(BdiError, match=r"runaway recursion while looking for [pq].*a\.asl:1:"):
        system_of(tmp_path, a=source).run()


def test_term_that_is_nested_too_deeply_to_be_printed_is_an_error(tmp_path: Path) -> None:
    source = "c(0). n(z). !go. +!go : c(3000) & n(X) <- .print(X). +!go : n(X) & c(N) <- -+n(s(X)); -+c(N + 1); !go."
    with pytest.raises(BdiError, match="a: terms nested too deeply"):
        system_of(tmp_path, a=source).run(max_rounds=100_000)


@pytest.mark.parametrize(
    "source",
    [
        "!w. +!w : not x <- !w.",
        "!w. !v. +!w : not x <- !w. +!v : not y <- !v.",
        "!w. +!w <- while (not x) { }.",
        "!w. +!w(N) : not x <- .wait(100); !w(N). +!w <- !w(1).",
    ],
    ids=["pure spin", "two spins", "empty loop", "polling"],
)
def test_agent_that_only_looks_again_ends_the_run_as_a_spin(tmp_path: Path, source: str) -> None:
    result = system_of(tmp_path, a=source).run()
    assert result.ended == "spin"
    assert result.rounds < 100


def test_unknown_agent_and_bad_round_limit_are_refused(tmp_path: Path) -> None:
    system = system_of(tmp_path, a="p.")
    with pytest.raises(ValueError, match="no agent 'b'"):
        system.run(percepts={"b": []})
    with pytest.raises(ValueError, match="max_rounds"):
        system.run(max_rounds=-1)
    with pytest.raises(KeyError):
        system.plan_labels("b")


def test_importing_the_package_does_not_import_lark() -> None:
    import subprocess
    import sys

    code = "import sys, pytest_hricdv.bdi; sys.exit('lark' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False, timeout=60).returncode == 0


@pytest.mark.parametrize("wait", [".wait({+done})", ".wait(done)", ".suspend"])
def test_atomic_plan_that_waits_for_its_own_agent_is_said_at_the_end(tmp_path: Path, wait: str) -> None:
    source = f"!x. !y. @l[atomic] +!x <- {wait}; .print(x). +!y <- +done; .resume(x)."
    (warning,) = system_of(tmp_path, a=source).run().warnings
    assert warning.startswith(
        f"a: {tmp_path / 'a.asl'}:1:27: the run ended while the atomic intention waited here, in "
    )


@pytest.mark.parametrize(
    ("rest", "printed"),
    [
        ("+!g. ^!g[state(S)] <- .print(S).", ["started", "go on", "finished"]),
        ("+!g <- .fail. -!g. ^!g[state(S)] <- .print(S).", ["started", "failed", "go on"]),
        ("-!g. ^!g[state(S)] <- .print(S).", ["started", "failed", "go on"]),
        ("+!g. ^!G[state(finished)] <- .print(G).", ["go on", "g", "go"]),
        ("+!g. ^!g[state(S)] : S == failed <- .print(S).", ["go on"]),
        ("+!g : true. ^!go[state(started)] <- .print(first).", ["first", "go on"]),
        ("+!g. !w. +!w <- .wait({^!g[state(finished)]}); .print(waited).", ["go on", "waited"]),
        ("+!g <- .add_plan({^!h[state(S)] <- .print(S)}); !!h. +!h.", ["go on", "started", "finished"]),
        ("+!g. ^!g[state(started)] <- .fail.", ["go on"]),
        (
            "+!g <- !h. +!h <- .fail. -!g. ^!h[state(S)] <- .print(h, S). ^!g[state(S)] <- .print(S).",
            ["started", "hstarted", "hfailed", "go on"],
        ),
    ],
)
def test_plans_say_what_becomes_of_a_goal(tmp_path: Path, rest: str, printed: list[str]) -> None:
    assert prints_of(tmp_path, f'!go. +!go <- !g; .print("go on"). {rest}') == printed
