"""Chosen values: parameters fixed by a test instead of drawn from their ranges.

They are kept by the number of their command, from 1, as in `# values 3: distance_m 0.55`; number 0 is the run, written
`run` in text and JSON. `AbstractTest` checks them with `check`; `suite_files` reads and writes them (`read_text`,
`to_text`), reports write them with `to_data`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError

#: Number of the command (from 1; 0 is the run) -> parameter -> value, in the unit of the parameter's name.
Values = Mapping[int, Mapping[str, float]]

RUN = 0
_RUN_KEY = "run"
# Six digits: more than any test has commands, and int() of thousands of digits takes its time.
_NUMBER = re.compile(r"[1-9]\d{0,5}\Z", re.ASCII)


def check(values: Values, commands: int) -> None:
    """Check that values belong to a test with that many commands and have a text form.

    Raises:
        GenerateError: there is no such command, it has no value, a name is not a word, or a value is not a finite
            number.
    """
    for number, chosen in values.items():
        where = owner(number)
        if not 0 <= number <= commands:
            raise GenerateError(f"values of {where}: the test has {commands} commands only; expected one of these")
        if not chosen:
            raise GenerateError(f"values of {where}: there are none; expected at least one, or no entry")
        for name, value in chosen.items():
            if name.split() != [name] or "," in name:
                raise GenerateError(f"values of {where}: parameter {name!r}: expected one word without a comma")
            # A bool is an int: True would silently be read as 1.0.
            if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
                raise GenerateError(f"values of {where}: {name} is {value!r}; expected a finite number")


def owner(number: int) -> str:
    """The owner of these values, for people: `the run` or `command 3`."""
    return "the run" if number == RUN else f"command {number}"


def to_data(values: Values) -> dict[str, dict[str, float]]:
    """Plain data for JSON, the same for equal values; the keys are those of the text format."""
    return {
        _RUN_KEY if number == RUN else str(number): {
            name: float(values[number][name]) for name in sorted(values[number])
        }
        for number in sorted(values)
    }


def from_data(data: Mapping[str, Mapping[str, float]]) -> dict[int, dict[str, float]]:
    """The values that `to_data` gave. Raises GenerateError: a key that is neither `run` nor the number of a command."""
    return {read_key(key): {str(name): float(value) for name, value in chosen.items()} for key, chosen in data.items()}


def to_text(values: Values) -> dict[str, str]:
    """Key -> values, as in `3` -> `grip_s 31.5, pull_n 8.25`; floats are exact."""
    return {
        key: ", ".join(f"{name} {value!r}" for name, value in chosen.items()) for key, chosen in to_data(values).items()
    }


def read_key(key: str) -> int:
    """The number that a key stands for. Raises GenerateError if it stands for none."""
    if key == _RUN_KEY:
        return RUN
    if _NUMBER.match(key) is None:
        raise GenerateError(f"values of {quote(key)}: expected {_RUN_KEY!r} or the number of a command, from 1")
    return int(key)


def read_text(text: str) -> dict[str, float]:
    """The values in a text such as `pull_n 8.25, grip_s 31.5`. Raises GenerateError for any other text."""
    values: dict[str, float] = {}
    for part in text.split(","):
        name, _, number = part.strip().partition(" ")
        try:
            value = float(number)
        except ValueError:
            expected = "expected a parameter and a number, as in 'pull_n 8.25, grip_s 31.5'"
            raise GenerateError(f"{quote(part.strip())} is not a value; {expected}") from None
        if name in values:
            raise GenerateError(f"a second value of {quote(name)}; expected each parameter once")
        values[name] = value
    return values
