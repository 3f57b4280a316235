"""Native values of TOML: pytest 9 hands numbers, booleans and lists of its TOML files on as they are.

In each other file all values are texts. So that a key means the same in all of them, they become what they would be
there, before anything reads them: pytest itself refuses a number where a text is declared.
"""

from __future__ import annotations

import dataclasses
import datetime
import shlex
from typing import Any

import pytest

from pytest_hricdv.session.option import Flag, Repeatable
from pytest_hricdv.session.option_table import TESTPATHS, all_options
from pytest_hricdv.session.usage import usage_error

_TRUTH = {
    **dict.fromkeys(("1", "yes", "true", "on"), True),
    **dict.fromkeys(("0", "no", "false", "off"), False),
}
"""As pytest reads the word in an ini file."""


def adapt(config: pytest.Config) -> None:
    """Adapt the values of all keys of this plugin, once.

    Raises:
        pytest.UsageError: a value that no ini file could have, such as a table.
    """
    values = getattr(config, "_inicfg", None)  # of pytest 9; before, there were texts only
    if not isinstance(values, dict):
        return
    kinds: dict[str, Any] = {option.ini: option for option in all_options() if option.ini}
    for key in (*kinds, TESTPATHS):
        entry: Any = values.get(key)
        if getattr(entry, "mode", "") != "toml":
            continue
        try:
            value = _adapted(key, kinds.get(key), entry.value)
        except ValueError as error:
            raise usage_error(f"{config.inipath}: {key}: {error}") from None
        values[key] = dataclasses.replace(entry, value=value)


def _adapted(key: str, kind: object, value: object) -> object:
    if key == TESTPATHS:
        return shlex.split(value) if isinstance(value, str) else [_text(entry) for entry in _listed(value)]
    if isinstance(kind, Flag):
        return _flag(value)
    if isinstance(kind, Repeatable):
        lines = value.splitlines() if isinstance(value, str) else _listed(value)
        return [line for entry in lines if (line := _text(entry).strip())]
    return ",".join(_text(entry) for entry in _listed(value))


def _listed(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, str | int | float):
        return str(value)
    kind = "a table" if isinstance(value, dict) else "a list in a list" if isinstance(value, list) else "that"
    raise ValueError(f"expected a text, a number or a list of these; {kind} has no place here: {value!r}")


def _flag(value: object) -> bool:
    if isinstance(value, bool):
        return value
    word = value.strip().lower() if isinstance(value, str) else ""
    if word not in _TRUTH:
        raise ValueError(f"expected true or false, got {value!r}")
    return _TRUTH[word]
