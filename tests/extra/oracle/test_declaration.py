"""Declarations of conformance: what they accept, and what they refuse, with the place and the nearest name."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.declarations.model_oracle import ActionMapping, ModelOracle, ModelOracleError
from pytest_hricdv.monitor import RequirementError
from tests.extra.oracle.toy import TOY, Toy

OFFERED = ActionMapping("offered", "on(offer)")


def test_the_oracle_says_what_is_required(tmp_path: Path) -> None:
    oracle = Toy(tmp_path).oracle
    assert (oracle.id, oracle.source, oracle.group) == ("MODEL", "robot.asl", "model")
    assert oracle.title == "The code under test does what the agent robot does, in time, and nothing else"
    assert oracle.text.startswith("take(Thing) after 1 to 10 s, offered within 2 s, ")


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"agent": "robto"}, "ModelOracle: no agent 'robto' in * nearest: robot"),
        (
            {"actions": (ActionMapping("@ofer", "on(offer)"),)},
            "ActionMapping('@ofer'): robot has no plan @ofer; nearest: @offer",
        ),
        (
            {"actions": (ActionMapping("ofered", "on(offer)"),)},
            "ActionMapping('ofered'): robot has no action or message ofered; nearest: offered",
        ),
        (
            {"actions": (ActionMapping("take", "on(taken)"),)},
            "ActionMapping('take'): robot has no action or message take with 0 arguments; it has 1",
        ),
        ({"actions": (ActionMapping("take(", "on(taken)"),)}, "ActionMapping('take('): *"),
        (
            {"actions": (ActionMapping("take(Thign)", "on(taken)"),)},
            "ActionMapping('take(Thign)'): Thign is neither a field of its message nor a signal; nearest: thing",
        ),
        (
            {"actions": (ActionMapping("offered", "on(offer)", fails="rise(gripping)"),)},
            "ActionMapping('offered'), fails: only an external action can fail; offered is not one of robot",
        ),
        (
            {"percepts": (PerceptMapping("wnated(Thing)", "on(order)"),)},
            "PerceptMapping('wnated(Thing)'): robot has no belief wnated; nearest: wanted",
        ),
        (
            {"percepts": (PerceptMapping("!ofer", "on(order)"),)},
            "PerceptMapping('!ofer'): robot has no goal ofer; nearest: offer",
        ),
        (
            {"percepts": (PerceptMapping("thanks", "on(thank)", source="persn"),)},
            "PerceptMapping('thanks'): no agent 'persn'; nearest: person",
        ),
        (
            {"limits": {"patence": 3.0}},
            "ModelOracle: limits: robot has no initial belief patence(number); nearest: patience",
        ),
        (
            {"limits": {"patience": "patience"}},
            "ModelOracle: limits['patience']: the run has no parameter 'patience'; nearest: patience_s",
        ),
        ({"limits": {"patience": True}}, "ModelOracle: limits['patience'] is True; expected a number, or *"),
    ],
)
def test_names_that_do_not_exist_are_refused(tmp_path: Path, changes: dict[str, Any], told: str) -> None:
    with pytest.raises(ModelOracleError) as error:
        Toy(tmp_path, **changes)
    begin, _, end = told.partition("*")
    assert str(error.value).startswith(begin.rstrip()), str(error.value)
    assert str(error.value).endswith(end.strip()), str(error.value)


@pytest.mark.parametrize(
    ("does", "told"),
    [
        (
            ActionMapping("offered", "on(ofer)"),
            "ActionMapping('offered'), column 4: unknown topic 'ofer'; nearest: offer",
        ),
        (ActionMapping("offered", "on(offer) &"), "ActionMapping('offered'), column 12: "),
        (
            ActionMapping("offered", "holding"),
            "ActionMapping('offered'), column 1: expected an event\n    holding\n    ^^^^^^^",
        ),
        (
            ActionMapping("let_go", "on(offer)", fails="holding"),
            "ActionMapping('let_go'), fails, column 1: expected an event",
        ),
    ],
    ids=["an unknown topic", "no condition", "no event", "a failure that is no event"],
)
def test_conditions_that_are_none_are_refused_with_their_place(tmp_path: Path, does: ActionMapping, told: str) -> None:
    with pytest.raises(RequirementError) as error:
        Toy(tmp_path, actions=(does,))
    assert str(error.value).startswith(told), str(error.value)


@pytest.mark.parametrize(
    ("made", "told"),
    [
        (
            lambda: ActionMapping("offered", "on(offer)", within_s=(3.0, 1.0)),
            "ActionMapping('offered'): within_s is (3.0, 1.0); expected",
        ),
        (
            lambda: ActionMapping("offered", "on(offer)", within_s=3.0),  # type: ignore[arg-type]
            "ActionMapping('offered'): within_s is 3.0; expected",
        ),
        (lambda: ModelOracle("robot", ()), "ModelOracle: actions is empty"),
        (lambda: ModelOracle("robot", OFFERED), "ModelOracle: actions is ActionMapping("),  # type: ignore[arg-type]
        (lambda: ModelOracle("robot", (OFFERED,), percepts=("wanted",)), "ModelOracle: percepts is ('wanted',)"),  # type: ignore[arg-type]
        (lambda: ModelOracle("robot", (OFFERED,), tolerance_s=-1.0), "ModelOracle: tolerance_s is -1.0"),
    ],
)
def test_values_that_make_no_sense_are_refused(made: Callable[[], object], told: str) -> None:
    with pytest.raises(ModelOracleError) as error:
        made()
    assert str(error.value).startswith(told)


def test_a_message_whose_content_is_a_variable_can_be_anything_that_the_agent_mentions(tmp_path: Path) -> None:
    robot = "+wanted(Thing) <- !say(offered). +!say(What) <- .send(person, tell, What)."
    toy = Toy(tmp_path, robot, actions=(OFFERED,), percepts=TOY.percepts[:1], limits={})
    assert toy.follow((1.0, "order", {"thing": "cup"}), (1.5, "offer")).verdict == "Passed"


def test_a_variable_can_be_a_signal_which_needs_a_value(tmp_path: Path) -> None:
    robot = "+heavy(Weight) : Weight > 2 <- offered."
    toy = Toy(tmp_path, robot, actions=(OFFERED,), percepts=(PerceptMapping("heavy(Weight)", "on(order)"),), limits={})
    order = (1.0, "order", {"thing": "cup"})
    assert toy.follow((0.0, "weight", 3.0), order, (1.5, "offer")).verdict == "Passed"
    assert toy.follow((0.0, "weight", 1.0), order, (1.5, "offer")).verdict == "Failed"
    with pytest.raises(ModelOracleError, match=r"PerceptMapping\('heavy\(Weight\)'\): weight has no value yet"):
        toy.follow(order)


def test_an_agent_that_waits_busily_is_refused(tmp_path: Path) -> None:
    robot = "+wanted(Thing) <- !spin. +!spin <- .print(x); !spin. +thanks <- offered."
    toy = Toy(tmp_path, robot, actions=(OFFERED,), limits={})
    with pytest.raises(ModelOracleError, match=r"robot does not come to rest: let it wait with \.wait, not in"):
        toy.follow((1.0, "order", {"thing": "cup"}))


def test_a_goal_of_the_agent_that_fails_is_named_in_the_deviation(tmp_path: Path) -> None:
    robot = "+wanted(Thing) <- !missing; offered."
    toy = Toy(tmp_path, robot, actions=(OFFERED,), percepts=TOY.percepts[:1], limits={})
    [violation] = toy.follow((1.0, "order", {"thing": "cup"}), (2.0, "offer")).violations
    assert "nothing, as robot waits (robot: " in violation.text
    assert "no relevant plan for +!missing" in violation.text
