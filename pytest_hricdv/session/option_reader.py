"""Reads options: the command line wins over the ini file, and each value is checked."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from pytest_hricdv.session.usage import usage_error

MAX_INTEGER = 2**63 - 1
"""Of an option: seeds have 63 bits, and nothing else needs more."""


@dataclass(frozen=True)
class OptionReader:
    """The options of a session. Names are those of the ini keys without `hri_`, as `mutate_tests`."""

    config: pytest.Config

    def named(self, name: str) -> object:
        """What the command line has; None where it does not name the option."""
        return self.config.getoption(f"hri_{name}")

    def text(self, name: str) -> str:
        """A text without spaces around it; empty where there is none."""
        value = self.named(name)
        return str(self.config.getini(f"hri_{name}") if value is None else value).strip()

    def texts(self, name: str) -> tuple[str, ...]:
        """Those of the ini file, one a line, and then those of the command line, of an option that is repeatable."""
        value = self.named(name)
        of_command = value if isinstance(value, list) else []
        return tuple(str(text) for text in [*self.config.getini(f"hri_{name}"), *of_command])

    def flag(self, name: str) -> bool:
        """Whether a flag is set."""
        value = self.named(name)
        try:
            return bool(self.config.getini(f"hri_{name}") if value is None else value)
        except ValueError as error:  # before pytest 9.2, which says it as well as this
            raise usage_error(f"{self.config.inipath}: hri_{name}: expected true or false; {error}") from None

    def integer(self, name: str, default: int | None, least: int | None, most: int = MAX_INTEGER) -> int | None:
        """A whole number.

        Args:
            default: where there is none.
            least: the least one allowed; None: any that has 63 bits.
            most: the greatest one allowed.

        Raises:
            pytest.UsageError: it is no whole number, or out of range.
        """
        text, option = self.text(name), f"--hri-{name.replace('_', '-')}"
        if not text:
            return default
        try:
            value = int(text if text.isascii() else "")
        except ValueError:
            raise usage_error(f"{option}={text}: expected a whole number") from None
        least = -MAX_INTEGER if least is None else least
        if not least <= value <= most:
            expected = f"at least {least}" if value < least else f"at most {most}"
            raise usage_error(f"{option}={text}: expected {expected}")
        return value

    def file(self, name: str) -> Path | None:
        """A file as it is named, relative to where pytest was started; of the ini file, relative to that."""
        folder = self.config.rootpath if self.named(name) is None else self.config.invocation_params.dir
        text = self.text(name)
        return folder / text if text else None
