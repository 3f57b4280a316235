"""All engines agree: on the table model, on whole programs, and on programs made up at random."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from pytest_hricdv.bdi import BdiError, Environment, MultiAgentSystem, Result, Structure
from pytest_hricdv.bdi.system import Engine
from tests.bdi.generated import systems
from tests.bdi.models import BELIEFS, LEG_STARTS, TABLE, system_of
from tests.bdi.test_programs import PROGRAMS, REFERENCE_PROGRAMS

ENGINES = ("interpreter", "compiled", "memo")
SPINNING = Path(__file__).parents[2] / "benchmarks" / "spinning" / "spinning.mas2j"


def traced(system: MultiAgentSystem, **options: Any) -> Result:
    """The result of a run in which nothing is left out or done ahead, as every step is noted."""
    return system.run(trace=True, **options)._replace(trace=None)


class World(Environment):
    """A world in which an action can fail, and another one shows the agent something."""

    def execute(self, agent: str, action: Structure) -> bool:
        if action.functor == "act":
            self.add_percept(agent, f"q({action.args[0]})")
            self.add_percept("b", "p1")
        return action.functor != "refuse"


def random_sets(count: int, seed: int) -> Iterable[list[str]]:
    """Sets of beliefs as methods choose them, and every fifth one without any rule."""
    drawn = random.Random(seed)
    for number in range(count):
        if number % 5:
            yield [drawn.choice(LEG_STARTS), *drawn.sample(BELIEFS[4:], drawn.randint(0, 12))]
        else:
            yield drawn.sample(BELIEFS, drawn.randint(0, len(BELIEFS)))


def assert_engines_agree_on(model: Path, count: int, seed: int) -> None:
    systems = [MultiAgentSystem.load(model, engine=engine) for engine in ENGINES]
    for beliefs in random_sets(count, seed):
        percepts = {"meta": [f"chosen({belief})" for belief in beliefs]}
        expected = traced(systems[0], percepts=percepts)
        for system in systems:
            assert system.run(percepts=percepts) == expected, beliefs


@pytest.mark.parametrize("model", [TABLE, SPINNING], ids=lambda model: model.stem)
def test_engines_agree_on_random_beliefs_of_the_table_models(model: Path) -> None:
    assert_engines_agree_on(model, 200, seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("model", [TABLE, SPINNING], ids=lambda model: model.stem)
def test_engines_agree_on_many_random_beliefs_of_the_table_models(model: Path) -> None:
    assert_engines_agree_on(model, 3000, seed=2)


@pytest.mark.parametrize("max_rounds", [10_000, 31, 7])
@pytest.mark.parametrize("folder", [*PROGRAMS, *REFERENCE_PROGRAMS], ids=lambda folder: folder.name)
def test_engines_agree_on_whole_programs(folder: Path, max_rounds: int) -> None:
    systems = [MultiAgentSystem.load(folder / "mas.mas2j", engine=engine) for engine in ENGINES]
    expected = traced(systems[0], max_rounds=max_rounds)
    for system in systems:
        assert system.run(max_rounds=max_rounds) == expected
        assert system.run(max_rounds=max_rounds) == expected


def outcome(run: Callable[..., Result], max_rounds: int = 120) -> Result | str:
    """The result of a run, or the error that it ends with."""
    try:
        return run(max_rounds=max_rounds, seed=3)
    except BdiError as error:
        return str(error)


def assert_engines_agree(sources: dict[str, str], environment: type[Environment]) -> None:
    with TemporaryDirectory() as folder:
        outcomes = []
        for engine in ENGINES:
            system_of(Path(folder), **sources)
            system = MultiAgentSystem.load(Path(folder) / "mas.mas2j", environment(), engine)
            if not outcomes:
                outcomes.append(outcome(partial(traced, system)))
                system = MultiAgentSystem.load(Path(folder) / "mas.mas2j", environment(), engine)
            outcomes.append(outcome(system.run))
        for other in outcomes[1:]:
            assert other == outcomes[0]


BRIEF = settings(deadline=None, max_examples=40, suppress_health_check=list(HealthCheck))
LONG = settings(deadline=None, max_examples=1000, suppress_health_check=list(HealthCheck))


def test_engines_agree_where_the_last_statement_replaces_a_belief_by_one_that_is_held() -> None:
    """No event then, so that the plan ends a cycle earlier than after a change."""
    body = "if (not q(2)) { .print(y) }; -+q(2)"
    assert_engines_agree({"a": f"q(1). q(2). !g0. +!g0 <- {body}."}, Environment)


@pytest.mark.parametrize(
    "sources",
    [
        # What waits for `!c` has nothing left to do, and is on the stack of the interpreter alone.
        {"a": "!a. +!a <- !b. +!b <- !c. +!c <- !a."},
        {"a": "!a. +!a <- !!a; !b. +!b.", "b": "!a. +!a <- !!a; !b. +!b."},
        {"a": "!a. +!a <- !b. +!b <- !c. +!c <- !a. -!a <- .print(never)."},
        # One goes on while another reacts to what it has sent, and waits for no time at all.
        {"a": "!a. +!a <- +p; .send(b, tell, q); .wait(0).", "b": "!b. +!b <- +p."},
        {"a": "!a. +!a <- .send(b, tell, q); .wait(0.1); .send(b, tell, r).", "b": "+q <- .wait(0.2); +p; +s."},
        {"a": "!a. +!a <- .send(b, tell, q); +p; .send(b, tell, r); +s.", "b": "+q <- +x; +y; .send(a, tell, z)."},
        {"a": "!a. +!a <- .send(b, tell, q); do(1); do(2).", "b": "+q <- !c. +!c <- +x; do(3)."},
        {"b": "+q <- +x; .send(a, tell, z). +r <- do(r).", "a": "!a. +!a <- .send(b, tell, q); +p; .send(b, tell, r)."},
        # One that spins is found out about in the middle of what others do.
        {"a": "!w. +!w : not x <- !w. +!w <- .print(x).", "b": "!a. +!a <- +p; +q; .send(a, tell, x); +r; +s."},
        {"a": "!w. +!w : not x <- !w. +!w <- .print(x).", "b": "!a. +!a <- .wait(3); .send(a, tell, y); .wait(3)."},
    ],
)
def test_engines_agree_where_agents_spin_or_go_ahead(sources: dict[str, str]) -> None:
    assert_engines_agree(sources, Environment)
    assert_engines_agree(sources, World)


@pytest.mark.parametrize("trace", [False, True])
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("sooner", range(6))
def test_what_a_plan_looks_for_may_come_between_its_selection_and_its_step(
    tmp_path: Path, sooner: int, engine: Engine, trace: bool
) -> None:
    waits = "!g. !w. +!g <- .print(1); .print(2); .print(3). +!w : not q <- !w. +!w <- .print(found)."
    system_of(tmp_path, a=waits, b=f"!s. +!s <- {'.print(y); ' * sooner}.send(a, tell, q).")
    result = MultiAgentSystem.load(tmp_path / "mas.mas2j", engine=engine).run(trace=trace)
    assert "[a] found" in result.prints
    assert result.ended == "idle"


MANY_UPDATES = "; ".join(f"-+p({number})" for number in range(12))


@pytest.mark.parametrize(
    "source",
    [
        f"!w. !g. +!w <- .wait(0.5); .print(woken). +!g <- {MANY_UPDATES}; ?p(X); .print(X).",
        f"!g. +!g <- .wait(0.5); !!h; {MANY_UPDATES}; .print(g). +!h <- .wait(0.3); .print(h).",
        "p(50). s(1). s(2). s(3). !g. +!g <- .abolish(s(_)); -+p(0); .print(g). -s(X) : p(Y) <- .print(X, Y).",
        f"!g. +!g <- .send(a, tell, x); {MANY_UPDATES}; .print(g). +x : p(X) <- .print(X).",
        f"!g. +!g : .send(b, tell, x) <- {MANY_UPDATES}; .send(b, tell, y); .print(g).",
        f"!g. +!g <- if (.send(b, tell, x)) {{ -+p(20) }}; {MANY_UPDATES}; act(1). +q(X) : p(Y) <- .print(X, Y).",
        f"!g. +!g <- .wait(p(5)); .print(five). +!h <- {MANY_UPDATES}. !h.",
        f"!g. +!g <- !h; .print(g). +!h <- {MANY_UPDATES}. +p(7) <- .print(seven); +r. -p(8) <- .print(eight).",
        f"!g. +!g <- .send(b, askOne, x, A, 1); .print(A). !h. +!h <- {MANY_UPDATES}; .print(h).",
    ],
    ids=[
        "wait",
        "later wait",
        "several events",
        "own message",
        "context",
        "condition",
        "condition awaited",
        "noticed update",
        "question",
    ],
)
def test_agent_that_is_alone_for_long_notices_what_comes_between(source: str) -> None:
    other = "+x[source(S)] <- .wait(0.2); .send(S, tell, q(9)). +y <- .print(y)."
    assert_engines_agree({"a": source, "b": other}, World)


def test_engines_agree_where_nobody_there_perceives_anything(tmp_path: Path) -> None:
    system_of(tmp_path, a="!g. +!g <- .print(x).")
    results = []
    for engine in ENGINES:
        environment = Environment()
        environment.show("nobody", ["p(x)"])
        results.append(MultiAgentSystem.load(tmp_path / "mas.mas2j", environment, engine).run())
    assert results[0].prints == ["[a] x"]
    assert results[1:] == results[:1] * 2


@BRIEF
@given(systems(), st.sampled_from([Environment, World]))
def test_engines_agree_on_made_up_programs(sources: dict[str, str], environment: type[Environment]) -> None:
    assert_engines_agree(sources, environment)


@pytest.mark.slow
@LONG
@given(systems(), st.sampled_from([Environment, World]))
def test_engines_agree_on_many_made_up_programs(sources: dict[str, str], environment: type[Environment]) -> None:
    assert_engines_agree(sources, environment)


def test_all_agents_of_the_table_model_have_a_compiled_form() -> None:
    assert MultiAgentSystem.load(TABLE).compiled == ("robot_code", "human", "sensors", "meta")
    assert MultiAgentSystem.load(TABLE, engine="interpreter").compiled == ()


NO_NUMBER = {
    "in the middle of a run of statements": "q(z). !g. +!g : q(X) <- +p; do(1); -+r(2); -+q(X + 1); -p; do(2). "
    "-!g : p & r(N) <- .print(failed, N).",
    "in a context": "q(z). !g. +!g : q(X) & X + 1 > 2 <- .print(one). +!g : p | q(z) <- .print(two).",
    "in the context for a belief": "q(z). !g. +!g <- +p; .print(on). +p : q(X) & X * 2 > 1 <- .print(one). +p.",
    "in a comparison": "q(z). !g. +!g <- !h. +!h : q(X) & (X < 1 | X >= 1) <- .print(one). -!g <- .print(no).",
    "in an action": "q(z). !g. +!g : q(X) <- do(0); do(X + 1); do(2). -!g <- .print(no).",
}


@pytest.mark.parametrize("source", NO_NUMBER.values(), ids=NO_NUMBER.keys())
@pytest.mark.parametrize("environment", [Environment, World])
def test_all_engines_stop_where_a_number_is_expected(source: str, environment: type[Environment]) -> None:
    assert_engines_agree({"a": source, "b": "+p. !w. +!w <- .wait(1); do(9)."}, environment)


def results_of(folder: Path, **sources: str) -> list[Result]:
    """What comes of a system on each engine."""
    system_of(folder, **sources)
    return [MultiAgentSystem.load(folder / "mas.mas2j", engine=engine).run(max_rounds=20_000) for engine in ENGINES]


@pytest.mark.parametrize("step", ["!h", "do(1); do(2)", "!h; do(1); -+p(X)", "+q(X + 5); !h", ".print(on); !k(X)"])
@pytest.mark.parametrize("environment", [Environment, World])
def test_all_engines_remember_what_a_loop_is_about(step: str, environment: type[Environment]) -> None:
    loops = f"for (q(X)) {{ {step}; .print(X) }}; +p; ?q(Y); {step.replace('X', 'Y')}; .print(Y)"
    source = f"q(1). q(2). q(3). !g. +!g <- {loops}. +!h <- do(9). +!h. +!k(_) <- +r; -r."
    assert_engines_agree({"a": source}, environment)


def test_all_engines_replace_the_same_one_of_several_beliefs(tmp_path: Path) -> None:
    held = "n(1). n(2)[source(b)]. n(3)[source(self), source(b)]. !g. "
    source = held + "+!g <- -+n(4); -+n(4); -+n(5); for (n(X)[source(S)]) { .print(X, S) }."
    results = results_of(tmp_path, a=source)
    assert results[1] == results[2] == results[0]
    assert len(results[0].prints) > 1


def test_all_engines_send_more_messages_than_are_kept(tmp_path: Path) -> None:
    sender = "n(0). !g. +!g : n(N) & N < 2500 <- .send(b, tell, m(N)); -+n(N + 1); !g. +!g."
    results = results_of(tmp_path, a=sender, b="s(0). +m(N) : s(S) <- -+s(S + N).")
    assert results[1] == results[2] == results[0]


@pytest.mark.parametrize("what", ["deep(T)", "T"])
def test_all_engines_send_what_is_nested_deeply(tmp_path: Path, what: str) -> None:
    sender = f"!g(0, z). +!g(N, T) : N < 3000 <- !g(N + 1, s(T)). +!g(_, T) <- .send(b, tell, {what}); do(sent)."
    results = results_of(tmp_path, a=sender, b="+deep(_) <- do(received).")
    assert ("a", "do(sent)") in results[0].actions
    assert results[1] == results[2] == results[0]


def test_agent_with_rules_is_interpreted_next_to_a_compiled_one(tmp_path: Path) -> None:
    sources = {
        "a": "ready :- p0. !go. +!go : not ready <- !go. +!go <- .print(ready); .send(b, achieve, g).",
        "b": "!tell. +!tell <- .send(a, tell, p0). +!g[source(S)] <- .print(S).",
    }
    system_of(tmp_path, **sources)
    results = [MultiAgentSystem.load(tmp_path / "mas.mas2j", engine=engine).run() for engine in ENGINES]
    assert results[0].prints == ["[a] ready", "[b] a"]
    assert results[1] == results[2] == results[0]
    assert MultiAgentSystem.load(tmp_path / "mas.mas2j").compiled == ("b",)


def test_all_engines_lose_abolished_beliefs_in_the_same_order(tmp_path: Path) -> None:
    system_of(tmp_path, a="!go. +!go <- +p(1); +p(2); +p(3); .abolish(p(_)). -p(X) <- .print(X).")
    results = [MultiAgentSystem.load(tmp_path / "mas.mas2j", engine=engine).run() for engine in ENGINES]
    assert results[0].prints == ["[a] 3", "[a] 2", "[a] 1"]
    assert results[1] == results[2] == results[0]


def test_unknown_engine_is_refused() -> None:
    with pytest.raises(ValueError, match="engine must be one of interpreter, compiled, memo, got 'jit'"):
        MultiAgentSystem.load(TABLE, engine="jit")  # type: ignore[arg-type]
