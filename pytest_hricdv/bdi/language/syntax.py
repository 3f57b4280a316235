"""The syntax tree of an AgentSpeak program: statements, plans, rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.formulas import And, Comparison, Formula, GoalTerm, Not, Or
from pytest_hricdv.bdi.language.terms import (
    SOURCE_SELF,
    AnnotatedVariable,
    Arithmetic,
    Call,
    Key,
    ListTerm,
    PlanTerm,
    Structure,
    Term,
    Variable,
)

NO_LOCATION = Location("<text>", 1, 1)
"""The place of what was not read from a file."""


def ground_event_literal(literal: GoalTerm) -> Structure | None:
    """The literal of the event that a statement posts, with a source; None if it has variables."""
    if not isinstance(literal, Structure) or not literal.ground:
        return None
    return literal if literal.has_source() else literal.with_annotations((*literal.annots, SOURCE_SELF))


@dataclass(frozen=True, slots=True)
class Executable:
    """A statement keeps the function that executes it, which is made when it is executed for the first time."""

    step: Callable[..., bool | None] | None = field(default=None, init=False, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class AchievementGoal(Executable):
    """``!g``, or ``!!g``, which starts a new intention."""

    literal: GoalTerm
    new_intention: bool
    location: Location = field(compare=False)
    event_literal: Structure | None = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "event_literal", ground_event_literal(self.literal))

    def __str__(self) -> str:
        return f"{'!!' if self.new_intention else '!'}{self.literal}"


@dataclass(frozen=True, slots=True)
class TestGoal(Executable):
    """``?f``: the formula must hold, and binds variables."""

    formula: Formula
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f"?{self.formula}"


@dataclass(frozen=True, slots=True)
class BeliefUpdate(Executable):
    """A belief update; ``sign`` is ``+``, ``-``, ``-+``, or ``++`` (``+`` whose plan runs in a new intention)."""

    sign: str
    literal: GoalTerm
    location: Location = field(compare=False)
    event_literal: Structure | None = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "event_literal", ground_event_literal(self.literal))

    def __str__(self) -> str:
        return f"{self.sign}{self.literal}"


@dataclass(frozen=True, slots=True)
class ExternalAction(Executable):
    """An external action, executed by the environment."""

    action: GoalTerm
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.action)


@dataclass(frozen=True, slots=True)
class InternalActionCall(Executable):
    """An internal action as a statement."""

    call: Call
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.call)


@dataclass(frozen=True, slots=True)
class ConditionStatement(Executable):
    """A comparison or other condition as a statement: ``X = Y + 1``."""

    formula: Formula
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.formula)


@dataclass(frozen=True, slots=True)
class If(Executable):
    """``if (condition) { then } else { otherwise }``."""

    condition: Formula
    then: Body
    otherwise: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        otherwise = f" else {block_text(self.otherwise)}" if self.otherwise else ""
        return f"if ({self.condition}) {block_text(self.then)}{otherwise}"


@dataclass(frozen=True, slots=True)
class While(Executable):
    """``while (condition) { body }``."""

    condition: Formula
    body: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f"while ({self.condition}) {block_text(self.body)}"


@dataclass(frozen=True, slots=True)
class For(Executable):
    """``for (condition) { body }``: once for every solution found at its start."""

    condition: Formula
    body: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f"for ({self.condition}) {block_text(self.body)}"


Statement = (
    AchievementGoal
    | TestGoal
    | BeliefUpdate
    | ExternalAction
    | InternalActionCall
    | ConditionStatement
    | If
    | While
    | For
)
Body = tuple[Statement, ...]


def block_text(body: Body) -> str:
    """A body in braces."""
    return f"{{ {'; '.join(map(str, body))} }}"


EventKey = tuple[str, Key]
"""What plans are indexed by: the sign of the event, and the key of its literal."""


SIGNS = ("+", "-", "+!", "-!", "+?", "-?")
"""Of beliefs, of goals, of test goals."""


@dataclass(frozen=True, slots=True)
class Trigger:
    """A triggering event; ``sign`` is one of :data:`SIGNS`."""

    sign: str
    literal: GoalTerm

    @property
    def key(self) -> EventKey | None:
        """Index of the plans that may handle it; None when the literal is a variable: any event of that sign."""
        return (self.sign, self.literal.key) if isinstance(self.literal, Structure) else None

    def __str__(self) -> str:
        return f"{self.sign}{self.literal}"


@dataclass(frozen=True, slots=True)
class Plan:
    """``@label trigger : context <- body``.

    ``label`` is the author's, or an automatic one starting with ``_``, which no author can write.
    """

    label: str
    trigger: Trigger
    context: Formula | None
    body: Body
    location: Location = field(compare=False)
    annots: tuple[Term, ...] = ()
    builtin: bool = False
    atomic: bool = field(init=False, compare=False)
    matches_every_event: bool = field(init=False, compare=False)
    """Whether the plan is relevant for every event with the key of its trigger."""
    is_busy_wait: bool = field(init=False, compare=False)
    """Whether it only pursues its own goal again, ``+!w : not x <- !w``."""

    def __post_init__(self) -> None:
        object.__setattr__(self, "atomic", Structure("atomic") in self.annots)
        wanted = self.trigger.literal
        is_plain_atom = isinstance(wanted, Structure) and wanted.ground and not wanted.args and not wanted.annots
        object.__setattr__(self, "matches_every_event", is_plain_atom)
        object.__setattr__(self, "is_busy_wait", not self.atomic and self._only_pursues_itself())

    def _only_pursues_itself(self) -> bool:
        goal = self.trigger.literal
        if self.trigger.sign != "+!" or len(self.body) != 1 or not isinstance(goal, Structure):
            return False
        (again,) = self.body
        is_same = isinstance(again, AchievementGoal) and not again.new_intention and again.literal == goal
        return is_same and goal.ground and not goal.annots

    @property
    def has_label(self) -> bool:
        """Whether its author gave it a label."""
        return not self.label.startswith("_")

    def __str__(self) -> str:
        annots = f"[{','.join(map(str, self.annots))}]" if self.annots else ""
        label = f"@{self.label}{annots} " if self.has_label else ""
        context = f" : {self.context}" if self.context not in (None, TRUE) else ""
        body = f" <- {'; '.join(map(str, self.body))}" if self.body else ""
        return f"{label}{self.trigger}{context}{body}"


@dataclass(frozen=True, slots=True)
class Rule:
    """``head :- body``."""

    head: Structure
    body: Formula
    location: Location = field(compare=False)
    variables: tuple[Variable, ...] = ()

    def __str__(self) -> str:
        return f"{self.head} :- {self.body}"


@dataclass(frozen=True, slots=True)
class InitialGoal:
    """``!g.`` at the top level."""

    literal: Structure


@dataclass(frozen=True, slots=True)
class Include:
    """``{ include("file.asl") }``."""

    path: str
    location: Location


@dataclass(frozen=True, slots=True)
class Program:
    """One agent's source: what it believes and wants at first, and how it acts."""

    file: str
    beliefs: tuple[Structure | Rule, ...]
    goals: tuple[Structure, ...]
    plans: tuple[Plan, ...]


TRUE = Structure("true")


def variables_of(node: object) -> set[Variable]:
    """The variables in a term or formula."""
    return {part for part in parts_of(node) if isinstance(part, Variable)}


def parts_of(node: object) -> Iterator[object]:
    """A term, formula, statement or plan, or a tuple of them, and all its parts, in the order of the text."""
    pending = [node]
    while pending:
        part = pending.pop()
        yield part
        pending.extend(reversed(children(part)))


def children(node: object) -> tuple[object, ...]:
    """The parts of a term, formula or statement, one level down."""
    if isinstance(node, tuple):
        return node
    return tuple(value for name in child_fields(node) if (value := getattr(node, name)) is not None)


def child_fields(node: object) -> tuple[str, ...]:
    """The attributes that hold the parts of a term, formula or statement."""
    return _CHILDREN.get(type(node), ())


_CHILDREN: dict[type, tuple[str, ...]] = {
    Structure: ("args", "annots", "annots_tail"),
    AnnotatedVariable: ("variable", "annots", "annots_tail"),
    Call: ("args",),
    ListTerm: ("items", "tail"),
    Arithmetic: ("operands",),
    PlanTerm: ("plan",),
    And: ("parts",),
    Or: ("parts",),
    Not: ("part",),
    Comparison: ("left", "right"),
    AchievementGoal: ("literal",),
    TestGoal: ("formula",),
    BeliefUpdate: ("literal",),
    ExternalAction: ("action",),
    InternalActionCall: ("call",),
    ConditionStatement: ("formula",),
    If: ("condition", "then", "otherwise"),
    While: ("condition", "body"),
    For: ("condition", "body"),
    Trigger: ("literal",),
    Plan: ("trigger", "context", "body"),
    Rule: ("head", "body"),
}
