"""Keys of `report.json` that features add to the report (`Section`) or to each test (`TestSection`).

`results.model` extends its record types with these keys, so a feature's records are read, checked and written like all
others. Only the feature knows their types: it reads and sets them through its section.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar, cast

import msgspec

from pytest_hricdv.registry import offers

Value = TypeVar("Value")
Extended = TypeVar("Extended", bound=msgspec.Struct)
Keyed = TypeVar("Keyed", bound=msgspec.Struct)


class FileNames(Protocol):
    """The names of a report's files in the folder of a merged report, into which they are copied."""

    def replay(self, name: str | None) -> str | None:
        """The name of a replay file, as it is given to pytest."""

    def file(self, folder: str, name: str | None) -> str | None:
        """The path of a file in a folder of the report, relative to the report."""


@dataclass(frozen=True)
class Section(Generic[Value]):
    """A key of the report.

    Args:
        name: the key.
        kind: the type of its value, for the decoder.
        default: its value where it is absent.
        rename: gives its value other names of the files that it refers to.
    """

    name: str
    kind: Any
    default: Value
    rename: Callable[[Value, FileNames], Value] | None = None

    def of(self, record: msgspec.Struct) -> Value:
        """Its value."""
        return cast("Value", getattr(record, self.name))

    def put(self, record: Keyed, value: Value) -> Keyed:
        """The record with another value."""
        return msgspec.structs.replace(record, **{self.name: value})


@dataclass(frozen=True)
class TestSection(Section[Value]):
    """A key of each test.

    Args:
        identifies: whether two runs of a test that differ in it are different runs; otherwise reports of one run may
            differ in it, and a merged report keeps one of its values.
        folder: the report's folder, with the files that it refers to; empty if it has none of its own.
        suffixes: suffixes of these files; no others are copied into a merged report.
    """

    __test__ = False

    identifies: bool = False
    folder: str = ""
    suffixes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Share:
    """A percentage of each suite that a threshold can be given for.

    Args:
        kind: what thresholds call it.
        percent: the percentage of a suite, by the suite's name; None if it was not measured.
        is_measured: whether it was, for any suite.
    """

    kind: str
    percent: Callable[[msgspec.Struct, str], float | None]
    is_measured: Callable[[msgspec.Struct], bool]


def shares() -> tuple[Share, ...]:
    """The shares of all features."""
    return tuple(share for offered in offers("records", "SHARES") for share in offered)


def further_engines(test: msgspec.Struct) -> tuple[str, ...]:
    """The physics engines that a test ran on, according to features, in addition to that of its result."""
    return tuple(name for engines_of in offers("records", "further_engines") for name in engines_of(test))


def failure_causes(report: msgspec.Struct, suite: str = "") -> Mapping[str, str] | None:
    """Causes of the failures of a report, except known violations: id -> words; None if nobody looked for it.

    Args:
        suite: the suite of the tests; empty for all.
    """
    causes_of = next(iter(offers("records", "failure_causes")), None)
    return None if causes_of is None else cast("Mapping[str, str] | None", causes_of(report, suite))


def report_sections() -> tuple[Section[Any], ...]:
    """The report sections of all features."""
    return tuple(section for offered in offers("records", "SECTIONS") for section in offered)


def test_sections() -> tuple[TestSection[Any], ...]:
    """The test sections of all features."""
    return tuple(section for offered in offers("records", "TEST_SECTIONS") for section in offered)


def extend_record(record: type[Extended], sections: Sequence[Section[Any]]) -> type[Extended]:
    """A record type with further keys, which are not written while they have their defaults."""
    fields = [(section.name, section.kind, section.default) for section in sections]
    namespace = {"__doc__": record.__doc__, "__test__": False}
    return cast(
        "type[Extended]",
        msgspec.defstruct(
            record.__name__,
            fields,
            bases=(record,),
            module=record.__module__,
            namespace=namespace,
            frozen=True,
            kw_only=True,
            omit_defaults=True,
        ),
    )
