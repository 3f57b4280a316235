"""What was observed of running code, as one JSON file: calls, values and states at its border.

`hricdv record` and first runs write `Observations`, drafts read them; a `Site` is for one function or attribute.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from pytest_hricdv._base.input_file import check_keys
from pytest_hricdv.extra.draft.observe.shape import Shape

VERSION = 2
MAX_BYTES = 20_000_000
"""A longer file is not a recording of this kind."""

MAX_SITES = 2_000
"""Most functions and attributes in each table of `Observations`."""

MAX_COMPARED, MAX_NUMBER = 16, 1e100
"""Most numbers that are kept of comparisons, and the bound from which on a number stands for infinity."""


@dataclass
class Site:
    """The calls of one function, or uses of one attribute, at the border.

    Args:
        count: number of crossings. location: file and line of the first one, in the code.
        arguments: the arguments, by parameter or index.
        compared: numbers that the code compares the result with, at most `MAX_COMPARED`.
    """

    count: int = 0
    location: str = ""
    arguments: dict[str, Shape] = field(default_factory=dict)
    result: Shape = field(default_factory=Shape)
    compared: list[float] = field(default_factory=list)

    def add(self, arguments: Mapping[str, Any], location: str = "") -> None:
        """Count a call."""
        self.count += 1
        self.location = self.location or location
        for name, value in arguments.items():
            self.arguments.setdefault(name, Shape()).add(value, name)

    def note_comparison(self, number: float) -> None:
        """Note a number that the result is compared with."""
        if number not in self.compared and len(self.compared) < MAX_COMPARED and abs(number) < MAX_NUMBER:
            self.compared.append(number)

    def merge(self, other: Site) -> None:
        """Add the calls of another process."""
        self.count += other.count
        self.location = self.location or other.location
        for name, shape in other.arguments.items():
            self.arguments.setdefault(name, Shape()).merge(shape)
        self.result.merge(other.result)
        for number in other.compared:
            self.note_comparison(number)


@dataclass
class Observations:
    """All observations.

    Args:
        made: "module:Class" of the code -> its construction from outside.
        methods: "module:Class.method" or "module:function" of the code -> calls from outside.
        calls: "port.method" -> calls by the code; a port is "Class.parameter", through which the code got the object.
        states: "module:Class.attribute" -> its texts, with the pairs that followed each other as "from -> to".
        absent: class or module that is not installed, a port of `calls` -> where the code first used it, "file:line".
    """

    made: dict[str, Site] = field(default_factory=dict)
    methods: dict[str, Site] = field(default_factory=dict)
    calls: dict[str, Site] = field(default_factory=dict)
    states: dict[str, dict[str, int]] = field(default_factory=dict)
    absent: dict[str, str] = field(default_factory=dict)

    def site(self, table: dict[str, Site], key: str) -> Site | None:
        """The site of a key; None if there are too many."""
        if key not in table and len(table) >= MAX_SITES:
            return None
        return table.setdefault(key, Site())

    def add_state(self, attribute: str, before: str | None, text: str) -> None:
        """Count that an attribute has become a text."""
        pairs = self.states.setdefault(attribute, {}) if len(self.states) < MAX_SITES else {}
        key = text if before is None else f"{before} -> {text}"
        if key in pairs or len(pairs) < 200:
            pairs[key] = pairs.get(key, 0) + 1

    def merge(self, other: Observations) -> None:
        """Add those of another process."""
        for name in ("made", "methods", "calls"):
            mine, theirs = getattr(self, name), getattr(other, name)
            for key, site in theirs.items():
                mine.setdefault(key, Site()).merge(site)
        for key, pairs in other.states.items():
            own = self.states.setdefault(key, {})
            for pair, count in pairs.items():
                own[pair] = own.get(pair, 0) + count
        self.absent = {**other.absent, **self.absent}

    @property
    def modules(self) -> set[str]:
        """The top-level modules of the code that was observed."""
        return {key.partition(":")[0].partition(".")[0] for key in (*self.made, *self.methods, *self.states)}

    @property
    def is_empty(self) -> bool:
        """Whether nothing crossed the border."""
        return not (self.made or self.methods or self.calls or self.states)

    def to_json(self) -> str:
        """The content of a file."""
        plain: dict[str, Any] = {"format": "hricdv-recording", "version": VERSION, "states": self.states}
        plain |= {"absent": self.absent} if self.absent else {}
        for name in ("made", "methods", "calls"):
            plain[name] = {key: _site_to_json(site) for key, site in sorted(getattr(self, name).items())}
        return json.dumps(plain, indent=1, ensure_ascii=False, sort_keys=True) + "\n"


def _site_to_json(site: Site) -> dict[str, Any]:
    return {
        "count": site.count,
        "location": site.location,
        "arguments": {name: shape.to_json() for name, shape in site.arguments.items()},
        "result": site.result.to_json(),
        **({"compared": site.compared} if site.compared else {}),
    }


def is_observations(path: Path) -> bool:
    """Whether a file is one of these, and no bag."""
    try:
        with path.open("rb") as file:
            return file.read(1) == b"{"
    except OSError:
        return False


def read_observations(path: Path) -> Observations:
    """Read a file.

    Raises:
        ValueError: it is none; the message says what was expected.
        OSError: it cannot be read.
    """
    if path.stat().st_size > MAX_BYTES:
        raise ValueError(f"expected a recording of at most {MAX_BYTES:,} bytes")
    try:
        plain = json.loads(path.read_text(encoding="utf-8"))
        if plain.get("format") != "hricdv-recording" or plain.get("version") != VERSION:
            raise ValueError(f"expected version {VERSION} of a recording of `hricdv record`")
        check_keys(plain, ("format", "version", "states", "absent", "made", "methods", "calls"))
        made = Observations(states={str(key): dict(pairs) for key, pairs in plain["states"].items()})
        made.absent = {str(port): str(place) for port, place in dict(plain.get("absent", {})).items()}
        for name in ("made", "methods", "calls"):
            setattr(made, name, {str(key): _site_from_json(site) for key, site in plain[name].items()})
    except (KeyError, TypeError, AttributeError, RecursionError) as error:
        raise ValueError(f"expected a recording of `hricdv record`; the file lacks {error}") from None
    except OverflowError as error:
        raise ValueError(f"expected numbers of a recording of `hricdv record`: {error}") from None
    return made


def _site_from_json(plain: Mapping[str, Any]) -> Site:
    check_keys(plain, ("count", "location", "arguments", "result", "compared"))
    arguments = {str(name): Shape.from_json(shape) for name, shape in plain["arguments"].items()}
    return Site(int(plain["count"]), str(plain["location"]), arguments, Shape.from_json(plain["result"]),
                [float(number) for number in plain.get("compared", ())])  # fmt: skip


def merge_observations(parts: Iterable[Observations]) -> Observations:
    """Merge the observations of several processes."""
    merged = Observations()
    for part in parts:
        merged.merge(part)
    return merged


def write_atomically(path: Path, text: str) -> None:
    """Write a file, or leave the one that there is."""
    beside = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    beside.write_text(text, encoding="utf-8")
    beside.replace(path)
