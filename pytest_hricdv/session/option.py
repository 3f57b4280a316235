"""Kinds of pytest options (`Flag`, `Value`, `Repeatable`), and the `OptionReader` that reads and checks their values.

`option_table` declares the core's options by them, and each feature its own, in `FeatureOptions`. `read_options` and
the features read them. `usage_error` makes the error for a wrong value.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol, TypeVar, cast, overload

import pytest

from pytest_hricdv._base.message import legible
from pytest_hricdv.registry import offers

if TYPE_CHECKING:
    from pytest_hricdv.testbench import Testbench


def usage_error(text: str) -> pytest.UsageError:
    """The error that pytest prints as it is, ending with status 4; legible, whatever the text quotes."""
    return pytest.UsageError(legible(text))


def locate_error(error: BaseException) -> str:
    """An error with its deepest place outside of this plugin and of installed packages."""
    trace, place = error.__traceback__, ""
    while trace is not None:
        code = trace.tb_frame.f_code
        file = Path(code.co_filename)
        if "site-packages" not in file.parts and _PACKAGE not in file.parents and not code.co_filename.startswith("<"):
            place = f"{file}:{trace.tb_lineno}: {code.co_name}: "
        trace = trace.tb_next
    return f"{place}{type(error).__name__}: {error}"


_PACKAGE = Path(__file__).parents[1]


MAX_INTEGER = 2**63 - 1
"""Greatest integer of an option: seeds have 63 bits, and nothing else needs more."""

FAIL_ON = "fail-on"
"""The option that names flags which begin with it: `--hri-fail-on=nc` sets `fail-on-nc`."""

_FAIL_ON = "fail_on_"

Settings = TypeVar("Settings")


@dataclass(frozen=True)
class Value:
    """An option `--hri-NAME` with one value; its ini key has the default. `shown`: in `pytest --help`."""

    name: str
    metavar: str
    help: str
    key: bool = True
    shown: bool = True

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", metavar=self.metavar, help=_help_text(self))
        if self.ini:
            parser.addini(self.ini, f"default of --hri-{self.name}", default="")

    @property
    def ini(self) -> str:
        """Its key in the ini file; empty if it has none."""
        return _ini_name(self.name) if self.key else ""


@dataclass(frozen=True)
class Flag:
    """An option `--hri-NAME` without a value; its ini key, of the type bool, has the default."""

    name: str
    help: str
    key: bool = True
    shown: bool = True

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", action="store_true", default=None, help=_help_text(self))
        if self.ini:
            parser.addini(self.ini, f"default of --hri-{self.name}", "bool", default=False)

    @property
    def ini(self) -> str:
        """Its key in the ini file; empty if it has none."""
        return _ini_name(self.name) if self.key else ""


@dataclass(frozen=True)
class Repeatable:
    """An option `--hri-NAME` that may be given several times; its ini key has one entry a line.

    Args:
        key_help: help text of the ini key.
        key: the key of the ini file, where it is not the option's name.
    """

    name: str
    metavar: str
    help: str
    key_help: str
    key: str = ""
    shown: bool = True

    def add(self, group: pytest.OptionGroup, parser: pytest.Parser) -> None:
        """Register option and key."""
        group.addoption(f"--hri-{self.name}", metavar=self.metavar, action="append", help=_help_text(self))
        parser.addini(self.ini, self.key_help, "linelist")

    @property
    def ini(self) -> str:
        """Its key in the ini file."""
        return self.key or _ini_name(self.name)


def _help_text(option: Option) -> str:
    """The help text in `pytest --help`; the reference has all options."""
    return option.help if option.shown else argparse.SUPPRESS


def _ini_name(name: str) -> str:
    return f"hri_{name.replace('-', '_')}"


Option = Value | Flag | Repeatable

OptionGroup = Literal["tests", "verdict", "after", "files"]


@dataclass(frozen=True)
class OptionReader:
    """The options of a session. Names are those of the ini keys without `hri_`, as `mutate_tests`."""

    config: pytest.Config

    def command_line_value(self, name: str) -> object:
        """The value on the command line; None if the option is missing."""
        return self.config.getoption(f"hri_{name}")

    def text(self, name: str) -> str:
        """A text without spaces around it; empty if there is none."""
        value = self.command_line_value(name)
        return str(self.config.getini(f"hri_{name}") if value is None else value).strip()

    def setting(self, name: str) -> str:
        """An option and its value as they were given: `--hri-seed=7`, or `hri_seed = 7` of an ini file."""
        text = self.text(name)
        if self.command_line_value(name) is None:
            return f"hri_{name} = {text}"
        return f"--hri-{name.replace('_', '-')}={text}"

    def texts(self, name: str) -> tuple[str, ...]:
        """The values of a repeatable option: first of the ini file, one per line, then of the command line."""
        value = self.command_line_value(name)
        of_command = value if isinstance(value, list) else []
        return tuple(str(text) for text in [*self.config.getini(f"hri_{name}"), *of_command])

    def words(self, name: str) -> tuple[str, ...]:
        """The words of an option whose value has them between commas."""
        return tuple(word.strip() for word in self.text(name).split(",") if word.strip())

    def flag(self, name: str) -> bool:
        """Whether a flag is set, also by `--hri-fail-on` if that can name it."""
        if name.startswith(_FAIL_ON) and name.removeprefix(_FAIL_ON) in self.words(FAIL_ON.replace("-", "_")):
            return True
        value = self.command_line_value(name)
        try:
            return bool(self.config.getini(f"hri_{name}") if value is None else value)
        except (ValueError, pytest.UsageError) as error:  # neither names the key; from pytest 9.2 on, it is the latter
            raise usage_error(f"{self.config.inipath}: hri_{name}: expected true or false; {error}") from None

    @overload
    def integer(self, name: str, default: int, minimum: int, maximum: int = ...) -> int: ...
    @overload
    def integer(self, name: str, default: None, minimum: int, maximum: int = ...) -> int | None: ...
    def integer(self, name: str, default: int | None, minimum: int, maximum: int = MAX_INTEGER) -> int | None:
        """A whole number from `minimum` to `maximum`, or `default` where the option is not set.

        Raises:
            pytest.UsageError: the value is not a whole number or out of range.
        """
        text = self.text(name)
        if not text:
            return default
        try:
            value = int(text if text.isascii() else "")
        except ValueError:
            raise usage_error(f"{self.setting(name)}: expected a whole number") from None
        if not minimum <= value <= maximum:
            expected = f"at least {minimum}" if value < minimum else f"at most {maximum}"
            raise usage_error(f"{self.setting(name)}: expected {expected}")
        return value

    def file(self, name: str) -> Path | None:
        """A file as it is named, relative to where pytest was started; of the ini file, relative to that."""
        folder = self.config.rootpath if self.command_line_value(name) is None else self.config.invocation_params.dir
        text = self.text(name)
        return folder / text if text else None


class HasFeatures(Protocol):
    """Options of a session, with those of the features."""

    @property
    def features(self) -> Mapping[str, Any]:
        """Feature -> its settings."""


class FeatureOptions(Generic[Settings]):
    """The options of a feature; by default there are none.

    Attributes:
        name: the name of the feature's folder.
        options: the options that it adds to pytest's.
        group: the group of `pytest --help` that lists them.
        kinds: the kinds of thresholds that it adds to `--hri-fail-under`.
        suites: names of suites that it generates, given the others.
        switched_off: option -> value, by destination, as in a process that only runs tests again for another feature.
    """

    name = ""
    options: Sequence[Option] = ()
    group: OptionGroup = "after"
    kinds: tuple[str, ...] = ()
    suites: tuple[str, ...] = ()
    switched_off: Mapping[str, object] = {}

    def read(self, reader: OptionReader) -> Settings | None:
        """Its settings; None if there are none. Raises pytest.UsageError for an invalid one."""
        return None

    def asks_for_suites(self, reader: OptionReader) -> bool:
        """Whether an option of it asks for its suites, which `--hri-suite` then need not name."""
        return False

    def settings(self, options: HasFeatures) -> Settings:
        """The settings that `read` returned."""
        return cast("Settings", options.features[self.name])

    def rerun_options(self, reader: OptionReader) -> Iterable[str]:
        """Options of the command line that decide which tests are generated and which fail."""
        return ()

    def configure(self, testbench: Testbench, options: HasFeatures) -> Testbench:
        """The testbench as its options have it. Raises TestbenchError if it cannot be that."""
        return testbench

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """Settings that results depend on, by option: a session that is resumed must have the same."""
        return {}


def feature_suites() -> frozenset[str]:
    """Names of all suites that features generate."""
    return frozenset(name for feature in feature_options() for name in feature.suites)


def feature_options() -> tuple[FeatureOptions[Any], ...]:
    """The options of all features."""
    return offers("feature", "FEATURE")
