"""Redirected functions are the same objects, and call something else."""

from __future__ import annotations

import gc
import inspect
import math
import os
import pickle
import platform
import sys
import time
from collections.abc import Iterator
from typing import Any

import pytest

from pytest_hricdv.runtime import redirection
from pytest_hricdv.runtime.redirection import Redirection, original

hypot: Any = vars(math)["hypot"]


def fake(*numbers: float, power: int = 2) -> tuple[float, ...]:
    if not numbers:
        raise KeyError("no numbers")
    return (*numbers, power)


class Arm(list[float]):
    def __init__(self, speed: float = 2.0, *, reach: float = 3.0) -> None:
        super().__init__([speed])  # so it has a variable of a closure
        self.reach = reach


make, make_as_before = Arm.__init__, original(Arm.__init__)


def make_faster(arm: Arm, speed: float = 4.0) -> None:
    make_as_before(arm, 2 * speed)


PRICES = {"first": 1, math.hypot: 2, "last": 3}
SHAPES = {math.hypot, math.sqrt}
REDIRECTION = Redirection([(math.hypot, fake), (make, make_faster), (int, print)])


@pytest.fixture
def redirected() -> Iterator[None]:
    REDIRECTION.install()
    try:
        yield
    finally:
        REDIRECTION.remove()


def call_often() -> list[object]:
    return [hypot(3.0, 4.0) for _ in range(1000)]


@pytest.mark.usefixtures("redirected")
def test_whoever_has_the_function_calls_the_other_one() -> None:
    assert vars(math)["hypot"] is hypot
    assert (hypot(1), hypot(1, power=3), list(map(hypot, [5]))) == ((1, 2), (1, 3), [(5, 2)])
    assert call_often()[-1] == (3.0, 4.0, 2)  # also where Python has specialized the call
    assert ([*Arm()], [*Arm(5.0)], Arm(speed=6.0).reach, Arm.__init__) == ([8.0], [10.0], 3.0, make)
    assert int("3") == 3  # no function
    with pytest.raises(KeyError, match="no numbers"):
        hypot()


@pytest.mark.usefixtures("redirected")
def test_it_seems_to_be_what_it_was() -> None:
    text, name = hypot.__doc__, (hypot.__name__, hypot.__qualname__, hypot.__module__)
    assert repr(hypot) == "<built-in function hypot>"
    assert name == ("hypot", "hypot", "math")
    assert text is not None
    assert "Euclidean" in text
    assert inspect.isbuiltin(hypot)
    assert pickle.loads(pickle.dumps(hypot)) is hypot


@pytest.mark.usefixtures("redirected")
def test_where_it_was_a_key_before_it_still_is_one() -> None:
    assert [*PRICES] == ["first", math.hypot, "last"]
    assert PRICES[math.hypot] == 2
    assert math.hypot in SHAPES
    assert all(function in os.supports_fd for function in os.supports_fd)


def test_afterwards_it_does_what_it_did_before() -> None:
    entries = {hypot: 1}
    for _ in range(3):
        REDIRECTION.install()
        REDIRECTION.install()
        REDIRECTION.remove()
        assert hypot(3, 4) == (3, 4, 2 * entries[hypot])  # it keeps its hash
        REDIRECTION.remove()
        gc.collect()
        assert call_often() == [5.0] * 1000
        assert ([*Arm()], Arm(reach=1.0).reach) == ([2.0], 1.0)
    with pytest.raises(TypeError, match="must be real number"):
        hypot("3")


@pytest.mark.usefixtures("redirected")
def test_the_original_is_never_redirected() -> None:
    assert original(time.sleep) is not time.sleep
    assert original(math.sqrt)(16.0) == 4.0
    assert original(int) is int  # no function


def test_a_python_with_other_functions_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "_is_gil_enabled", lambda: False, raising=False)
    with pytest.raises(RuntimeError, match=rf"{platform.python_version()} keeps functions in C; expected CPython"):
        redirection._check()
