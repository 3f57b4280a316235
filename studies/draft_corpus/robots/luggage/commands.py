"""What the reception's computer sends: a line of JSON for each command, with its kind in `cmd`."""

import json
from dataclasses import dataclass, fields


class BadCommand(Exception):
    pass


@dataclass
class Fetch:
    room: int
    bags: int = 1


@dataclass
class Bring:
    room: int
    knock: str = "door"


@dataclass
class Release:
    pin: str


@dataclass
class Hold:
    reason: str = ""


@dataclass
class Resume:
    pass


KINDS = {"fetch": Fetch, "bring": Bring, "release": Release, "hold": Hold, "resume": Resume}


def parse(line: str):
    try:
        content = json.loads(line)
    except json.JSONDecodeError as error:
        raise BadCommand(f"no JSON: {error}") from error
    kind = KINDS.get(content.pop("cmd", None))
    if kind is None:
        raise BadCommand("unknown command")
    known = {field.name for field in fields(kind)}
    if content.keys() - known:
        raise BadCommand(f"unknown: {sorted(content.keys() - known)}")
    try:
        return kind(**content)
    except TypeError as error:
        raise BadCommand(str(error)) from error
