"""Agents that only look again and again, and how long agents keep to themselves."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import Environment, MultiAgentSystem, Structure
from pytest_hricdv.bdi.company import Company
from pytest_hricdv.bdi.compiled.calm import CALM, CalmAnalysis
from pytest_hricdv.bdi.language.parser import parse_program, parse_trigger
from pytest_hricdv.bdi.prototype import library_of
from tests.bdi.models import system_of

ENGINES = ("interpreter", "compiled", "memo")
WAITS = "!w. @look +!w : not x <- !w. @seen +!w <- .print(seen)."


@pytest.mark.parametrize("engine", ENGINES)
def test_run_ends_as_soon_as_nobody_does_anything_but_look_again(tmp_path: Path, engine: str) -> None:
    system_of(tmp_path, a=WAITS, b="!go. +!go <- +p; +q; +r.")
    result = MultiAgentSystem.load(tmp_path / "mas.mas2j", engine=engine).run()  # type: ignore[arg-type]
    assert result.ended == "spin"
    assert result.plans["a"] == ["look"] * result.rounds
    assert result.rounds < 6


@pytest.mark.parametrize("engine", ENGINES)
def test_every_cycle_of_one_that_waits_counts(tmp_path: Path, engine: str) -> None:
    system_of(tmp_path, a=WAITS, b="!go. +!go <- .wait(2); .send(a, tell, x).")
    result = MultiAgentSystem.load(tmp_path / "mas.mas2j", engine=engine).run()  # type: ignore[arg-type]
    assert result.prints == ["[a] seen"]
    assert result.ended == "idle"
    looked = result.plans["a"].count("look")
    assert result.plans["a"] == ["look"] * looked + ["seen"]
    # Two milliseconds are twenty ticks, in which nobody else has anything to do.
    assert looked == 21


class Bell(Environment):
    """Rings for agent a when b does."""

    def execute(self, agent: str, action: Structure) -> bool:
        self.add_percept("a", "x")
        return True


@pytest.mark.parametrize("engine", ENGINES)
def test_one_that_waits_perceives_what_it_waits_for(tmp_path: Path, engine: str) -> None:
    system_of(tmp_path, a=WAITS, b="!go. +!go <- +p; +q; ring; +r.")
    system = MultiAgentSystem.load(tmp_path / "mas.mas2j", Bell(), engine)  # type: ignore[arg-type]
    assert system.run().prints == ["[a] seen"]


@pytest.mark.parametrize(
    "look",
    [
        "+!w : .random(X) & X < 2 <- !w.",
        "+!w : p(A) & A + 1 > 0 <- !w.",
        "+!w[source(self)] <- !w.",
        "@x[atomic] +!w <- !w.",
    ],
)
def test_one_whose_looking_does_something_is_not_left_alone(tmp_path: Path, look: str) -> None:
    system = system_of(tmp_path, a=f"p(a). !w. {look} +!w.")
    assert system.run(max_rounds=60).rounds > 30 or system.run().ended == "idle"


@pytest.mark.parametrize(
    ("source", "event", "calm"),
    [
        ("+e <- +x; +y; .send(b, tell, z).", "+e", (2, 2)),
        ("+e <- +x; +y.", "+e", (CALM, 2)),
        ("+e <- !g. +!g : p <- +x; .send(b, tell, z). +!g.", "+e", (2, 1)),
        ("+e <- !g; .send(b, tell, z). +!g <- +x; +y.", "+e", (3, 3)),
        ("+e <- !e. +!e : not x <- !e. +!e <- +y; .send(b, tell, z).", "+!e", (1, 1)),
        ("+e <- while (p) { +x; .send(b, tell, z) }.", "+e", (2, 1)),
        ("+e <- if (p) { +x } else { .send(b, tell, z) }; +y; +w; +v.", "+e", (1, 1)),
        ("+e <- .wait(0.3); .send(b, tell, z).", "+e", (4, 4)),
        ("+e <- .wait(X); .send(b, tell, z).", "+e", (0, 0)),
        ("+e : .random(X) <- +x.", "+e", (0, 0)),
        ("@a[atomic] +e <- +x; +y.", "+e", (0, 0)),
        ("+e <- +x; +y. -!g <- .print(a).", "+e", (0, 0)),
        ("+e <- +x; +y; +w. +x <- .send(b, tell, z).", "+e", (1, 1)),
        ("+e(B) <- +x; B.", "+e(_)", (1, 1)),
        ("+e <- .print(a); act(1); .send(b, tell, z).", "+e", (2, 2)),
    ],
)
def test_how_long_an_agent_keeps_to_itself(source: str, event: str, calm: tuple[int, int]) -> None:
    program = parse_program(source)
    found = CalmAnalysis(library_of(program), Company.of({"a": program})).calm()
    trigger = parse_trigger(event).key
    assert trigger is not None
    assert found[trigger] == calm


def test_what_two_agents_print_is_not_kept_to_themselves() -> None:
    program = parse_program("+e <- +x; .print(a); +y.")
    company = Company.of({"a": program, "b": parse_program("!g. +!g <- .println(b).")})
    assert CalmAnalysis(library_of(program), company).calm()["+", (False, "e", 0)] == (1, 1)
