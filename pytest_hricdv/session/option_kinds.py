"""The kinds of options that pytest's command line and ini file have for this plugin."""

from __future__ import annotations

from dataclasses import dataclass

import pytest


@dataclass(frozen=True)
class Value:
    """An option `--hri-NAME` with one value; its ini key has the default."""

    name: str
    metavar: str
    help: str
    key: bool = True

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", metavar=self.metavar, help=self.help)
        if self.ini:
            parser.addini(self.ini, f"default of --hri-{self.name}", default="")

    @property
    def ini(self) -> str:
        """Its key in the ini file; empty where it has none."""
        return _ini_name(self.name) if self.key else ""


@dataclass(frozen=True)
class Flag:
    """An option `--hri-NAME` without a value; its ini key, of the type bool, has the default."""

    name: str
    help: str
    key: bool = True

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", action="store_true", default=None, help=self.help)
        if self.ini:
            parser.addini(self.ini, f"default of --hri-{self.name}", "bool", default=False)

    @property
    def ini(self) -> str:
        """Its key in the ini file; empty where it has none."""
        return _ini_name(self.name) if self.key else ""


@dataclass(frozen=True)
class Repeatable:
    """An option `--hri-NAME` that may be given several times; its ini key has one entry a line.

    Args:
        key_help: of the ini key.
        key: of the ini file, where it is not the option's name.
    """

    name: str
    metavar: str
    help: str
    key_help: str
    key: str = ""

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", metavar=self.metavar, action="append", help=f"{self.help}; repeatable")
        parser.addini(self.ini, self.key_help, "linelist")

    @property
    def ini(self) -> str:
        """Its key in the ini file."""
        return self.key or _ini_name(self.name)


def _ini_name(name: str) -> str:
    return f"hri_{name.replace('-', '_')}"


Option = Value | Flag | Repeatable
