"""Traces: what led to what, as data and as text."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from pytest_hricdv.bdi import Step, Trace
from pytest_hricdv.bdi.__main__ import main
from tests.bdi.models import TABLE, run_table, system_of, table

BELIEFS = ["leg3", "bored", "m010l3", "m111l4"]


def _trace(folder: Path, **sources: str) -> Trace:
    trace = system_of(folder, **sources).run(trace=True).trace
    assert trace is not None
    return trace


def _texts(steps: tuple[Step, ...]) -> list[str]:
    return [str(step) for step in steps]


def test_causes_cross_from_agent_to_agent(tmp_path: Path) -> None:
    trace = _trace(
        tmp_path,
        ann="!go. @hail +!go <- .send(bob, tell, hello); .send(bob, achieve, dance).",
        bob="@hear +hello[source(S)] <- .send(S, tell, hi(S)). @move +!dance <- jump.",
    )
    (jump,) = trace.of("bob", "action")
    assert _texts(trace.why(jump)) == [
        "goal +!go[source(self)]",
        "plan @hail +!go (ann.asl:1)",
        "message achieve dance to bob",
        "goal +!dance[source(ann)]",
        "plan @move +!dance (bob.asl:1)",
        "action jump",
    ]
    (greeted,) = trace.of("ann", "belief")
    assert [step.agent for step in trace.why(greeted)] == ["ann", "ann", "ann", "bob", "bob", "bob", "ann"]


def test_every_line_of_an_abstract_test_is_followed_back_to_meta() -> None:
    percepts = {"meta": [f"chosen({belief})" for belief in BELIEFS]}
    trace = table().run(percepts=percepts, trace=True).trace
    assert trace is not None
    actions = trace.of("human", "action")
    assert [step.text for step in actions] == [text for agent, text in run_table(BELIEFS).actions if agent == "human"]
    for action in actions:
        chain = trace.why(action)
        assert chain[0].agent == "meta"
        assert chain[-1] is action
        assert chain[-2].kind == "plan"
        assert all(earlier.number < later.number for earlier, later in pairwise(chain))
        assert all(earlier.round <= later.round for earlier, later in pairwise(chain))
    (pose,) = [step for step in trace.of("human", "plan") if step.plan == "plan27"]
    assert pose.beliefs == ("leg3[source(meta)]", "m010l3[source(meta)]")


def test_trace_is_json(tmp_path: Path) -> None:
    trace = _trace(tmp_path, ann="!go. +!go <- walk.")
    assert json.loads(trace.to_json())[2] == {
        "number": 3,
        "round": 1,
        "agent": "ann",
        "kind": "action",
        "text": "walk",
        "cause": 2,
        "plan": "_plan1",
        "place": "",
        "beliefs": [],
    }


def test_trace_is_shown_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    system_of(tmp_path, ann="+light(X) <- walk(X).")
    file = str(tmp_path / "mas.mas2j")
    assert main(["trace", file, "--percept", "ann:light(on)", "--quiet"]) == 0
    assert capsys.readouterr().out == (
        "   1  round 1    ann  percept +light(on)[source(percept)]\n"
        "   2  round 1    ann  plan +light(X) (ann.asl:1)  <- 1\n"
        "   3  round 1    ann  action walk(on)  <- 2\n"
    )
    assert main(["trace", file, "--percept", "ann:light(on)", "--quiet", "--why", "walk"]) == 0
    assert capsys.readouterr().out == (
        "[round 1] ann: percept +light(on)[source(percept)]\n"
        "  [round 1] ann: plan +light(X) (ann.asl:1)\n"
        "    [round 1] ann: action walk(on)\n"
    )
    for options in (["--why", "fly"], ["--agent", "anne"]):
        assert main(["trace", file, "--quiet", *options]) == 2
        assert f"error: {options[0]} {options[1]}: no a" in capsys.readouterr().err
    assert main(["trace", file, "--percept", "ann:light(on)", "--quiet", "--json"]) == 0
    assert len(json.loads(capsys.readouterr().out)) == 3


@pytest.mark.parametrize(
    ("percept", "message"),
    [
        ("ghost:light", "no agent 'ghost'"),
        ("meta:light(", "expected a literal|expected a term"),
        ("meta:p(X)", "no variables"),
    ],
)
def test_percept_that_cannot_be_is_an_error(capsys: pytest.CaptureFixture[str], percept: str, message: str) -> None:
    assert main(["trace", str(TABLE), "--percept", percept]) == 2
    assert re.search(message, capsys.readouterr().err)
