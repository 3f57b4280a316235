"""`BeliefSpace`: all beliefs that the steering agent can be given, in groups; a testbench declares it.

`read_belief_sets` reads belief subsets from a file, for the suite by-hand and as the start of Q-learning. A person with
domain knowledge writes the subsets as TOML:

    [[belief_set]]
    name = "one leg"                        # what these subsets are for
    beliefs = ["leg4", "*bored", "m11?l4"]  # a pattern stands for each belief that it matches
    concretizations = 5                     # tests made of each subset; 1 if left out

An entry stands for every combination of its beliefs and patterns (`*`, `?`, `[abc]`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from functools import cached_property
from itertools import product
from pathlib import Path
from typing import Any

from pytest_hricdv._base.input_file import MAX_TOML_BYTES, MalformedError, from_toml, read_text
from pytest_hricdv._base.message import nearest, quote
from pytest_hricdv.generate import GenerateError, name_place

_ATOM = re.compile(r"[a-z]\w*\Z", re.ASCII)
START = "start"
"""The name of the group of start beliefs."""
_ENTRY = "belief_set"
_KEYS = ("name", "beliefs", "concretizations")
MAX_TESTS = 100_000
"""Maximum number of tests that one file, or one option, may ask for: a hundred times a large suite."""


@dataclass(frozen=True)
class BeliefSpace:
    """All beliefs that belief subsets consist of.

    Args:
        start: the beliefs that begin an interaction; every subset that a method draws has one of them.
        groups: the other beliefs, by the name of their group; a balanced subset has one of each group.
        id_groups: groups whose chosen belief appears in a test's id next to the start belief.
        default_beliefs: beliefs that mean "none of this group", as `not_bored` does: the model need not mention them.

    Raises:
        GenerateError: no start belief, an empty group, a belief listed twice, a belief that is not an AgentSpeak atom,
            a name in `id_groups` that is not a group, or one in `default_beliefs` that is not a belief of the space.
    """

    start: tuple[str, ...]
    groups: Mapping[str, tuple[str, ...]] = field(hash=False)
    id_groups: tuple[str, ...] = ()
    default_beliefs: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        # Users declare lists; tuples cannot be changed. A frozen dataclass has no other way to set a field.
        object.__setattr__(self, "start", tuple(self.start))
        object.__setattr__(self, "groups", {name: tuple(group) for name, group in self.groups.items()})
        object.__setattr__(self, "id_groups", tuple(self.id_groups))
        object.__setattr__(self, "default_beliefs", tuple(self.default_beliefs))
        if START in self.groups:
            raise GenerateError(f"group {START!r}: the start beliefs have this name already; expected another one")
        group_of: dict[str, str] = {}
        for name, group in {START: self.start, **self.groups}.items():
            if not group:
                raise GenerateError(f"group {name!r} of beliefs is empty; expected at least one belief")
            for belief in group:
                _add_belief(belief, name, group_of)
        for name in self.id_groups:
            if name not in self.groups:
                raise GenerateError(f"id_groups: {name!r} is not a group of this space{nearest(name, self.groups)}")
        for belief in self.default_beliefs:
            if belief not in group_of:
                raise GenerateError(f"default belief {belief!r} is not in the belief space{nearest(belief, group_of)}")

    @property
    def beliefs(self) -> tuple[str, ...]:
        """Every belief, in declared order: start beliefs first, then group by group."""
        return (*self.start, *self.others)

    @property
    def others(self) -> tuple[str, ...]:
        """The beliefs outside the start group, in declared order."""
        return tuple(belief for group in self.groups.values() for belief in group)

    @cached_property
    def bits(self) -> dict[str, int]:
        """Belief -> its bit in a set of beliefs that is kept as a number."""
        return {belief: 1 << place for place, belief in enumerate(self.beliefs)}

    @cached_property
    def _rank(self) -> dict[str, int]:
        return {belief: rank for rank, belief in enumerate(self.beliefs)}

    def subset(self, beliefs: Iterable[str]) -> tuple[str, ...]:
        """The subset in declared order, so that each set of beliefs has exactly one run of the model.

        Raises:
            GenerateError: a belief is not of this space, or is given twice.
        """
        rank = self._rank
        chosen = list(beliefs)
        for belief in chosen:
            if belief not in rank:
                raise GenerateError(f"belief {belief!r} is not in the belief space{nearest(belief, rank)}")
        if len(set(chosen)) != len(chosen):
            twice = sorted({belief for belief in chosen if chosen.count(belief) > 1})
            raise GenerateError(f"belief {twice[0]!r} is given twice in one subset")
        return tuple(sorted(chosen, key=rank.__getitem__))

    def target(self, beliefs: Iterable[str]) -> str:
        """A subset in a few words: its start belief and its beliefs of `id_groups`, as in `leg1-bored`."""
        subset = self.subset(beliefs)
        starts = [belief for belief in subset if belief in self.start] or ["no-start"]
        shown = {belief for name in self.id_groups for belief in self.groups[name]}
        return "-".join([*starts, *(belief for belief in subset if belief in shown)])


def _add_belief(belief: str, group: str, group_of: dict[str, str]) -> None:
    """Note the belief's group. Raises GenerateError if the belief is malformed or already in a group."""
    if not _ATOM.match(belief):
        raise GenerateError(
            f"group {group!r}: {belief!r} is not a belief; expected an AgentSpeak atom: a lower-case letter, then "
            "letters, digits or underscores"
        )
    if belief in group_of:
        first = group_of[belief]
        raise GenerateError(f"belief {belief!r} is in group {first!r} and in group {group!r}; expected it once")
    group_of[belief] = group


@dataclass(frozen=True)
class BeliefSets:
    """An entry of the file: the belief subsets it stands for, and how many tests are made of each."""

    name: str
    subsets: tuple[tuple[str, ...], ...]
    concretizations: int = 1


def read_belief_sets(path: Path, space: BeliefSpace) -> tuple[BeliefSets, ...]:
    """Read a file and expand its patterns.

    Raises:
        GenerateError: the file cannot be read or is not TOML; an unknown key or belief; a pattern without a match; a
            subset listed twice. With file, line and column.
    """
    try:
        text = read_text(path, MAX_TOML_BYTES)
        data = from_toml(text)
    except (FileNotFoundError, MalformedError) as error:
        fault = ": no such file" if isinstance(error, FileNotFoundError) else error
        raise GenerateError(f"{path}{fault}; expected a TOML file of belief subsets") from None
    return tuple(_BeliefFileReader(path, text, space).read(data))


class _BeliefFileReader:
    """Reads the entries of one file; has its text, to report where an error is."""

    def __init__(self, path: Path, text: str, space: BeliefSpace) -> None:
        self.path = path
        self.lines = text.splitlines()
        self.space = space
        self.seen: dict[tuple[str, ...], int] = {}

    def read(self, data: dict[str, Any]) -> Iterator[BeliefSets]:
        entries = data.get(_ENTRY)
        for key in data:
            if key != _ENTRY:
                raise GenerateError(
                    f"{self._where(None, key)}: unknown key {quote(key)}; expected [[belief_set]] entries only"
                )
        if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
            raise GenerateError(f"{self.path}:1:1: no [[belief_set]] entries; expected at least one")
        tests = 0
        for number, entry in enumerate(entries):
            sets = self._entry(number, entry)
            tests += len(sets.subsets) * sets.concretizations
            if tests > MAX_TESTS:
                where = self._where(number, "beliefs")
                raise GenerateError(f"{where}: {tests} tests up to here; expected at most {MAX_TESTS} in one file")
            yield sets

    def _entry(self, number: int, entry: dict[str, Any]) -> BeliefSets:
        for key in entry:
            if key not in _KEYS:
                raise GenerateError(f"{self._where(number, key)}: unknown key {quote(key)}{nearest(key, _KEYS)}")
        name, count, items = entry.get("name", ""), entry.get("concretizations", 1), entry.get("beliefs")
        if not isinstance(name, str) or name != " ".join(name.split()):
            raise GenerateError(f"{self._where(number, 'name')}: name {quote(name)}; expected one line of text")
        # Not isinstance: True is an int, and TOML has booleans.
        if type(count) is not int or count < 1:
            where = self._where(number, "concretizations")
            expected = "expected a whole number, at least 1"
            raise GenerateError(f"{where}: concretizations = {quote(count)}; {expected}")
        if not isinstance(items, list) or not all(isinstance(item, str) for item in items):
            raise GenerateError(
                f"{self._where(number, 'beliefs')}: beliefs = {quote(items)}; expected a list of strings"
            )
        return BeliefSets(name, tuple(self._subsets(number, items)), count)

    def _subsets(self, number: int, items: Sequence[str]) -> Iterator[tuple[str, ...]]:
        choices = [self._matches(number, item) for item in items]
        # Counted before they are made: five patterns that match all of 38 beliefs stand for 79 million.
        if (count := math.prod(map(len, choices))) > MAX_TESTS:
            where = self._where(number, "beliefs")
            raise GenerateError(f"{where}: {quote(count)} subsets in one entry; expected at most {MAX_TESTS}")
        for combination in product(*choices):
            with name_place(self._where(number, "beliefs")):
                subset = self.space.subset(combination)
            first = self.seen.setdefault(subset, number)
            if first != number:
                raise GenerateError(
                    f"{self._where(number, 'beliefs')}: subset {' '.join(subset)} is in the entry at "
                    f"{self._where(first, 'beliefs')} already; expected it once (with concretizations = 2, say)"
                )
            yield subset

    def _matches(self, number: int, item: str) -> list[str]:
        matches = [belief for belief in self.space.beliefs if fnmatchcase(belief, item)]
        if not matches:
            fault = "pattern matches no belief" if set(item) & set("*?[") else "unknown belief"
            where = self._where(number, item)
            raise GenerateError(f"{where}: {fault}: {quote(item)}{nearest(item, self.space.beliefs)}")
        return matches

    def _where(self, number: int | None, token: str) -> str:
        """`file:line:column` of a key or a string, searched in the entry of that number or in the whole file."""
        starts = [place for place, line in enumerate(self.lines) if re.match(rf"\s*\[\[\s*{_ENTRY}\s*\]\]", line)]
        first = starts[number] if number is not None and number < len(starts) else 0
        last = starts[number + 1] if number is not None and number + 1 < len(starts) else len(self.lines)
        word = re.escape(token)
        spelling = re.compile(rf"""["'](?P<string>{word})["']|^\s*\[*\s*(?P<key>{word})(?=\s*[=\]])""")
        # The TOML parser keeps no places, so the text is searched; after " #" a comment may quote the word.
        for place in range(first, last):
            if match := spelling.search(self.lines[place].partition(" #")[0]):
                return f"{self.path}:{place + 1}:{match.start(match.lastgroup or 0) + 1}"
        return f"{self.path}:{first + 1}:1"
