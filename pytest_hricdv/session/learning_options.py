"""`LearningOptions`, for `read_options`: options of learning the suite `rl`, which override the testbench's."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from pytest_hricdv.session.option import OptionReader, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.generate.qlearning import QLearning, WarmStart
    from pytest_hricdv.testbench import Testbench

METHOD = "rl"
"""The name of the method that learns."""


@dataclass(frozen=True)
class LearningOptions:
    """Options of learning, as given.

    Args:
        settings: (source, NAME=VALUE), in order.
        reward: name of the reward; empty: the default.
        start: the file to start from.
        save: the file to save the table in.
        named: options of learning on the command line, which make no sense without learning.
    """

    settings: tuple[tuple[str, str], ...] = ()
    reward: str = ""
    start: Path | None = None
    save: Path | None = None
    named: tuple[str, ...] = ()

    @property
    def again(self) -> tuple[str, ...]:
        """Options of the command line that decide which tests are generated."""
        return tuple(option for option in self.named if not option.startswith("--hri-rl-save"))


def read_learning(config: pytest.Config) -> LearningOptions:
    """The options of the ini file and the command line."""
    reader = OptionReader(config)
    lines: Sequence[str] = config.getoption("hri_rl") or ()
    given = [name for name in ("rl_reward", "rl_start", "rl_save") if reader.command_line_value(name) is not None]
    settings = [(f"hri_rl: {line}", line) for line in config.getini("hri_rl")]
    return LearningOptions(
        settings=(*settings, *((f"--hri-rl={line}", line) for line in lines)),
        reward=reader.text("rl_reward"),
        start=reader.file("rl_start"),
        save=reader.file("rl_save"),
        named=(*(f"--hri-rl={line}" for line in lines), *map(reader.setting, given)),
    )


def parameters(options: LearningOptions, testbench: Testbench) -> QLearning:
    """The effective constants of learning.

    Raises:
        pytest.UsageError: an unknown constant or reward, or a value out of range.
    """
    from pytest_hricdv.generate import GenerateError

    constants = testbench.suites.learning
    for where, line in options.settings:
        try:
            constants = replace(constants, **_setting(line))
        except GenerateError as error:
            raise usage_error(f"{where}: {error}") from None
    if options.reward:
        try:
            constants = replace(constants, reward=options.reward)
        except GenerateError as error:
            raise usage_error(f"--hri-rl-reward={options.reward}: {error}") from None
    return constants


def warm_start(options: LearningOptions, testbench: Testbench) -> WarmStart:
    """The start of learning: a saved table, or belief sets.

    Raises:
        pytest.UsageError: the file cannot be read, or is not for this testbench.
    """
    from pytest_hricdv.generate import GenerateError
    from pytest_hricdv.generate.qlearning import COLD_START

    if options.start is None:
        return COLD_START
    from pytest_hricdv.generate.saved_table import read_warm_start

    try:
        return read_warm_start(options.start, testbench.model, testbench.beliefs)
    except GenerateError as error:
        raise usage_error(f"--hri-rl-start: {error}") from None


def _setting(line: str) -> dict[str, Any]:
    """The constant of a line, by name."""
    from pytest_hricdv._base.message import nearest
    from pytest_hricdv.generate import GenerateError
    from pytest_hricdv.generate.qlearning import QLearning

    name, equals, text = (part.strip() for part in line.partition("="))
    defaults = {field.name: field.default for field in fields(QLearning) if field.name != "reward"}
    if name == "reward":
        raise GenerateError("the reward has an option of its own: --hri-rl-reward=NAME")
    if not equals or name not in defaults:
        raise GenerateError(f"expected NAME=VALUE with the name of a constant of learning{nearest(name, defaults)}")
    default = defaults[name]
    try:
        return {name: _value(text, default)}
    except ValueError:
        kinds = {bool: "true or false", int: "a whole number", float: "a number", tuple: "numbers, with commas between"}
        raise GenerateError(f"{name} = {text!r}; expected {kinds[type(default)]}") from None


def _value(text: str, default: object) -> object:
    """The text as a value of the default's kind. Raises ValueError."""
    if isinstance(default, bool):
        if text.lower() not in ("true", "false"):
            raise ValueError(text)
        return text.lower() == "true"
    if isinstance(default, int):
        return int(text)
    if isinstance(default, tuple):
        return tuple(_numbers(text))
    return float(text)


def _numbers(text: str) -> Iterator[float]:
    for part in text.split(","):
        yield float(part)
