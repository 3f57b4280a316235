"""Mutations of texts and of JSON: what is cut off, doubled, edited by hand, or made to do harm."""

from __future__ import annotations

import json
from copy import deepcopy
from random import Random
from typing import Any

_HARMFUL = (
    *("", "\0", "\x1b[31m", "\u202e", "\ufeff", "\r", "\n\n", "\t", "é", "٣", "𝟘", "<b>", "../../x", "/etc/passwd"),
    *("zz", "-0x1", "0x", "x/y", "1/99999999", "10e400", "1e300", "-1", "0", "NaN", "inf", "9" * 25, "9" * 5000),
    *("[" * 200, "(" * 200, "{" * 200, "]" * 200, "!" * 200, "not " * 200, "#00000000199999999", "]]>"),
    *('"', "'", '"""', "'''", "\\", "#", "=", ":", ",", ";", "."),
)  # fmt: skip
_RAW = ("1e400", "9" * 5000, "NaN", "-Infinity", "[" * 3000 + "]" * 3000, '{"a":' * 900 + "1" + "}" * 900, "1" * 25)
"""Of JSON: texts that stand for a value, which no Python value is written as."""
_NUMBERS = (None, True, False, -1, 0, 1, 2**63, 10**400, 1e308, -0.0, 0.5)
_VALUES: tuple[Any, ...] = (*_NUMBERS, [], {}, [[]], {"": None}, ["x"] * 3, *_HARMFUL)
_PLACEHOLDER = "\ue000{}\ue000"


def mutate_text(text: str, others: list[str], rng: Random) -> str:
    """The text with one to four changes; pieces come from harmful texts, from itself, and from others of its kind."""
    for _ in range(rng.choice((1, 1, 2, 4))):
        start = rng.randrange(len(text) + 1)
        end = min(len(text), start + rng.choice((0, 0, 1, 3, 12, 60)))
        kind = rng.randrange(8)
        if kind == 0:
            text = text[:start]
        elif kind == 1:
            text = text[:start] + text[end:]
        elif kind == 2:
            text = text[:start] + text[start:end] * rng.choice((2, 3, 30, 300)) + text[end:]
        elif kind == 3:
            other = rng.choice(others)
            place = rng.randrange(len(other) + 1)
            text = text[:start] + other[place : place + rng.choice((3, 20, 200))] + text[end:]
        elif kind == 4:
            text = text[:start] + chr(rng.choice((rng.randrange(128), rng.randrange(0xD800)))) + text[end:]
        else:
            text = text[:start] + rng.choice(_HARMFUL) + text[end:]
    return text


def mutate_json(text: str, rng: Random) -> str:
    """The JSON with one to three parts replaced, left out, doubled or renamed."""
    data = json.loads(text)
    raw: list[str] = []
    for _ in range(rng.randint(1, 3)):
        _change(data, rng, raw)
    mutated = json.dumps(data)
    for number, value in enumerate(raw):
        mutated = mutated.replace(json.dumps(_PLACEHOLDER.format(number)), value)
    return mutated


def _change(data: Any, rng: Random, raw: list[str]) -> None:
    part, depth = data, rng.randint(1, 9)
    while True:
        keys = [*part] if isinstance(part, dict) else [*range(len(part))] if isinstance(part, list) else []
        if not keys:
            return
        key = rng.choice(keys)
        depth -= 1
        if depth <= 0 or not isinstance(part[key], dict | list) or not part[key]:
            break
        part = part[key]
    kind = rng.randrange(6)
    if kind == 0:
        del part[key]
    elif kind == 1 and isinstance(part, list):
        part.insert(key, deepcopy(part[key]))
    elif kind == 1:
        part[rng.choice(_HARMFUL)] = part.pop(key)
    elif kind == 2:
        raw.append(rng.choice(_RAW))
        part[key] = _PLACEHOLDER.format(len(raw) - 1)
    elif kind == 3:
        part[key] = deepcopy(rng.choice([part[other] for other in keys]))
    elif kind == 4 and isinstance(part[key], str):
        part[key] = mutate_text(part[key], [part[key]], rng)
    else:
        part[key] = deepcopy(rng.choice(_VALUES))  # a part of its own: further changes go no further
