"""Files from outside: limits, and errors with a place."""

from __future__ import annotations

import contextlib
import json
import os
import socket
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pytest_hricdv._base.input_file import MalformedError, from_cache, from_json, from_toml, read_text
from pytest_hricdv._base.message import MAX_MESSAGE, legible, quote
from tests.hanging import ends


def _socket(path: Path) -> None:
    server = socket.socket(socket.AF_UNIX)
    try:
        server.bind(str(path))
    finally:
        server.close()


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (Path.mkdir, ": a folder; expected a file"),
        (os.mkfifo, ": not a regular file but a pipe, socket or device; expected a file"),
        (_socket, ": not a regular file but a pipe, socket or device; expected a file"),
        (lambda path: path.symlink_to("/dev/zero"), ": not a regular file but a pipe, socket or device"),
        (lambda path: path.write_bytes(b"a\nb\xff"), ":2:2: not UTF-8 text: byte 0xff"),
        (lambda path: path.write_bytes(b"a" * 101), ": too large: 101 bytes; expected at most 100"),
    ],
    ids=["folder", "pipe", "socket", "device", "bytes", "large"],
)
def test_only_a_regular_file_of_text_is_read(tmp_path: Path, make: Callable[[Path], Any], told: str) -> None:
    path = tmp_path / "f"
    make(path)
    with pytest.raises(MalformedError) as raised:
        read_text(path, 100)
    assert str(raised.value).startswith(told)


def test_a_file_without_a_size_is_read_up_to_the_limit() -> None:
    with pytest.raises(MalformedError, match=r"too large: .* bytes; expected at most 10"):
        read_text(Path("/proc/self/status"), 10)


def test_line_ends_are_plain_and_a_byte_order_mark_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "f"
    path.write_bytes(b"\xef\xbb\xbfa\r\nb\rc\n")
    assert read_text(path) == "a\nb\nc\n"


DEEP = "nested too deeply; expected a depth of at most 64"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("[" * 100_000, f":1:65: {DEEP}"),
        ('{"a":\n' * 100_000, f":65:1: {DEEP}"),
        ('[1, "a", \n' + "1" * 5000 + "]", ":2:1: expected a number of at most 19 digits, got one of 5000"),
        ("[" + "1" * 401 + "]", ":1:2: expected a number of at most 19 digits, got one of 401"),
        ("[1e400]", ": Number out of range"),
        ("[0, Infinity]", ":1:5: expected a finite number, got Infinity"),
        ("[0, -Infinity]", ":1:5: expected a finite number, got -Infinity"),
        ("[NaN]", ":1:2: expected a finite number, got NaN"),
        ('[0, "NaN', ":1:5: not JSON, perhaps cut off"),
        ("", ":1:1: not JSON, perhaps cut off"),
        ("[\n1", ":2:2: not JSON, perhaps cut off"),
        ("[[1]]", ": Expected `int`, got `array` - at `$[0]`"),
    ],
    ids=lambda value: value[:20],
)
def test_json_of_another_kind_is_refused_with_its_place(text: str, told: str) -> None:
    with pytest.raises(MalformedError) as raised:
        from_json(text, list[int])
    assert str(raised.value).startswith(told)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a = " + "[" * 5000 + "]" * 5000, f":1:69: {DEEP}"),
        ("a = " + "{b = " * 900 + "1" + "}" * 900, f":1:325: {DEEP}"),
        (f"a.{'b.' * 900}c = 1", f":1:1: {DEEP}"),
        ("a = 1\n[x]\nb = {" + 'a . "b".' * 300_000 + "c = 1}", f":3:6: {DEEP}"),
        ("a = 1\nb = " + "9" * 5000, ":2:5: expected a number of at most 19 digits, got one of 5000"),
        ("[R1]\na = 1" + "0" * 400, ": expected at most 19 digits, got a number of about 401 digits - at `$.R1.a`"),
        ("a = [1.0, inf]", ": expected a finite number, got inf - at `$.a[1]`"),
        ("a = nan", ": expected a finite number, got nan - at `$.a`"),
        ("a = 1\nb =\n", ":2:4: not TOML: Invalid value"),
        ("a = 2021-02-31", ":1:"),
        ('a = "', ":1:"),
    ],
    ids=lambda value: value[:20],
)
def test_toml_of_another_kind_is_refused_with_its_place(text: str, told: str) -> None:
    with pytest.raises(MalformedError) as raised:
        from_toml(text)
    assert str(raised.value).startswith(told)


@given(st.text() | st.binary().map(lambda data: data.decode("utf-8", "replace")))
def test_any_text_is_read_or_refused(text: str) -> None:
    for read in (from_toml, lambda each: from_json(each, dict[str, list[float]])):
        with contextlib.suppress(MalformedError):
            read(text)


class _Cache:
    """As pytest's cache: what is no JSON is as if it were not there, other errors go through."""

    def __init__(self, text: str) -> None:
        self._text = text

    def get(self, key: str, default: object) -> object:
        try:
            return json.loads(self._text)
        except ValueError:
            return default


@pytest.mark.parametrize("text", ["[" * 100_000, "[" * 500 + "]" * 500, "[1e400]", "1" * 5000, "1" * 400, "{"])
def test_a_cache_that_cannot_be_read_is_empty(text: str) -> None:
    assert from_cache(_Cache(text), "k") is None


def test_a_message_is_short_and_has_its_beginning_and_end() -> None:
    with ends():
        text = legible("f.toml:1:1: " + "\x1b[31m\u202e" * 1_000_000 + "; expected a number")
    assert text.startswith("f.toml:1:1: \\x1b[31m\\u202e")
    assert text.endswith("; expected a number")
    assert len(text) <= MAX_MESSAGE


def repr_of(value: object) -> str:
    """The type of a parameter, whose own text may be too long."""
    return type(value).__name__


@pytest.mark.parametrize("value", ["x" * 10**6, 10**10_000, [10**10_000], ["x"] * 10**5, {"a": "\x1b"}], ids=repr_of)
def test_what_is_quoted_is_short(value: object) -> None:
    assert len(quote(value)) <= 82
    assert "\x1b" not in quote(value)


class _Part(msgspec.Struct):
    name: str
    size: int = 0


class _Whole(msgspec.Struct):
    parts: dict[str, list[_Part]]
    first: _Part | None = None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('{"parts": {}, "frist": null}', r"unknown key 'frist'; nearest: first.* - at `\$`"),
        ('{"parts": {"a": [{"name": "x", "siez": 1}]}}', r"'siez'; nearest: size - at `\$.parts.a\[0\]`"),
        ('{"parts": {}, "first": {"name": "x", "nam": 1}}', r"'nam'; nearest: name - at `\$.first`"),
    ],
)
def test_a_key_that_a_strict_file_does_not_have_is_refused(text: str, told: str) -> None:
    with pytest.raises(MalformedError, match=told):
        from_json(text, _Whole, strict=True)
    assert from_json(text, _Whole).parts is not None
