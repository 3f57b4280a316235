"""Ports for modules that are not installed, of what first runs observed at their stand-ins."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

from pytest_hricdv.extra.draft.code_model import CodeLine, MessageField, Operation, Port
from pytest_hricdv.extra.draft.observe.observations import Observations, Site
from pytest_hricdv.extra.draft.observe.tracer import CALLBACK
from pytest_hricdv.extra.draft.observed_calls import kind_of_shape, texts_of_shape
from pytest_hricdv.extra.draft.stand_ins.absent import without_arguments

MAX_SENSES = 12
"""Values of one class or module that a person sets."""

MAX_ARGUMENTS = 4
"""Arguments of a call that tell sensors apart; of more, as the angles of a scanner, all are one sensor."""


def absent_ports(seen: Observations, root: Path, truths: Collection[str] = ()) -> Iterator[Port]:
    """A device for each class and module that the code uses; what it tests or compares is a sensor.

    Args:
        seen: in first runs.
        root: folder of the code.
        truths: names of methods and attributes that the code tests for identity with a truth.
    """
    registered = {key.removeprefix(CALLBACK).partition(" ")[0] for key in seen.methods if key.startswith(CALLBACK)}
    for name, place in seen.absent.items():
        # A key with a topic is that of a method, too.
        calls = {key: site for key, site in seen.calls.items() if key.startswith(f"{name}.") and " " not in key}
        calls = _with_arguments(calls)
        operations = [_operation(key.partition(".")[2], calls[key], root, key in registered) for key in sorted(calls)]
        known = {each.name for each in operations if each.result is not None}
        operations += [_truth(each) for each in operations if each.name.rpartition(".")[2] in truths
                       and each.is_method and f"{each.name}()" not in known]  # fmt: skip
        sensed = [each for each in operations if each.result is not None][:MAX_SENSES]
        called = [each for each in operations if each.result is None and each.is_method]
        results = {without_arguments(each.name).removesuffix("()") for each in sensed}
        others = [each for each in called if each.name not in results]
        yield Port(name, "device", "", "", (*sensed, *others), _line(place, root))


def _with_arguments(calls: Mapping[str, Site]) -> dict[str, Site]:
    """The sites, those of one call with a single argument or with many as one."""
    keys: dict[str, list[str]] = {}
    for key in calls:
        keys.setdefault(without_arguments(key), []).append(key)
    made: dict[str, Site] = {}
    for general, each in keys.items():
        for key in each:
            site = made.setdefault(key if 1 < len(each) <= MAX_ARGUMENTS else general, Site())
            site.merge(calls[key])
    return made


def _operation(name: str, site: Site, root: Path, is_registration: bool) -> Operation:
    """What the code called, or the value that it tested or compared."""
    location = _line(site.location, root)
    kind = "float" if site.compared else kind_of_shape(site.result)
    values = texts_of_shape(site.result, location) if kind == "str" else ()
    part = MessageField("value", "", kind, location, values, compared=tuple(sorted(site.compared)))
    is_sensed = kind in ("bool", "float") or bool(values)
    return Operation(name, bool(site.count), location, is_registration=is_registration,
                     result=part if is_sensed and not site.count else None)  # fmt: skip


def _truth(called: Operation) -> Operation:
    """The result of a method as a truth."""
    return replace(called, name=f"{called.name}()", result=MessageField("value", "", "bool", called.location))


def _line(place: str, root: Path) -> CodeLine:
    file, _, line = place.rpartition(":")
    path = Path(file).resolve()
    return CodeLine(path.relative_to(root).as_posix() if path.is_relative_to(root) else path.name, int(line or 0))
