"""Abstract tests from logs (`hricdv check --to-tests`): the actions of people, with the observed values.

`hricdv check` passes each log to `LoggedActions.add`. The tests run, shrink and vary like any others.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import cast

from pytest_hricdv._base.message import InputError, nearest, quote
from pytest_hricdv.extra.logs.log_map import PLACE, ActionSource, LogMap, reading_of, source_of
from pytest_hricdv.extra.logs.logged_run import LogReader
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractDraft, canonical_command, target_of_commands
from pytest_hricdv.generate.concrete import Concretization
from pytest_hricdv.recordings.bags import Value


@dataclass
class LoggedActions:
    """The tests of logs, in order, and notes on what they leave out.

    Args:
        concretization: commands that can be executed, and the ranges of their parameters.
        made: the map, with its actions.
    """

    concretization: Concretization
    made: LogMap
    drafts: list[AbstractDraft] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)

    def add(self, reader: LogReader) -> None:
        """Add a test for each part of a log that has actions.

        Raises:
            InputError: the testbench does not have the command of an action, or a message lacks a field of the map.
        """
        runs = reader.runs()
        made: list[list[tuple[float, ActionSource, Mapping[str, Value]]]] = [[] for _ in runs]
        for part, time_s, event, fields in reader.events(runs):
            if isinstance(event.source, ActionSource) and isinstance(fields, Mapping):
                made[part].append((time_s, event.source, fields))
        for run, actions in zip(runs, made, strict=True):
            lines, values = self._read(run.name, actions)
            draft = AbstractDraft(target_of_commands(lines), (), tuple(lines), values=values)
            if lines and draft not in self.drafts:
                self.drafts.append(draft)
            elif not lines:
                self.notes.append(f"{run.name}: has no action of the map")

    def _read(
        self, name: str, actions: Iterable[tuple[float, ActionSource, Mapping[str, Value]]]
    ) -> tuple[list[str], dict[int, dict[str, float]]]:
        lines: list[str] = []
        values: dict[int, dict[str, float]] = {}
        last_s = 0.0 if self.made.time == "log" else None  # by stamps, the beginning of the log is not known
        for time_s, source, fields in actions:
            line = self.command(name, source, fields)
            lines.append(line)
            observed = {source.since: time_s - last_s} if source.since and last_s is not None else {}
            for parameter, place in source.parameters.items():
                read = reading_of(f"actions.{source.topic}.{parameter}", source_of(place), float)
                observed[parameter] = cast("float", read(fields))
            if kept := dict(self._within_ranges(f"{name}: action {len(lines)}", line, observed)):
                values[len(lines)] = kept
            last_s = time_s
        return lines, values

    def command(self, name: str, source: ActionSource, fields: Mapping[str, Value]) -> str:
        """The command of an action.

        Raises:
            InputError: the testbench does not have it, or the message lacks a field.
        """

        def fill(match: re.Match[str]) -> str:
            value = fields.get(match[1])
            if not isinstance(value, str | float | bool):
                raise InputError(f"{source.topic}: its messages have no field {match[1]}{nearest(match[1], fields)}")
            return f"{value:g}" if isinstance(value, float) and not isinstance(value, bool) else str(value)

        text = PLACE.sub(fill, source.command)
        try:
            command = canonical_command(text)
        except GenerateError as error:
            raise InputError(f"{source.topic}: {error}") from None
        commands = self.concretization.commands
        if command not in commands:
            raise InputError(
                f"{name}: {source.topic}: the testbench has no command {quote(command)}{nearest(command, commands)}"
            )
        return command

    def _within_ranges(self, where: str, command: str, observed: Mapping[str, float]) -> Iterator[tuple[str, float]]:
        samplers = self.concretization.commands[command]
        for parameter, value in observed.items():
            if parameter not in samplers:
                raise InputError(f"{command!r} has no parameter {parameter}{nearest(parameter, samplers)}")
            if samplers[parameter].contains(value):
                yield parameter, value
            else:
                self.notes.append(
                    f"{where}, {command}: {parameter} is drawn: {value:.6g} is outside of its {samplers[parameter]}"
                )
