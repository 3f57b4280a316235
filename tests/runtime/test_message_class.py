"""Messages need not be dataclasses: what code under test has as messages is taken as it is."""

from __future__ import annotations

from collections import namedtuple
from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import msgspec
import pytest

from pytest_hricdv.runtime import Bus, Kernel, Recorder, fields_of, is_message


@dataclass(frozen=True)
class Plain:
    kind: str
    level: float
    count: ClassVar[int] = 0


class Tuple(NamedTuple):
    kind: str
    level: float


class Struct(msgspec.Struct):
    kind: str
    level: float


def of_attrs() -> type[Any]:
    made: type[Any] = pytest.importorskip("attrs").make_class("OfAttrs", ["kind", "level"], frozen=True)
    return made


def of_pydantic() -> type[Any]:
    made: type[Any] = pytest.importorskip("pydantic").create_model("OfPydantic", kind=(str, ...), level=(float, ...))
    return made


Bare = namedtuple("Bare", ("kind", "level"))  # of code without annotations

KINDS = (lambda: Plain, lambda: Tuple, lambda: Struct, lambda: Bare, of_attrs, of_pydantic)


@pytest.fixture(params=KINDS)
def kind(request: pytest.FixtureRequest) -> type[Any]:
    made: type[Any] = request.param()
    return made


def test_a_class_with_fields_is_a_message(kind: type[Any]) -> None:
    assert fields_of(kind) == ("kind", "level")
    assert is_message(kind(kind="on", level=0.5))


def test_the_bus_delivers_and_records_it(kind: type[Any]) -> None:
    kernel, recorder = Kernel(), Recorder()
    bus = Bus(kernel, (kind,), recorder)
    heard: list[Any] = []

    def listener() -> None:
        heard.append(bus.port("listener").subscribe(kind).wait(5.0))

    def speaker() -> None:
        kernel.sleep(1.0)
        bus.port("speaker").publish(kind(kind="on", level=0.5))

    kernel.spawn("listener", listener)
    kernel.spawn("speaker", speaker)
    kernel.run(limit_s=10.0)
    assert [(message.kind, message.level) for message in heard] == [("on", 0.5)]
    assert [dict(message.fields) for message in recorder.messages] == [{"kind": "on", "level": 0.5}]
