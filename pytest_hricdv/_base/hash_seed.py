"""Python's hash seed, which decides the iteration order of sets of strings: of this process and of its children.

`own_hash_seed` finds out the seed of this process, for reports and replays; `environment_of_child` passes it on. Python
takes the seed from the variable `PYTHONHASHSEED` when a process starts, and draws one if the variable is not set or is
"random". A drawn seed cannot be passed to another process.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path

VARIABLE = "PYTHONHASHSEED"
RANDOM = "random"
"""Reported instead of a drawn seed, which is unknown and cannot be repeated."""

SEVERAL = "several"
"""Reported instead of a seed if the processes of a session had different seeds."""

_CHOSEN = "0"
"""The seed of child processes if there is none to pass on. Chosen: Python's own value for "not random"."""

_LARGEST = 2**32 - 1  # see Python's documentation of the variable
_WORD = 2**64 - 1
_ROUNDS = {"siphash13": (1, 3), "siphash24": (2, 4)}
"""Name of the hash algorithm (`sys.hash_info`) -> its numbers of rounds for each word, and at the end."""


@cache
def own_hash_seed() -> str:
    """The seed of this process as decimal digits, or "random".

    The variable need not tell the truth: a program may have set it after Python had started, where it does nothing.
    """
    if not sys.flags.hash_randomization:
        return "0"
    texts = (_number(os.environ.get(VARIABLE, "")), _number(_at_start()))
    return next((text for text in texts if text not in ("", "0") and _is_in_use(int(text))), RANDOM)


def _at_start() -> str:
    """The variable's value when this process started: Linux keeps it even if the program has set another one since."""
    try:
        variables = Path("/proc/self/environ").read_bytes().split(b"\0")
    except OSError:
        return ""
    values = [value for name, _, value in (entry.partition(b"=") for entry in variables) if name == VARIABLE.encode()]
    return values[0].decode("ascii", "replace") if values else ""


def hash_seed_of_children() -> str:
    """The seed of child processes: this one's, or one that the variable asks for, or 0."""
    own = own_hash_seed()
    return (_number(os.environ.get(VARIABLE, "")) or _CHOSEN) if own == RANDOM else own


def hash_seed_difference(before: str, now: str) -> str:
    """How the hash seeds of two runs differ, as `0, now random`; empty if they are the same, or one is not known."""
    if not before or not now or (before == now and now.isdigit()):
        return ""
    return f"{before}, now {'another one' if before == now else now}"


def question_of_drawn_seed() -> str:
    """The end of a message on a run that differs between processes, if this one drew its seed; else empty."""
    return (
        f"; or is it Python's hash seed, which pytest drew? {VARIABLE}=0 chooses it"
        if own_hash_seed() == RANDOM
        else ""
    )


def hand_to_children() -> Callable[[], None]:
    """Put the seed of children into this process's environment, for processes that others start; returns an undo."""
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = hash_seed_of_children()

    def undo() -> None:
        if before is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = before

    return undo


def environment_of_child(
    variables: Mapping[str, str] | None = None,
    *,
    path: tuple[str, ...] | None = None,
    hash_seed: str | None = None,
    inherited: Mapping[str, str] | None = None,
) -> dict[str, str]:
    """The environment of a process that is started to run or measure code under test.

    Args:
        variables: besides those of this process.
        path: where modules are found; None: as in this process.
        hash_seed: decimal digits; None: as all children of this process.
        inherited: variables in place of those that this process has now.
    """
    variables_here = os.environ if inherited is None else inherited
    # Variables of coverage would make the process write data files of its own.
    environment = {name: value for name, value in variables_here.items() if not name.startswith(("COV_", "COVERAGE_"))}
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path if path is None else path))
    environment[VARIABLE] = hash_seed_of_children() if hash_seed is None else hash_seed
    return environment | dict(variables or {})


def _number(text: str) -> str:
    """Its digits without leading zeros; empty if Python would not accept it as a seed."""
    is_number = text.isascii() and text.isdigit() and int(text) <= _LARGEST
    return str(int(text)) if is_number else ""


def _is_in_use(seed: int) -> bool:
    """Whether this process hashes with a seed; assumed true if the algorithm is unknown here."""
    rounds = _ROUNDS.get(sys.hash_info.algorithm) if sys.hash_info.width == 64 else None
    text = "hash seed"
    return rounds is None or hash(text) == _hash_of(text.encode(), _key(seed), rounds)


def _key(seed: int) -> tuple[int, int]:
    """The key that Python makes of a seed not 0, with a generator of its own (`lcg_urandom` in bootstrap_hash.c)."""
    data = bytearray()
    for _ in range(16):
        seed = (seed * 214013 + 2531011) & 0xFFFFFFFF
        data.append((seed >> 16) & 0xFF)
    return int.from_bytes(data[:8], "little"), int.from_bytes(data[8:], "little")


def _hash_of(data: bytes, key: tuple[int, int], rounds: tuple[int, int]) -> int:
    """SipHash (Aumasson and Bernstein 2012), as Python uses it for strings (PEP 456), on machines with 64 bits."""
    a, b, c, d = (
        half ^ constant
        for half, constant in zip(
            key * 2, (0x736F6D6570736575, 0x646F72616E646F6D, 0x6C7967656E657261, 0x7465646279746573), strict=True
        )
    )
    whole = len(data) - len(data) % 8
    words = [int.from_bytes(data[start : start + 8], "little") for start in range(0, whole, 8)]
    words.append(len(data) << 56 & _WORD | int.from_bytes(data[whole:], "little"))
    for word in words:
        a, b, c, d = _mix(a, b, c, d ^ word, rounds[0])
        a ^= word
    a, b, c, d = _mix(a, b, c ^ 0xFF, d, rounds[1])
    value = a ^ b ^ c ^ d
    signed = value - 2**64 if value >= 2**63 else value
    return -2 if signed == -1 else signed  # -1 is an error for Python's C code


def _mix(a: int, b: int, c: int, d: int, rounds: int) -> tuple[int, int, int, int]:
    for _ in range(rounds):
        a, c = (a + b) & _WORD, (c + d) & _WORD
        b, d = _rotate(b, 13) ^ a, _rotate(d, 16) ^ c
        a = _rotate(a, 32)
        c, a = (c + b) & _WORD, (a + d) & _WORD
        b, d = _rotate(b, 17) ^ c, _rotate(d, 21) ^ a
        c = _rotate(c, 32)
    return a, b, c, d


def _rotate(value: int, bits: int) -> int:
    return (value << bits | value >> (64 - bits)) & _WORD
