"""A failing test is reduced to what it needs to fail."""

from __future__ import annotations

import pytest

from pytest_hricdv.extra.diagnosis.pair_search import shrunk
from pytest_hricdv.extra.diagnosis.runs import RunSummary
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest, Concretization
from pytest_hricdv.generate.sampler import Uniform

SPACE = Concretization(
    commands={"ask": {"pause_s": Uniform(0.0, 4.0, "s")}, "go": {}, "disturb noise": {"level": Uniform(0.0, 1.0)}}
)


def action(command: str, **parameters: float) -> ConcreteAction:
    return ConcreteAction(command, parameters)


TEST = ConcreteTest(
    "t", "s", 0, (action("go"), action("ask", pause_s=1.234), action("disturb noise", level=0.777), action("go"))
)


def robot(test: ConcreteTest) -> RunSummary:
    """Its R1 fails where noise is loud; its R2 always."""
    loud = any(part.parameters.get("level", 0.0) > 0.4 for part in test.actions)
    return RunSummary(violated=("R1", "R2") if loud else ("R2",))


def test_what_it_does_not_need_is_taken_away() -> None:
    minimal = shrunk(TEST, SPACE, robot(TEST), "R1", robot, 100)
    assert minimal.test.actions == (action("disturb noise", level=0.5),)
    assert minimal.ran.violated == ("R1", "R2")
    assert minimal.is_done


def test_the_budget_ends_it_and_what_was_reached_counts() -> None:
    minimal = shrunk(TEST, SPACE, robot(TEST), "R1", robot, 3)
    assert (minimal.runs, minimal.is_done) == (3, False)
    assert len(minimal.test.actions) < len(TEST.actions)
    assert "R1" in minimal.ran.violated


def test_what_came_to_no_end_does_not_fail() -> None:
    minimal = shrunk(TEST, SPACE, robot(TEST), "R1", lambda test: None, 100)
    assert minimal.test == TEST


def test_ctrl_c_goes_on() -> None:
    def run(test: ConcreteTest) -> RunSummary:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        shrunk(TEST, SPACE, robot(TEST), "R1", run, 100)
