"""Abstract tests: a sequence of commands to whoever interacts with the robot, as data and as text.

The text format is that of the paper's experiment: one command a line, tests apart by blank lines, `#` begins a comment.
Comment lines of the form `# key: value` right above the commands carry what a test has beside them, so that an
exported suite reads back unchanged:

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

from .error import GenerateError

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
        id: what names the test everywhere: letters, digits, `_`, `-`.
        suite: the suite it was generated for.
        aim: what it aims at, short.
        beliefs: the belief subset it came from, in declared order; empty if from none.
        lines: its commands, in the text format.
        plans: the coverage plans that the model executed on the way.
        seed: its own seed, 0 <= seed < 2**63.
        name: what a person calls it; may be empty.

    Raises:
        GenerateError: an id of other characters, a seed out of range, no suite or aim, text that the text format
            could not give back, or a line that is no command in its one spelling.
    """

    id: str
    suite: str
    aim: str
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
        for key, text in (("suite", self.suite), ("aim", self.aim), ("name", self.name)):
            if text != " ".join(text.split()) or not (text or key == "name"):
                raise GenerateError(f"test {self.id}: {key} {text!r}: expected one line with single spaces only")
        for word in (*self.beliefs, *self.plans, *(label for labels in self.plans.values() for label in labels)):
            if word.split() != [word]:
                raise GenerateError(f"test {self.id}: {word!r}: expected one word for a belief, an agent or a plan")
        for line in self.lines:
            if (spelling := command_of(line)) != line:
                raise GenerateError(f"test {self.id}: command {line!r}: expected the spelling {spelling!r}")


def command_of(text: str) -> str:
    """A command in its one spelling: `set_param gaze=1` is `set_param gaze = 1`.

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


def action_from_command(command: str) -> str:
    """The external action of a command: `set_param gaze = 1` gives `set_param(gaze, 1)`.

    Raises:
        GenerateError: it is no command.
    """
    name, *arguments = command_of(command).replace(" = ", " ").split()
    return f"{name}({', '.join(arguments)})" if arguments else name


def _spell(parts: Sequence[str | None]) -> str:
    name, first, second = parts
    if first is None:
        return str(name)
    return f"{name} {first}" if second is None else f"{name} {first} = {second}"
