"""Runs of small systems: as recorded when the engine was last compared with others, and the same with a trace."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem, Result, Structure
from tests.bdi.generated import systems
from tests.bdi.models import system_of
from tests.bdi.test_programs import PROGRAMS, REFERENCE_PROGRAMS

RECORDED = Path(__file__).parent / "recorded_runs.json"
"""The runs of :data:`CASES`; written by `python -m tests.bdi.run.test_runs`, which is only right if they may change."""
BRIEF = settings(suppress_health_check=list(HealthCheck))


class World(Environment):
    """A world in which an action can fail, and another one shows the agent something."""

    def execute(self, agent: str, action: Structure) -> bool:
        if action.functor == "act":
            self.add_percept(agent, f"q({action.args[0]})")
            self.add_percept("b", "p1")
        return action.functor != "refuse"


ENVIRONMENTS = {"plain": Environment, "world": World}
MANY_UPDATES = "; ".join(f"-+p({number})" for number in range(12))
_ALONE = "+x[source(S)] <- .wait(0.2); .send(S, tell, q(9)). +y <- .print(y)."
_OTHER = "+p. !w. +!w <- .wait(1); do(9)."
CASES = {
    "calls in a circle": {"a": "!a. +!a <- !b. +!b <- !c. +!c <- !a."},
    "goals apart": {"a": "!a. +!a <- !!a; !b. +!b.", "b": "!a. +!a <- !!a; !b. +!b."},
    "calls in a circle with a failure plan": {"a": "!a. +!a <- !b. +!b <- !c. +!c <- !a. -!a <- .print(never)."},
    "update beside an update": {"a": "!a. +!a <- +p; .send(b, tell, q); .wait(0).", "b": "!b. +!b <- +p."},
    "wait after a message": {
        "a": "!a. +!a <- .send(b, tell, q); .wait(0.1); .send(b, tell, r).",
        "b": "+q <- .wait(0.2); +p; +s.",
    },
    "message and updates": {
        "a": "!a. +!a <- .send(b, tell, q); +p; .send(b, tell, r); +s.",
        "b": "+q <- +x; +y; .send(a, tell, z).",
    },
    "message and actions": {"a": "!a. +!a <- .send(b, tell, q); do(1); do(2).", "b": "+q <- !c. +!c <- +x; do(3)."},
    "message before the sender's turn": {
        "b": "+q <- +x; .send(a, tell, z). +r <- do(r).",
        "a": "!a. +!a <- .send(b, tell, q); +p; .send(b, tell, r).",
    },
    "busy wait ended by a message": {
        "a": "!w. +!w : not x <- !w. +!w <- .print(x).",
        "b": "!a. +!a <- +p; +q; .send(a, tell, x); +r; +s.",
    },
    "busy wait and waits": {
        "a": "!w. +!w : not x <- !w. +!w <- .print(x).",
        "b": "!a. +!a <- .wait(3); .send(a, tell, y); .wait(3).",
    },
    "wait during many updates": {
        "a": f"!w. !g. +!w <- .wait(0.5); .print(woken). +!g <- {MANY_UPDATES}; ?p(X); .print(X).",
        "b": _ALONE,
    },
    "later wait during many updates": {
        "a": f"!g. +!g <- .wait(0.5); !!h; {MANY_UPDATES}; .print(g). +!h <- .wait(0.3); .print(h).",
        "b": _ALONE,
    },
    "several events during many updates": {
        "a": "p(50). s(1). s(2). s(3). !g. +!g <- .abolish(s(_)); -+p(0); .print(g). -s(X) : p(Y) <- .print(X, Y).",
        "b": _ALONE,
    },
    "own message during many updates": {
        "a": f"!g. +!g <- .send(a, tell, x); {MANY_UPDATES}; .print(g). +x : p(X) <- .print(X).",
        "b": _ALONE,
    },
    "message in a context during many updates": {
        "a": f"!g. +!g : .send(b, tell, x) <- {MANY_UPDATES}; .send(b, tell, y); .print(g).",
        "b": _ALONE,
    },
    "message in a condition during many updates": {
        "a": f"!g. +!g <- if (.send(b, tell, x)) {{ -+p(20) }}; {MANY_UPDATES}; act(1). +q(X) : p(Y) <- .print(X, Y).",
        "b": _ALONE,
    },
    "condition awaited during many updates": {
        "a": f"!g. +!g <- .wait(p(5)); .print(five). +!h <- {MANY_UPDATES}. !h.",
        "b": _ALONE,
    },
    "noticed update during many updates": {
        "a": f"!g. +!g <- !h; .print(g). +!h <- {MANY_UPDATES}. +p(7) <- .print(seven); +r. -p(8) <- .print(eight).",
        "b": _ALONE,
    },
    "question during many updates": {
        "a": f"!g. +!g <- .send(b, askOne, x, A, 1); .print(A). !h. +!h <- {MANY_UPDATES}; .print(h).",
        "b": _ALONE,
    },
    "no number in the middle of a run of statements": {
        "a": "q(z). !g. +!g : q(X) <- +p; do(1); -+r(2); -+q(X + 1); -p; do(2). -!g : p & r(N) <- .print(failed, N).",
        "b": _OTHER,
    },
    "no number in a context": {
        "a": "q(z). !g. +!g : q(X) & X + 1 > 2 <- .print(one). +!g : p | q(z) <- .print(two).",
        "b": _OTHER,
    },
    "no number in the context for a belief": {
        "a": "q(z). !g. +!g <- +p; .print(on). +p : q(X) & X * 2 > 1 <- .print(one). +p.",
        "b": _OTHER,
    },
    "no number in a comparison": {
        "a": "q(z). !g. +!g <- !h. +!h : q(X) & (X < 1 | X >= 1) <- .print(one). -!g <- .print(no).",
        "b": _OTHER,
    },
    "no number in an action": {"a": "q(z). !g. +!g : q(X) <- do(0); do(X + 1); do(2). -!g <- .print(no).", "b": _OTHER},
    "replaced by what is held": {"a": "q(1). q(2). !g0. +!g0 <- if (not q(2)) { .print(y) }; -+q(2)."},
    "one of several replaced": {
        "a": "n(1). n(2)[source(b)]. n(3)[source(self), source(b)]. !g. "
        "+!g <- -+n(4); -+n(4); -+n(5); for (n(X)[source(S)]) { .print(X, S) }."
    },
    "rules": {
        "a": "ready :- p0. !go. +!go : not ready <- !go. +!go <- .print(ready); .send(b, achieve, g).",
        "b": "!tell. +!tell <- .send(a, tell, p0). +!g[source(S)] <- .print(S).",
    },
    "abolished in order": {"a": "!go. +!go <- +p(1); +p(2); +p(3); .abolish(p(_)). -p(X) <- .print(X)."},
    "loop with !h": {
        "a": "q(1). q(2). q(3). !g. +!g <- for (q(X)) { !h; .print(X) }; +p; ?q(Y); "
        "!h; .print(Y). +!h <- do(9). +!h. +!k(_) <- +r; -r."
    },
    "loop with do(1); do(2)": {
        "a": "q(1). q(2). q(3). !g. +!g <- for (q(X)) { do(1); do(2); .print(X) }; +"
        "p; ?q(Y); do(1); do(2); .print(Y). +!h <- do(9). +!h. +!k(_) <- +r; -r."
    },
    "loop with !h; do(1); -+p(X)": {
        "a": "q(1). q(2). q(3). !g. +!g <- for (q(X)) { !h; do(1); -+p(X); .print(X)"
        " }; +p; ?q(Y); !h; do(1); -+p(Y); .print(Y). +!h <- do(9). +!h. +!k(_) <- +r; -r."
    },
    "loop with +q(X + 5); !h": {
        "a": "q(1). q(2). q(3). !g. +!g <- for (q(X)) { +q(X + 5); !h; .print(X) }; "
        "+p; ?q(Y); +q(Y + 5); !h; .print(Y). +!h <- do(9). +!h. +!k(_) <- +r; -r."
    },
    "loop with .print(on); !k(X)": {
        "a": "q(1). q(2). q(3). !g. +!g <- for (q(X)) { .print(on); !k(X); .print(X)"
        " }; +p; ?q(Y); .print(on); !k(Y); .print(Y). +!h <- do(9). +!h. +!k(_) <- +r; -r."
    },
}
"""The sources of the agents by name."""


def outcome(run: Callable[..., Result], **options: Any) -> Result | str:
    """The result of a run without its trace, or the error that it ends with."""
    try:
        return run(**options)._replace(trace=None)
    except BdiError as error:
        return str(error)


def load(folder: Path, sources: dict[str, str], environment: type[Environment]) -> MultiAgentSystem:
    return system_of(folder, environment(), **sources)


def recorded(folder: Path, case: str, environment: str, **options: Any) -> Any:
    """The run of a case as JSON holds it."""
    system = load(folder, CASES[case], ENVIRONMENTS[environment])
    result = outcome(system.run, max_rounds=120, seed=3, **options)
    text = json.dumps(result if isinstance(result, str) else result._asdict())
    data = json.loads(text.replace(str(folder), "@"))
    return {key: value for key, value in data.items() if key != "endless"} if isinstance(data, dict) else data


@pytest.mark.parametrize("environment", ENVIRONMENTS)
@pytest.mark.parametrize("case", CASES)
def test_run_is_as_recorded(tmp_path: Path, case: str, environment: str) -> None:
    expected = json.loads(RECORDED.read_text(encoding="utf-8"))[case][environment]
    assert recorded(tmp_path, case, environment) == expected
    assert recorded(tmp_path, case, environment, trace=True) == expected


@pytest.mark.parametrize("max_rounds", [10_000, 31, 7])
@pytest.mark.parametrize("folder", [*PROGRAMS, *REFERENCE_PROGRAMS], ids=lambda folder: folder.name)
def test_run_of_a_program_is_the_same_again_and_with_a_trace(folder: Path, max_rounds: int) -> None:
    system = MultiAgentSystem.load(folder / "mas.mas2j")
    expected = system.run(max_rounds=max_rounds)
    assert system.run(max_rounds=max_rounds) == expected
    assert outcome(system.run, max_rounds=max_rounds, trace=True) == expected


@pytest.mark.slow
@BRIEF
@given(systems(), st.sampled_from([Environment, World]))
def test_made_up_program_runs_the_same_with_a_trace(sources: dict[str, str], environment: type[Environment]) -> None:
    with TemporaryDirectory() as folder:
        runs = [partial(load(Path(folder), sources, environment).run, trace=trace) for trace in (False, True)]
        plain, traced = (outcome(run, max_rounds=120, seed=3) for run in runs)
        assert traced == plain


@pytest.mark.parametrize("trace", [False, True])
@pytest.mark.parametrize("sooner", range(6))
def test_what_a_plan_waits_for_may_come_between_its_selection_and_its_statement(
    tmp_path: Path, sooner: int, trace: bool
) -> None:
    waits = "!g. !w. +!g <- .print(1); .print(2); .print(3). +!w : not q <- !w. +!w <- .print(found)."
    system = system_of(tmp_path, a=waits, b=f"!s. +!s <- {'.print(y); ' * sooner}.send(a, tell, q).")
    result = system.run(trace=trace)
    assert "[a] found" in result.prints
    assert result.ended == "idle"


@pytest.mark.parametrize("content", ["deep(T)", "T"])
def test_a_deeply_nested_term_can_be_sent(tmp_path: Path, content: str) -> None:
    sender = f"!g(0, z). +!g(N, T) : N < 3000 <- !g(N + 1, s(T)). +!g(_, T) <- .send(b, tell, {content}); do(sent)."
    result = system_of(tmp_path, a=sender, b="+deep(_) <- do(received).").run(max_rounds=20_000)
    assert ("a", "do(sent)") in result.actions
    assert (("b", "do(received)") in result.actions) == (content == "deep(T)")


def _write() -> None:
    runs: dict[str, dict[str, Any]] = {}
    for case in CASES:
        with TemporaryDirectory() as folder:
            runs[case] = {name: recorded(Path(folder), case, name) for name in ENVIRONMENTS}
    RECORDED.write_text(json.dumps(runs, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _write()
