"""The `Vocabulary` that requirements are written in: a testbench's signals and messages, and a file's definitions.

`Testbench.vocabulary` gives one, and the parser checks each name in a formula against it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from pytest_hricdv._base.message import nearest
from pytest_hricdv.monitor.node import IDENTIFIER, Kind, PastFormula, TextTerm, field_of
from pytest_hricdv.monitor.past_formula import OPERATORS
from pytest_hricdv.monitor.units import QuantityTerm, Unit, unit_of

_WORDS = ("always", "eventually", "until", "since", "on", "not", "hysteresis", "for", "inf")
KEYWORDS = frozenset((*OPERATORS, *_WORDS))
"""Words of the requirement language, which cannot be names."""


@dataclass(frozen=True)
class Definition:
    """A name for an expression that requirements share.

    Attributes:
        text: the expression as written.
        kind: `bool` of a condition, `float` of a number, `str` of a text.
        meaning: the expression as data, with the definitions in it replaced by their meanings.
        uses: the definitions in it.
        nodes: how many operators and operands `meaning` has.
        depth: how many of them are in each other.
    """

    text: str
    kind: Kind
    meaning: PastFormula | QuantityTerm | TextTerm
    uses: frozenset[str] = frozenset()
    nodes: int = 1
    depth: int = 1


@dataclass(frozen=True)
class Vocabulary:
    """The names that formulas may use, with their types.

    Attributes:
        signals: name -> `bool`, `float` or `str`; piecewise constant in time.
        messages: topic -> fields, each field -> `bool`, `float` or `str`. A field of a nested message has dots.
        values: string signal, or string field as `topic.field` -> all values that it can have; absent if unknown. A
            comparison with any other value is an error.
        units: numeric signal, or numeric field as `topic.field` -> its unit, such as "m/s"; absent if not declared.
        definitions: name -> what it stands for; of a file of requirements, see `loading.load_definitions`.

    Raises:
        ValueError: a name that a formula cannot contain (no identifier, or a keyword), another type, values of what is
            no text, or a unit of an unknown name.

    >>> vocabulary = Vocabulary(
    ...     signals={"arm_speed": float},
    ...     messages={"state": {"name": str}, "request": {}},
    ...     values={"state.name": ("Idle", "Move_hand")},
    ... )
    >>> vocabulary.full_name("state"), vocabulary.kind("state.name")
    ('state.name', <class 'str'>)
    """

    signals: Mapping[str, Kind] = field(default_factory=dict)
    messages: Mapping[str, Mapping[str, Kind]] = field(default_factory=dict)
    values: Mapping[str, Sequence[str]] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    definitions: Mapping[str, Definition] = field(default_factory=dict)

    def __post_init__(self) -> None:
        for name, kind in self.signals.items():
            _check_declaration(f"signal {name!r}", name, kind)
        for topic, fields in self.messages.items():
            _check_declaration(f"topic {topic!r}", topic, bool)
            for name, kind in fields.items():
                for part in name.split("."):  # of nested messages; after a dot, a keyword is a name
                    _check_declaration(f"field {name!r} of topic {topic!r}", part, kind, ())
        for name, values in self.values.items():
            self._check_values(name, values)
        for name in self.units:
            if self.kind(name) is None:
                suggestion = nearest(name, self.names())
                raise ValueError(f"units has {name!r}, which is neither a signal nor a topic.field{suggestion}")

    def kind(self, name: str) -> Kind | None:
        """The type of a definition, of a signal, or of a field written as `topic.field`; None for an unknown name."""
        topic, dot, member = name.partition(".")
        if name in self.definitions:
            return self.definitions[name].kind
        return self.messages.get(topic, {}).get(member) if dot else self.signals.get(name)

    def unit(self, name: str) -> Unit | None:
        """The declared unit of a signal or field, or of `last(topic.field)`; None if there is none."""
        declared = self.units.get(name) or self.units.get(field_of(name))
        return unit_of(declared) if declared else None

    def full_name(self, name: str) -> str:
        """The name with the field that it leaves out: a topic with one field, a number or a string, means that field.

        A field that is a bool is not left out: the topic alone would look like the arrival of a message.
        """
        # A signal hides a topic of its name; `topic.field` still reaches the fields.
        fields = {} if name in self.signals else self.messages.get(name, {})
        [*members] = (f"{name}.{member}" for member, kind in fields.items() if kind is not bool)
        return members[0] if len(members) == len(fields) == 1 else name

    def names(self) -> list[str]:
        """All signals, all fields as `topic.field`, and all definitions."""
        fields = (f"{topic}.{name}" for topic, names in self.messages.items() for name in names)
        return [*self.signals, *fields, *self.definitions]

    def define(self, name: str, definition: Definition) -> Vocabulary:
        """The vocabulary with one more definition.

        Raises:
            ValueError: no identifier, a keyword, or the name of a signal or topic.
        """
        _check_declaration(f"definition {name!r}", name, definition.kind)
        if name in self.signals or name in self.messages:
            owner = "signal" if name in self.signals else "topic"
            raise ValueError(f"definition {name!r}: there is a {owner} of this name; choose another one")
        return replace(self, definitions={**self.definitions, name: definition})

    def _check_values(self, name: str, values: Sequence[str]) -> None:
        if self.kind(name) is not str:
            texts = [
                candidate
                for candidate in self.names()
                if self.kind(candidate) is str and candidate not in self.definitions
            ]
            raise ValueError(f"values of {name!r}: not a signal or topic.field of type str{nearest(name, texts)}")
        if isinstance(values, str) or not values or not all(isinstance(value, str) for value in values):
            raise ValueError(f"values of {name!r}: expected at least one string, got {values!r}")


def _check_declaration(declaration: str, name: str, kind: Kind, keywords: Collection[str] = KEYWORDS) -> None:
    if not IDENTIFIER.fullmatch(name):
        raise ValueError(f"{declaration}: a name consists of letters, digits and _, and does not start with a digit")
    if name in keywords:
        raise ValueError(f"{declaration}: this is a keyword of the requirement language; choose another name")
    if kind not in (bool, float, str):
        raise ValueError(f"{declaration}: expected the type bool, float or str, got {kind!r}")
