"""`Replay`: a concrete test with all that is needed to repeat its run, which `session.replaying` reads and writes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import msgspec

from pytest_hricdv._base import atomic_file
from pytest_hricdv._base import own_json as json
from pytest_hricdv._base.input_file import MalformedError, from_json, read_text
from pytest_hricdv._base.message import InputError, quote
from pytest_hricdv._base.schedule_record import FailureKind
from pytest_hricdv.generate import GenerateError
from pytest_hricdv.generate.abstract import AbstractTest, TestData
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.schedule import schedule_from_data, schedule_to_data
from pytest_hricdv.results.model import ConcreteParameters

SCHEMA = "hricdv-replay/2"


class ReplayError(InputError):
    """A replay file cannot be read or written; the message names the file, the cause and what to do."""


class ReplayOrigin(msgspec.Struct, frozen=True):
    """Where a test outside the suites came from.

    Args:
        how: how it was made.
        test: id of the test it was made from.
        requirement: id of the requirement that it is about.
        runs: how many runs it took.
        failure_kind: the kind of failure of a test with a schedule.
    """

    how: Literal["shrunk", "search", "schedule"]
    test: str = msgspec.field(name="from")
    requirement: str
    runs: int
    failure_kind: FailureKind = ""


@dataclass(frozen=True)
class Replay:
    """A test that was run, and the result.

    Args:
        test: the abstract test.
        concrete: the same with its exact parameters.
        nodeid: the pytest item that ran it.
        suite_seed: the seed that its suite was generated from.
        record_sha256: SHA-256 of the run's record; None if the run did not end.
        requirements: id -> verdict, as in the report.
        code: file of the code under test -> SHA-256 of its text.
        environment: other things a run depends on, name -> version.
        origin: the origin of a test outside the suites.
        hash_seed: the hash seed of the process that ran it, in digits, or "random"; empty: an older version did not
            say.
    """

    test: AbstractTest
    concrete: ConcreteTest
    nodeid: str
    suite_seed: int
    record_sha256: str | None
    requirements: Mapping[str, Any] = field(hash=False)
    code: Mapping[str, str] = field(hash=False)
    environment: Mapping[str, str] = field(hash=False)
    origin: ReplayOrigin | None = None
    hash_seed: str = ""

    def to_json(self) -> str:
        """The file's text; floats are exact."""
        actions = [{"command": a.command, "parameters": dict(a.parameters)} for a in self.concrete.actions]
        decisions = schedule_to_data(self.concrete.schedule)
        schedule = {"schedule": msgspec.to_builtins(decisions)} if decisions else {}
        plain = {
            "schema": SCHEMA,
            "test": self.test.to_data(),
            "concrete": {"actions": actions, "run": dict(self.concrete.run), **schedule},
            "nodeid": self.nodeid,
            "suite_seed": self.suite_seed,
            "record_sha256": self.record_sha256,
            "requirements": dict(self.requirements),
            "code": dict(self.code),
            "environment": dict(self.environment),
            "origin": msgspec.to_builtins(self.origin),
            "hash_seed": self.hash_seed,
        }
        return json.dumps(plain, sort_keys=True, indent=1, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str, where: str) -> Replay:
        """The replay that `to_json` wrote; `where` names its file in errors.

        Raises:
            ReplayError: cut off, of another version, incomplete, or contradictory.
        """
        file = _decode(text, where)
        try:
            test = AbstractTest.from_data(file.test)
        except GenerateError as error:
            raise ReplayError(f"{where}: {error}") from None
        try:
            concrete = _concrete(test, file.concrete)
        except GenerateError as error:
            raise ReplayError(f"{where}: {error}") from None
        if tuple(action.command for action in concrete.actions) != test.lines:
            raise ReplayError(f"{where}: its abstract and its concrete test have different actions; was it edited?")
        return cls(
            test=test,
            concrete=concrete,
            nodeid=file.nodeid,
            suite_seed=file.suite_seed,
            record_sha256=file.record_sha256,
            requirements=file.requirements,
            code=file.code,
            environment=file.environment,
            origin=file.origin,
            hash_seed=file.hash_seed,
        )


class _File(msgspec.Struct, frozen=True):
    """The text of a replay file."""

    test: TestData
    concrete: ConcreteParameters
    nodeid: str
    suite_seed: int
    record_sha256: str | None
    requirements: Mapping[str, Mapping[str, Any]]
    code: Mapping[str, str]
    environment: Mapping[str, str]
    origin: ReplayOrigin | None = None
    hash_seed: str = ""


class _ReplayHead(msgspec.Struct):
    schema: str | int | None = None


def _decode(text: str, where: str) -> _File:
    try:
        schema = from_json(text, _ReplayHead).schema
        if schema != SCHEMA:
            raise ReplayError(
                f"{where}: expected schema {SCHEMA!r}, found {quote(schema)}; "
                "expected a file from the folder 'failures' of a report, or the plugin's version that wrote this one"
            )
        return from_json(text, _File, strict=True)
    except MalformedError as error:
        raise ReplayError(f"{where}{error}; expected a replay file") from None


def _concrete(test: AbstractTest, parameters: ConcreteParameters) -> ConcreteTest:
    actions = tuple(ConcreteAction(action.command, _floats(action.parameters)) for action in parameters.actions)
    schedule = schedule_from_data(parameters.schedule)
    return ConcreteTest(test.id, test.suite, test.seed, actions, _floats(parameters.run), test.after, schedule)


def _floats(parameters: Mapping[str, float]) -> dict[str, float]:
    return {name: float(value) for name, value in parameters.items()}


def load(path: Path) -> Replay:
    """Read a replay file. Raises ReplayError if there is none or it is invalid, see `Replay.from_json`."""
    return Replay.from_json(read(path), str(path))


def read(path: Path) -> str:
    """The text of a replay file. Raises ReplayError if there is none or it is not text."""
    try:
        return read_text(path)
    except FileNotFoundError:
        raise ReplayError(f"{path}: there is no such file") from None
    except MalformedError as error:
        raise ReplayError(f"{path}{error}; expected a replay file") from None


def write(replay: Replay, folder: Path) -> Path:
    """Write `<folder>/<test id>.json` atomically; returns its path.

    Raises:
        ReplayError: the folder cannot be written.
    """
    path = folder / f"{replay.test.id}.json"
    try:
        return atomic_file.write_text(path, replay.to_json())
    except OSError as error:
        raise ReplayError(f"cannot write {path}: {error.strerror or error}") from None


def differences(replay: Replay, code: Mapping[str, str], environment: Mapping[str, str]) -> list[str]:
    """The changed dependencies of a run, as `lamps/guide.py changed` or `python 3.11.2, now 3.12.1`."""
    changes = []
    for name in sorted(replay.code.keys() | code.keys()):
        if name not in code:
            changes.append(f"{name} is gone")
        elif name not in replay.code:
            changes.append(f"{name} is new")
        elif code[name] != replay.code[name]:
            changes.append(f"{name} changed")
    for name in sorted(replay.environment.keys() | environment.keys()):
        before, now = replay.environment.get(name, "unknown"), environment.get(name, "unknown")
        if before != now:
            changes.append(f"{name} {before}, now {now}")
    return changes
