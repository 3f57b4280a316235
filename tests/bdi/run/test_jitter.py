"""Jitter: other orders and delays than those of a plain run, by the seed alone, find races and nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.bdi import Environment, MultiAgentSystem, Structure
from pytest_hricdv.bdi.__main__ import main
from tests.bdi.models import system_of

SEEDS = range(25)


def _racing(folder: Path) -> MultiAgentSystem:
    """Two agents tell a third, which listens to the first only."""
    return system_of(
        folder,
        ann="!go. +!go <- .send(judge, tell, here).",
        bob="!go. +!go <- .send(judge, tell, here).",
        judge="+here[source(S)] : not winner(_) <- +winner(S); .print(S).",
    )


def test_race_between_two_senders_comes_out_both_ways(tmp_path: Path) -> None:
    system = _racing(tmp_path)
    assert {tuple(system.run(seed=seed).prints) for seed in SEEDS} == {("[judge] ann",)}
    assert {tuple(system.run(seed=seed, jitter=3).prints) for seed in SEEDS} == {("[judge] ann",), ("[judge] bob",)}


class Door(Environment):
    """A door that opens when it is knocked at: both agents then see it open."""

    def execute(self, agent: str, action: Structure) -> bool:
        for other in ("ann", "bob"):
            self.add_percept(other, "open")
        return True


def test_percepts_may_come_late_but_come(tmp_path: Path) -> None:
    system = system_of(
        tmp_path,
        ann="!go. +!go <- knock; .send(bob, tell, knocked). +open <- .print(open).",
        bob="+knocked : open <- .print(open). +knocked <- .print(shut); .wait(open); .print(opened).",
    )
    seen = set()
    for seed in SEEDS:
        system.environment = Door()
        result = system.run(seed=seed, jitter=4)
        assert "[ann] open" in result.prints
        seen.add(tuple(line for line in result.prints if line.startswith("[bob]")))
    assert seen == {("[bob] open",), ("[bob] shut", "[bob] opened")}


def test_negative_jitter_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="jitter must not be negative, got -1"):
        system_of(tmp_path, a="p.").run(jitter=-1)


def test_jitter_is_an_option_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _racing(tmp_path)
    outputs = set()
    for seed in SEEDS:
        assert main(["run", str(tmp_path / "mas.mas2j"), "--jitter", "3", "--seed", str(seed), "--quiet"]) == 0
        outputs.add(capsys.readouterr().out)
    assert outputs == {"[judge] ann\n", "[judge] bob\n"}
