"""The text of an error of somebody else's code."""

from __future__ import annotations

import traceback
from typing import Any

import pytest

from pytest_hricdv._base import error_text as module
from pytest_hricdv._base.error_text import MAX_CAUSES, causes, error_text, shorten, text_of
from pytest_hricdv._base.message import InputError


class OddError(Exception):
    """Cannot be written."""

    def __str__(self) -> str:
        raise AttributeError("no text")


def _chained(error: BaseException, *causes: BaseException) -> BaseException:
    for outer, inner in zip((error, *causes), causes, strict=False):
        outer.__cause__ = inner
    return error


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (ValueError("no dimmer"), "ValueError: no dimmer"),
        (ValueError(), "ValueError"),
        (ValueError("two\nlines"), "ValueError: two lines"),
        (KeyError("rig"), "KeyError: 'rig'"),
        (OddError(), "OddError: (its text raised AttributeError)"),
        (_chained(RuntimeError("cannot serve"), KeyError("rig")), "RuntimeError: cannot serve, from KeyError: 'rig'"),
        (
            _chained(ValueError(1), ValueError(2), ValueError(3), ValueError(4)),
            "ValueError: 1, from ValueError: 2, from ValueError: 3",
        ),
        (
            ExceptionGroup("all", [ExceptionGroup("hall", [ValueError("a"), OSError("b")]), TypeError("c")]),
            "ExceptionGroup: all (2 sub-exceptions): ValueError: a; OSError: b; TypeError: c",
        ),
        (
            ExceptionGroup("all", [ValueError(number) for number in range(6)]),
            "ExceptionGroup: all (6 sub-exceptions): ValueError: 0; ValueError: 1; ValueError: 2; ValueError: 3; "
            "and 2 more",
        ),
    ],
)
def test_it_says_what_it_stands_for(error: BaseException, text: str) -> None:
    assert error_text(error) == text


class WordedError(Exception):
    """Has a text of its own."""

    def __str__(self) -> str:
        return f"rig {'y' * 3_000_000} end"


def _chain() -> BaseException:
    error = RuntimeError("z" * 3_000_000)
    error.__cause__ = ValueError("cause " + "x" * 3_000_000)
    return error


LONG: dict[str, BaseException] = {
    "a builtin": ValueError("begin " + "x" * 3_000_000 + " end"),
    "a key": KeyError("x" * 3_000_000),
    "a text of its own": WordedError(),
    "several arguments": ValueError("x" * 3_000_000, "y" * 3_000_000),
    "a chain": _chain(),
    "a group": ExceptionGroup("x" * 3_000_000, [ValueError("y" * 3_000_000)]),
    "an assertion": AssertionError("x" * 3_000_000),
}


@pytest.mark.parametrize("error", LONG.values(), ids=LONG)
def test_a_text_of_megabytes_is_cut_in_errors_and_what_pytest_writes_of_them(error: BaseException) -> None:
    assert len(error_text(error)) < 10_000
    kind = type(error)
    error.add_note("n" * 3_000_000)
    shorten(error)
    assert isinstance(error, kind)
    assert len("".join(traceback.format_exception(error))) < 150_000
    assert "characters are left out here" in str(error)


def test_of_thousands_of_causes_some_are_shown() -> None:
    error = ValueError("first")
    for number in range(5000):
        outer = ValueError(str(number))
        outer.__context__, error = error, outer
    shorten(error)
    assert len([*causes(error)]) == MAX_CAUSES


class EndlessError(Exception):
    """Says its text without end, and catches what is raised in it."""

    def __str__(self) -> str:
        while True:
            try:
                while True:
                    pass
            except BaseException:
                pass

    __repr__ = __str__


class LeavingError(Exception):
    """Ends the process instead of saying its text."""

    def __str__(self) -> str:
        raise SystemExit(0)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (EndlessError(), "its text takes more than 0.05 s"),
        (KeyError(EndlessError()), "its text takes more than 0.05 s"),
        (LeavingError(), "its text raised SystemExit"),
    ],
)
def test_pytest_can_write_any_error(error: BaseException, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TEXT_WITHIN_S", 0.05)
    kind = type(error)
    assert f"{kind.__name__}: ({text})" in error_text(error)
    assert shorten(error) is error
    assert isinstance(error, kind)
    assert text in traceback.format_exception(error)[-1]
    assert text in repr(error)


def test_any_value_has_a_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "TEXT_WITHIN_S", 0.05)
    assert text_of([1, "a"], repr) == "[1, 'a']"
    assert text_of(EndlessError(), repr) == "(its text takes more than 0.05 s)"
    assert len(text_of("x" * 3_000_000)) < 3_000


def test_frames_that_raise_an_error_of_this_package_are_hidden() -> None:
    ours: dict[str, Any] = {"__name__": "pytest_hricdv.somewhere", "InputError": InputError}
    exec("def refuse(): raise InputError('no such thing')", ours)
    with pytest.raises(InputError) as raised:
        ours["refuse"]()
    shorten(raised.value)
    frames = [frame for frame, _ in traceback.walk_tb(raised.value.__traceback__)]
    assert ["__tracebackhide__" in frame.f_locals for frame in frames] == [False, True]
