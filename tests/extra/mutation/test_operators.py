"""Each operator makes the faults that it is there for, and none where it should not."""

from __future__ import annotations

from pathlib import Path

import pytest

from pytest_hricdv.extra.mutation.mutants import OPERATORS
from tests.extra.mutation.robots import mutants_of

EXAMPLES = {
    "message dropped": ("def f(bus):\n    bus.publish(1)", {"without bus.publish(1)"}),
    "wait skipped": ("def f(clock):\n    clock.sleep(1)", {"without clock.sleep(1)"}),
    "reset forgotten": ("def f(queue):\n    queue.clear()", {"without queue.clear()"}),
    "call dropped": (
        "def f(arm):\n    arm.go_home()\n    arm.sleep()\n    await_all()",
        {"without arm.go_home()", "without await_all()"},
    ),
    "call repeated": ("def f(arm, clock):\n    arm.go_home()\n    clock.sleep(1)", {"arm.go_home(); arm.go_home()"}),
    "order exchanged": (
        "def f(arm, hand):\n    arm.go()\n    hand.shut()\n    x = arm.where()\n    hand.to(x)",
        {"hand.shut()\narm.go()", "x = arm.where()\nhand.shut()"},
    ),
    "time or speed scaled": (
        "def f(clock, settle_s=2.0, legs=4):\n    clock.sleep(legs + 1)",
        {
            "def f(clock, settle_s=2.0 * 0.1, legs=4):",
            "def f(clock, settle_s=2.0 * 10, legs=4):",
            "clock.sleep((legs + 1) * 0.1)",
            "clock.sleep((legs + 1) * 10)",
        },
    ),
    "assignment forgotten": (
        "class A:\n    def __init__(self):\n        self.n = 0\n    def g(self):\n        self.n += 1",
        {"without self.n += 1"},
    ),
    "command reversed": (
        "def f(hand, queue):\n    hand.open()\n    hand.close()\n    queue.close()",
        {"hand.close()", "hand.open()"},
    ),
    "lock removed": (
        "def f(self, file):\n    with self.state_lock, file:\n        return 1",
        {'with __import__("contextlib").nullcontext(), file:'},
    ),
    "condition negated": ("def f(x):\n    if x:\n        return 1", {"if not (x):"}),
    "off by one": (
        "def f(n):\n    for i in range(n):\n        g(7)",
        {"for i in range(n - 1):", "for i in range(n + 1):", "g((6))"},
    ),
    "loop left early": ("def f(n):\n    for i in n:\n        g(i)", {"for i in n: ... break"}),
    "returned early": ("def f(a):\n    '''Doc.'''\n    a.x()\n    a.y()\n    a.z()", {"return"}),
    "number plus one": ("def f():\n    return 2.5", {"return 3.5"}),
    "true or false": ("def f():\n    return True", {"return False"}),
    "another operator": ("def f(a, b):\n    return a < b", {"return a <= b"}),
    "another keyword": ("def f(a):\n    return a is None", {"return a is not None"}),
    "negation removed": ("def f(a):\n    return not a", {"return a"}),
    "set instead of added": ("def f(a):\n    a += 2\n    return a", {"a = 2"}),
    "choice fixed": (
        "def f(a):\n    return 1 if a else 2",
        {"return 1 if (a) and False else 2", "return 1 if (a) or True else 2"},
    ),
    "case removed": (
        "def f(a):\n    match a:\n        case 1: g()\n        case 2: h()",
        {"without case 1: g()", "without case 2: h()"},
    ),
}


@pytest.mark.parametrize("operator", sorted(OPERATORS.keys() - {"states swapped"}))
def test_an_operator_makes_its_faults(operator: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text, expected = EXAMPLES[operator]
    found = [each for each in mutants_of(text, tmp_path, monkeypatch) if each.operator == operator]
    assert {f"without {each.before}" if each.after in ("pass", "") else each.after for each in found} == expected


STATES = """
    from enum import Enum
    IDLE = "idle"
    BUSY = "busy"
    DONE = "done"
    ALL = (IDLE, BUSY, DONE)
    NEXT = {"a": "go", "b": "stop", "c": "stop"}

    class Mode(Enum):
        SLOW = 1
        FAST = 2

    def act(robot) -> str:
        robot.state = BUSY
        robot.mode = Mode.SLOW
        if robot.tired:
            robot.said = "tired"
            return "rest"
        robot.said = "fit"
        return "work"
"""


def test_states_are_swapped_within_their_table_function_enumeration_and_group(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = mutants_of(STATES, tmp_path, monkeypatch)
    assert [(each.before, each.after) for each in found if each.operator == "states swapped"] == [
        ('NEXT = {"a": "go", "b": "stop", "c": "stop"}', 'NEXT = {"a": "stop", "b": "stop", "c": "stop"}'),
        ('NEXT = {"a": "go", "b": "stop", "c": "stop"}', 'NEXT = {"a": "go", "b": "go", "c": "stop"}'),
        ('NEXT = {"a": "go", "b": "stop", "c": "stop"}', 'NEXT = {"a": "go", "b": "stop", "c": "go"}'),
        ("robot.state = BUSY", "robot.state = 'done'"),
        ("robot.mode = Mode.SLOW", "robot.mode = Mode.FAST"),
        ('robot.said = "tired"', "robot.said = 'fit'"),
        ('return "rest"', "return 'work'"),
        ('robot.said = "fit"', "robot.said = 'tired'"),
        ('return "work"', "return 'rest'"),
    ]


LEFT_ALONE = '''
    """Three things: 1, 2, 3."""
    from typing import TYPE_CHECKING, Literal, TypeVar
    from dataclasses import dataclass
    if TYPE_CHECKING:
        WIDTH = 3
    T = TypeVar("T", covariant=True)

    @dataclass(frozen=True)
    class Pose:
        """One pose of 7."""
        joint: "Literal[1, 2]"

        def far(self) -> Literal[4]: ...

    def act(robot, joint: Literal[5]):
        """Acts for 3 s."""
        robot.note("joint", 7)
        robot.wait(9)  # unreachable: nobody waits
'''


def test_what_changes_nothing_or_cannot_run_is_left_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert mutants_of(LEFT_ALONE, tmp_path, monkeypatch) == ()


def test_a_message_is_not_moved_before_what_it_tells_is_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = "def f(bus, arm):\n    where = arm.pose()\n    bus.publish(where)\n    arm.rest()"
    found = [each for each in mutants_of(text, tmp_path, monkeypatch) if each.operator == "order exchanged"]
    assert [each.after for each in found] == ["arm.rest()\nbus.publish(where)"]
