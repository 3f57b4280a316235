"""The text of an error of somebody else's code."""

from __future__ import annotations

import pytest

from pytest_hricdv._base.error_text import error_text


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


def _failing_while_handling(*, hides: bool) -> None:
    try:
        {}["rig"]
    except KeyError:
        if hides:
            raise RuntimeError from None
        raise RuntimeError  # noqa: B904


@pytest.mark.parametrize(("hides", "text"), [(False, "RuntimeError, from KeyError: 'rig'"), (True, "RuntimeError")])
def test_what_was_handled_counts_unless_it_was_put_away(hides: bool, text: str) -> None:
    with pytest.raises(RuntimeError) as raised:
        _failing_while_handling(hides=hides)
    assert error_text(raised.value) == text
