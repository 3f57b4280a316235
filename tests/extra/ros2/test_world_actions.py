"""The world serves actions and calls them: goals are accepted, have feedback, are cancelled, and have results."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pytest_hricdv.declarations.ros2 import Ros2
from pytest_hricdv.runtime.node_error import NodeError
from tests.extra.ros2.test_bridge import Cell

FETCH = "cell_io/action/Fetch"


@pytest.fixture(autouse=True)
def _messages(interfaces: Any) -> None:
    interfaces({"cell_io/action/Fetch.action": "string part\n---\nbool held\n---\nfloat32 way\n"})


def cell() -> Cell:
    return Cell(Ros2(actions={"/fetch": FETCH}))


def fetching(goal: Any) -> None:
    """Fetches in 2 s; what stands in for a planner."""
    for step in range(4):
        goal.feedback(way=1.0 - step / 4)
        if goal.wait(0.5):
            goal.cancel(held=False)
            return
    goal.succeed(held=goal.request.part == "leg")


def served(run: Cell, execute: Callable[[Any], object] = fetching, **options: Any) -> Any:
    """A client of an action that is served."""
    run.node("arm").serve_action("/fetch", FETCH, execute, **options)
    return run.node("person").action("/fetch", FETCH)


def test_a_goal_has_feedback_and_a_result() -> None:
    run = cell()
    seen: list[Any] = []
    client = served(run)

    def person() -> None:
        goal = client.send(1.0, part="leg")
        while (feedback := goal.feedback(1.0)) is not None:
            seen.append((run.kernel.now_s, feedback.way))
        answer = goal.result(1.0)
        seen.append((answer.status, answer.result.held, goal.result(1.0) is answer))

    lines = run.run(person)
    assert seen == [(0.0, 1.0), (0.5, 0.75), (1.0, 0.5), (1.5, 0.25), (4, True, True)]
    assert lines[:3] == [
        "0.000 person fetch_goal part=leg",
        "0.000 arm fetch_answer accepted=True",
        "0.000 arm fetch_feedback way=1.0",
    ]
    assert lines[-1] == "2.000 arm fetch_result status=4 held=True"


def test_a_goal_is_cancelled() -> None:
    run = cell()
    seen: list[Any] = []
    client = served(run)

    def person() -> None:
        goal = client.send(1.0, part="leg")
        run.kernel.sleep(0.7)
        seen.append(goal.cancel(1.0))
        seen.append((run.kernel.now_s, goal.result(5.0).status))
        seen.append(goal.cancel(1.0))

    assert run.run(person)[-3:] == [
        "0.700 person fetch_cancel",
        "0.700 arm fetch_result status=5 held=False",
        "0.700 person fetch_cancel",
    ]
    assert seen == [True, (0.7, 5), False]


def test_a_goal_or_its_cancellation_is_refused() -> None:
    run = cell()
    seen: list[Any] = []
    client = served(run, accept=lambda goal: goal.part == "leg", may_cancel=lambda goal: goal.request.part != "leg")

    def person() -> None:
        seen.append((client.send(1.0, part="top"), client.call(1.0, part="top")))
        goal = client.send(1.0, part="leg")
        seen.append((goal.cancel(1.0), goal.result(5.0).status))

    run.run(person)
    assert seen == [(None, None), (False, 4)]


def test_several_goals_go_on_at_once_each_with_its_own_feedback() -> None:
    run, seen = cell(), {}

    def execute(goal: Any) -> None:
        duration_s = float(goal.request.part)
        goal.feedback(way=duration_s)
        goal.wait(duration_s)
        goal.succeed(held=duration_s > 1.0)

    client = served(run, execute)
    goals: dict[str, Any] = {}

    def waiting(part: str) -> Callable[[], None]:
        def wait() -> None:
            way = goals[part].feedback(1.0).way
            answer = goals[part].result(10.0)
            seen[part] = (way, answer.result.held, run.kernel.now_s)

        return wait

    def person() -> None:
        for part in ("2.0", "1.0"):
            goals[part] = client.send(1.0, part=part)
        for part in goals:
            run.kernel.spawn(part, waiting(part))

    run.run(person)
    assert seen == {"2.0": (2.0, True, 2.0), "1.0": (1.0, False, 1.0)}


@pytest.mark.parametrize(
    ("execute", "problem"),
    [
        (
            lambda goal: None,
            r"arm: what executes goals of /fetch has returned, but the goal is not over: call goal.succeed",
        ),
        (lambda goal: goal.cancel(), "Failed to update goal state: EXECUTING has no CANCELED"),
        (lambda goal: goal.succeed(hold=True), "Fetch_Result has no field 'hold'"),
        (lambda goal: goal.feedback(away=1.0), "Fetch_Feedback has no field 'away'"),
    ],
)
def test_a_mistake_of_what_executes_goals_is_said(execute: Callable[[Any], object], problem: str) -> None:
    run = cell()
    client = served(run, execute)
    with pytest.raises(NodeError, match=problem):
        run.run(lambda: client.call(1.0, part="leg"))
