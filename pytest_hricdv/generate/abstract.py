"""Abstract tests: a sequence of commands to the person or device that interacts with the robot.

The text format is that of the paper's experiment: one command per line, blank lines between tests, `#` begins a
comment. Comment lines of the form `# key: value` directly above the commands hold the other fields of a test, so that
an exported suite reads back unchanged (`aim` is the target):

    # id: by-hand-leg4-d2a01c9e
    # suite: by-hand
    # aim: leg4
    # beliefs: leg4 m111l4
    # seed: 6714903881632941057
    # name: one leg, human ready
    # plans human: plan4 plan5
    tell leg
    receivesignal
    set_param gaze = 1
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from pytest_hricdv.generate.error import GenerateError

#: Executed coverage plans: agent -> plan labels, sorted.
Plans = Mapping[str, tuple[str, ...]]

_ID = re.compile(r"[A-Za-z0-9_-]+\Z")
_WORD = r"[A-Za-z_]\w*"
_VALUE = rf"(?:{_WORD}|[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)"
_ACTION = re.compile(rf"\s*({_WORD})\s*(?:\(\s*({_VALUE})\s*(?:,\s*({_VALUE})\s*)?\))?\s*\Z", re.ASCII)
_COMMAND = re.compile(rf"\s*({_WORD})(?:\s+({_VALUE})(?:\s*=\s*({_VALUE}))?)?\s*\Z", re.ASCII)
SEED_LIMIT = 2**63


@dataclass(frozen=True)
class AbstractTest:
    """One abstract test.

    Args:
        id: the name used everywhere: letters, digits, `_`, `-`.
        suite: the suite it was generated for.
        target: what the test is to exercise, in a few words; part of the id.
        beliefs: the belief subset it came from, in declared order; empty if from none.
        lines: its commands, in the text format.
        plans: the coverage plans that the model executed in the run it came from.
        seed: its own seed, 0 <= seed < 2**63.
        name: a title for people; may be empty.

    Raises:
        GenerateError: other characters in the id, a seed out of range, no suite or target, text that the text format
            cannot represent, or a line that is no command in canonical spelling.
    """

    id: str
    suite: str
    target: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Plans = field(default_factory=dict, hash=False)
    seed: int = 0
    name: str = ""

    def __post_init__(self) -> None:
        if not _ID.match(self.id):
            raise GenerateError(f"test id {self.id!r}: expected letters, digits, '_' and '-' only")
        if not 0 <= self.seed < SEED_LIMIT:
            raise GenerateError(f"test {self.id}: seed {self.seed} is out of range; expected 0 <= seed < 2**63")
        for key, text in (("suite", self.suite), ("aim", self.target), ("name", self.name)):
            if text != " ".join(text.split()) or not (text or key == "name"):
                raise GenerateError(f"test {self.id}: {key} {text!r}: expected one line with single spaces only")
        for word in (*self.beliefs, *self.plans, *(label for labels in self.plans.values() for label in labels)):
            if word.split() != [word]:
                raise GenerateError(f"test {self.id}: {word!r}: expected one word for a belief, an agent or a plan")
        for line in self.lines:
            if (spelling := canonical_command(line)) != line:
                raise GenerateError(f"test {self.id}: command {line!r}: expected the spelling {spelling!r}")

    def to_data(self) -> dict[str, Any]:
        """Plain data for JSON, with the keys of replay files."""
        return {
            "id": self.id,
            "suite": self.suite,
            "aim": self.target,
            "beliefs": list(self.beliefs),
            "lines": list(self.lines),
            "plans": {agent: list(labels) for agent, labels in self.plans.items()},
            "seed": self.seed,
            "name": self.name,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> AbstractTest:
        """The test that `to_data` gave.

        Raises:
            GenerateError: see the class.
            KeyError, TypeError, AttributeError, ValueError: the data has another shape.
        """
        return cls(
            id=data["id"],
            suite=data["suite"],
            target=data["aim"],
            beliefs=tuple(data["beliefs"]),
            lines=tuple(data["lines"]),
            plans={agent: tuple(labels) for agent, labels in data["plans"].items()},
            seed=int(data["seed"]),
            name=data["name"],
        )


def canonical_command(text: str) -> str:
    """A command in canonical spelling: `set_param gaze=1` gives `set_param gaze = 1`.

    Raises:
        GenerateError: it is no command.
    """
    match = _COMMAND.match(text)
    if match is None:
        raise GenerateError(
            f"{text.strip()!r} is no command; expected 'name', 'name value' or 'name parameter = value'"
        )
    return _spell(match.groups())


def command_from_action(action: str) -> str:
    """The command of an external action: `set_param(gaze, 1)` gives `set_param gaze = 1`.

    Raises:
        GenerateError: the action has no text form: more than two arguments, or one that is no atom, name or number.
    """
    match = _ACTION.match(action)
    if match is None:
        raise GenerateError(
            f"action {action!r} has no text form; expected a name with at most two arguments, each an atom or a number"
        )
    return _spell(match.groups())


def _spell(parts: Sequence[str | None]) -> str:
    name, first, second = parts
    if first is None:
        return str(name)
    return f"{name} {first}" if second is None else f"{name} {first} = {second}"
