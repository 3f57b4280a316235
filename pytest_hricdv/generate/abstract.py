"""`AbstractTest`: a sequence of commands to the person or device that interacts with the robot; its id and seed.

Generation methods and the closing loop make an `AbstractDraft`; `identify` adds id and seed, which makes it a test.

The text format is that of the paper's experiment: one command per line, blank lines between tests, `#` begins a
comment. Comment lines of the form `# key: value` directly above the commands hold the other fields of a test, so that
an exported suite reads back unchanged (`target` is what generation aimed at):

    # id: by-hand-leg4-d2a01c9e
    # suite: by-hand
    # target: leg4
    # beliefs: leg4 m111l4
    # seed: 6714903881632941057
    # name: one leg, human ready
    # plans human: plan4 plan5
    # values run: outage_turn 2.0
    # values 3: distance_m 0.55, offset_m 0.125
    tell leg
    receivesignal
    set_param gaze = 1

`values N` fixes parameters of the N-th command (from 1), and `values run` parameters of the run, within their declared
ranges. All others are drawn, as in a test without values.

With several actors, each command says who acts; `after N` lists the commands of others, by their numbers, that have to
be done before the N-th begins (see `actors`):

    # after 2: 1
    nurse: press call
    child: run corridor

Ids and seeds depend on the content of a test: never on its place in a suite, the machine or the clock.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any, ClassVar

from msgspec import Struct, ValidationError, convert

from pytest_hricdv._base.message import quote
from pytest_hricdv.generate import GenerateError, chosen_values, name_place
from pytest_hricdv.generate.actors import After, after_from_data, after_to_data, check_after
from pytest_hricdv.generate.chosen_values import Values
from pytest_hricdv.generate.rng import canonical_json, derive_seed, digest

#: Executed coverage plans: agent -> plan labels, sorted.
Plans = Mapping[str, tuple[str, ...]]

# \Z and not $, here and wherever input is checked: $ matches before a line break at the end, too.
_ID = re.compile(r"[A-Za-z0-9_-]+\Z")
MAX_SUITE_NAME = 100
"""Maximum length of a suite's name, in characters: it is a part of file names, which have at most 255."""
_NOT_IN_IDS = re.compile(r"[^A-Za-z0-9_]+")
_WORD = r"[A-Za-z_]\w*"
_VALUE = rf"(?:{_WORD}|[+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)"
# ASCII: else \w and \d take the letters and digits of all scripts, and two spellings of a number are two commands.
_ACTION = re.compile(rf"\s*({_WORD})\s*(?:\(\s*({_VALUE})\s*(?:,\s*({_VALUE})\s*)?\))?\s*\Z", re.ASCII)
_COMMAND = re.compile(rf"\s*(?:({_WORD})\s*:\s*)?({_WORD})(?:\s+({_VALUE})(?:\s*=\s*({_VALUE}))?)?\s*\Z", re.ASCII)
_DISTURB = "disturb"
SEED_LIMIT = 2**63  # signed 64-bit integers are the largest of TOML, SQLite and Arrow


class TestData(Struct, frozen=True):
    """A test as the JSON of suites and replay files has it; see `AbstractTest.to_data`."""

    __test__: ClassVar[bool] = False

    id: str
    suite: str
    target: str
    name: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Mapping[str, tuple[str, ...]]
    seed: int
    values: Mapping[str, Mapping[str, float]] = {}
    after: Mapping[str, tuple[int, ...]] = {}


@dataclass(frozen=True)
class AbstractTest:
    """One abstract test.

    Args:
        id: the name used everywhere: letters, digits, `_`, `-`.
        suite: the suite it was generated for, in the characters of an id.
        target: what the test is to exercise, in a few words; part of the id.
        beliefs: the belief subset it came from, in declared order; empty if from none.
        lines: its commands, in the text format.
        plans: the coverage plans that the model executed in the run it came from.
        seed: its own seed, 0 <= seed < 2**63.
        name: a title for people; may be empty.
        values: parameters that were chosen instead of drawn, by the number of their command (from 1; 0 is the run).
        after: which commands of other actors have to be done before a command begins, by numbers from 1.

    Raises:
        GenerateError: other characters in the id or the suite, a seed out of range, no target, text that the text
            format cannot represent, a line that is not a command in canonical spelling, or values or an order of no
            command of the test.
    """

    id: str
    suite: str
    target: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Plans = field(default_factory=dict, hash=False)
    seed: int = 0
    name: str = ""
    values: Values = field(default_factory=dict, hash=False)
    after: After = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not _ID.match(self.id):
            raise GenerateError(f"test id {self.id!r}: expected letters, digits, '_' and '-' only")
        if not 0 <= self.seed < SEED_LIMIT:
            raise GenerateError(f"test {self.id}: seed {self.seed} is out of range; expected 0 <= seed < 2**63")
        check_suite_name(self.suite)
        for key, text in (("target", self.target), ("name", self.name)):
            if text != " ".join(text.split()) or not (text or key == "name"):
                raise GenerateError(f"test {self.id}: {key} {text!r}: expected one line with single spaces only")
        for word in (*self.beliefs, *self.plans, *(label for labels in self.plans.values() for label in labels)):
            if word.split() != [word]:
                raise GenerateError(f"test {self.id}: {word!r}: expected one word for a belief, an agent or a plan")
        for line in self.lines:
            if (spelling := canonical_command(line)) != line:
                raise GenerateError(f"test {self.id}: command {line!r}: expected the spelling {spelling!r}")
        with name_place(f"test {self.id}"):
            chosen_values.check(self.values, len(self.lines))
            check_after(self.after, self.lines)

    def to_data(self) -> dict[str, Any]:
        """Plain data for JSON, with the keys of replay files; `values` and `after` only if there are any."""
        values = {"values": chosen_values.to_data(self.values)} if self.values else {}
        after = {"after": after_to_data(self.after)} if self.after else {}
        return {
            "id": self.id,
            "suite": self.suite,
            "target": self.target,
            "beliefs": list(self.beliefs),
            "lines": list(self.lines),
            "plans": {agent: list(labels) for agent, labels in self.plans.items()},
            "seed": self.seed,
            "name": self.name,
            **values,
            **after,
        }

    @classmethod
    def from_data(cls, data: Mapping[str, Any] | TestData) -> AbstractTest:
        """The test that `to_data` gave. Raises GenerateError: see the class; or the data has another shape."""
        if not isinstance(data, TestData):
            try:
                data = convert(data, TestData)
            except ValidationError as error:
                raise GenerateError(f"not a test: {error}; expected what AbstractTest.to_data gives") from None
        return cls(
            id=data.id,
            suite=data.suite,
            target=data.target,
            beliefs=data.beliefs,
            lines=data.lines,
            plans=data.plans,
            seed=data.seed,
            name=data.name,
            values=chosen_values.from_data(data.values),
            after=after_from_data(data.after),
        )


def canonical_command(text: str) -> str:
    """A command in canonical spelling: `set_param gaze=1` gives `set_param gaze = 1`, `nurse:wait` gives `nurse: wait`.

    Raises:
        GenerateError: it is not a command.
    """
    match = _COMMAND.match(text)
    if match is None:
        raise GenerateError(
            f"{quote(text.strip())} is not a command; expected 'name', 'name value' or 'name parameter = value', "
            "after 'actor: ' where the model has several"
        )
    actor, *parts = match.groups()
    return f"{actor}: {_spell(parts)}" if actor else _spell(parts)


def disturbance_of(line: str) -> str | None:
    """The name of the disturbance that a line of a test is; None for an action.

    >>> disturbance_of("disturb leg_slips"), disturbance_of("tell leg")
    ('leg_slips', None)
    """
    word, _, name = line.partition(" ")
    return name if word == _DISTURB and name else None


def disturbance_line(name: str) -> str:
    """The line of a test at which a disturbance happens: `disturb NAME`."""
    return f"{_DISTURB} {name}"


def command_from_action(action: str, actor: str = "") -> str:
    """The command of an external action: `set_param(gaze, 1)` gives `set_param gaze = 1`.

    Args:
        action: as AgentSpeak.
        actor: who does it, where the model has several actors: `nurse` gives `nurse: set_param gaze = 1`.

    Raises:
        GenerateError: the action has no text form: more than two arguments, or one that is not an atom, name or number.
    """
    match = _ACTION.match(action)
    if match is None:
        raise GenerateError(
            f"action {quote(action)} has no text form; expected a name with at most two arguments, each an atom or a "
            "number"
        )
    return f"{actor}: {_spell(match.groups())}" if actor else _spell(match.groups())


def _spell(parts: Sequence[str | None]) -> str:
    name, first, second = parts
    if first is None:
        return str(name)
    return f"{name} {first}" if second is None else f"{name} {first} = {second}"


@dataclass(frozen=True)
class AbstractDraft:
    """An abstract test without an id, as a method generates it; the fields are those of `AbstractTest`.

    Its seed comes from its content, unless it has the seed of the test whose beginning it is.
    """

    target: str
    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Plans = field(default_factory=dict, hash=False)
    name: str = ""
    values: Values = field(default_factory=dict, hash=False)
    seed: int | None = None
    after: After = field(default_factory=dict, hash=False)

    def as_test(self, test_id: str, suite: str, seed: int) -> AbstractTest:
        """The test with these contents."""
        content = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return AbstractTest(**{**content, "id": test_id, "suite": suite, "seed": seed})


def check_suite_name(name: str) -> None:
    """Raises GenerateError for a name that is none: files are named after suites."""
    if not _ID.match(name) or len(name) > MAX_SUITE_NAME:
        expected = f"expected letters, digits, '_' and '-' only, at most {MAX_SUITE_NAME}"
        raise GenerateError(f"suite name {quote(name)}: {expected}")


def slug(text: str) -> str:
    """The text in the characters of an id: letters, digits, `_` and `-`."""
    return _NOT_IN_IDS.sub("-", text).strip("-") or "test"


def target_of_commands(commands: Collection[str]) -> str:
    """The target of a test that came from no beliefs: its number of actions."""
    return f"{len(commands)}-actions"


def seed_of_test(master_seed: int, suite: str, beliefs: Sequence[str], lines: Sequence[str], occurrence: int) -> int:
    """A test's own seed, 63 bits. Equal texts from different subsets have different seeds.

    Chosen values do not change it: so whatever was not chosen is as in the test without them.
    """
    return derive_seed("seed", master_seed, suite, tuple(beliefs), tuple(lines), occurrence)


def content_digest(
    suite: str, beliefs: Sequence[str], lines: Sequence[str], seed: int, occurrence: int, values: Values, after: After
) -> str:
    """SHA-256 (hex) of everything that distinguishes a test from others; its id has the first 8 digits."""
    # A test without chosen values keeps the id it had before values existed.
    chosen = [canonical_json(chosen_values.to_data(values))] if values else []
    chosen += ["after", canonical_json(after_to_data(after))] if after else []
    return digest("id", suite, tuple(beliefs), tuple(lines), seed, occurrence, *chosen)


def identify(suite: str, master_seed: int, drafts: Iterable[AbstractDraft]) -> tuple[AbstractTest, ...]:
    """Give drafts their ids and seeds, in order.

    Drafts of equal content are numbered among themselves (their occurrence), so that the order of different drafts
    does not matter. If two different contents share 8 digits (about one suite in a million of 134 tests), both ids
    have 16 digits.
    """
    occurrences: dict[tuple[tuple[str, ...], tuple[str, ...], str, str, int | None], int] = {}
    numbered: list[tuple[AbstractDraft, int, str]] = []
    for draft in drafts:
        values, after = canonical_json(chosen_values.to_data(draft.values)), canonical_json(after_to_data(draft.after))
        content = (draft.beliefs, draft.lines, values, after, draft.seed)
        occurrence = occurrences[content] = occurrences.get(content, -1) + 1
        drawn = seed_of_test(master_seed, suite, draft.beliefs, draft.lines, occurrence)
        seed = drawn if draft.seed is None else draft.seed
        code = content_digest(suite, draft.beliefs, draft.lines, seed, occurrence, draft.values, draft.after)
        numbered.append((draft, seed, code))
    short_ids = [id_of_test(suite, draft.target, code[:8]) for draft, _, code in numbered]
    uses = Counter(short_ids)
    return tuple(
        draft.as_test(short if uses[short] == 1 else id_of_test(suite, draft.target, code[:16]), suite, seed)
        for short, (draft, seed, code) in zip(short_ids, numbered, strict=True)
    )


def id_of_test(suite: str, target: str, code: str) -> str:
    """The id of a test, with the first digits of its content's digest."""
    return f"{slug(suite)}-{slug(target)}-{code}"
