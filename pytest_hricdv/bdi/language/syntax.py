"""The syntax tree of an agent's `Program`, which the parser builds and the agent executes: rules, plans, statements.

A `Plan` has a context (a formula, such as `And`) and a body of statements, such as `AchievementGoal`.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.terms import (
    AnnotatedVariable,
    Call,
    Key,
    PlanTerm,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
)

TRUE = Structure("true")


@dataclass(frozen=True, slots=True)
class And:
    """All parts hold, tried from left to right."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' & '.join(map(str, self.parts))})"


@dataclass(frozen=True, slots=True)
class Or:
    """Some part holds, tried from left to right."""

    parts: tuple[Formula, ...]

    def __str__(self) -> str:
        return f"({' | '.join(map(str, self.parts))})"


@dataclass(frozen=True, slots=True)
class Not:
    """Negation as failure: the part has no solution."""

    part: Formula

    def __str__(self) -> str:
        return f"not ({self.part})"


@dataclass(frozen=True, slots=True)
class Comparison:
    """A relation between two terms; ``=`` unifies them, the others compare values."""

    operator: str
    left: Term
    right: Term

    def __str__(self) -> str:
        return f"({self.left} {self.operator} {self.right})"


Formula = Structure | Variable | AnnotatedVariable | QualifiedLiteral | Call | And | Or | Not | Comparison
GoalTerm = Structure | Variable | AnnotatedVariable | QualifiedLiteral
"""The object of a goal, test or belief: a literal, or a variable that stands for one."""


def ground_event_literal(literal: GoalTerm | PlanTerm) -> Structure | None:
    """The literal of the event that a statement creates, with a source; None if it has variables."""
    return literal.with_own_source() if isinstance(literal, Structure) and literal.ground else None


@dataclass(frozen=True, slots=True)
class AchievementGoal:
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
class TestGoal:
    """``?f``: the formula must hold, and binds variables."""

    formula: Formula
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f"?{self.formula}"


@dataclass(frozen=True, slots=True)
class BeliefUpdate:
    """An update of a belief, or of a rule, ``+{ a :- b }``.

    ``sign`` is ``+``, ``-``, ``-+``, or ``++`` (``+`` whose plan runs in a new intention).
    """

    sign: str
    literal: GoalTerm | PlanTerm
    location: Location = field(compare=False)
    event_literal: Structure | None = field(init=False, compare=False, repr=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "event_literal", ground_event_literal(self.literal))

    def __str__(self) -> str:
        return f"{self.sign}{self.literal}"


@dataclass(frozen=True, slots=True)
class ExternalAction:
    """An external action, executed by the environment."""

    action: GoalTerm
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.action)


@dataclass(frozen=True, slots=True)
class InternalActionCall:
    """An internal action as a statement."""

    call: Call
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.call)


@dataclass(frozen=True, slots=True)
class ConditionStatement:
    """A comparison or other condition as a statement: ``X = Y + 1``."""

    formula: Formula
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return str(self.formula)


@dataclass(frozen=True, slots=True)
class If:
    """``if (condition) { then } else { otherwise }``."""

    condition: Formula
    then: Body
    otherwise: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        otherwise = f",{block_text(self.otherwise)}" if self.otherwise else ""
        return f".if_then_else({self.condition},{block_text(self.then)}{otherwise})"


@dataclass(frozen=True, slots=True)
class While:
    """``while (condition) { body }``."""

    condition: Formula
    body: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f".loop({self.condition},{block_text(self.body)})"


@dataclass(frozen=True, slots=True)
class For:
    """``for (condition) { body }``: once for each solution that exists at its start."""

    condition: Formula
    body: Body
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f".foreach({self.condition},{block_text(self.body)})"


@dataclass(frozen=True, slots=True)
class ForkStatement:
    """``!a |&| !b``, until all branches are done, or ``!a ||| !b``, until one is."""

    branches: tuple[Body, ...]
    needs_all: bool
    location: Location = field(compare=False)

    def __str__(self) -> str:
        return f".fork({'and' if self.needs_all else 'or'},{','.join(map(block_text, self.branches))})"


Statement = (
    AchievementGoal
    | TestGoal
    | BeliefUpdate
    | ExternalAction
    | InternalActionCall
    | ConditionStatement
    | If
    | While
    | ForkStatement
    | For
)
Body = tuple[Statement, ...]


def block_text(body: Body) -> str:
    """A body in braces."""
    return f"{{ {'; '.join(map(str, body))} }}"


EventKey = tuple[str, Key]
"""The index of plans: the sign of the event, and the key of its literal."""
GOAL_STATE = "^!"
"""The sign of an event that says what has become of an achievement goal, in its annotation ``state(S)``."""
STATE = (False, "state", 1)
"""The key of the annotation."""
GOAL_STATES = ("started", "finished", "failed")
"""The states of a goal in Jason 1.4.2: the values of ``state``. It has ``suspended`` and ``resumed``, too."""
SIGNS = ("+", "-", "+!", "-!", "+?", "-?", GOAL_STATE)
"""The signs of events: of beliefs, achievement goals and test goals, and of the states of goals."""


def with_state(goal: Structure, state: str) -> Structure:
    """The literal of the event that says what has become of a goal."""
    return goal.with_annotations((*goal.annots, Structure("state", (Structure(state),))))


@dataclass(frozen=True, slots=True)
class PlanTrigger:
    """A triggering event; ``sign`` is one of :data:`SIGNS`."""

    sign: str
    literal: GoalTerm

    @property
    def key(self) -> EventKey | None:
        """The key of the events it matches; None if the literal is a variable, which matches any event of that sign."""
        return (self.sign, self.literal.key) if isinstance(self.literal, Structure) else None

    def __str__(self) -> str:
        return f"{self.sign}{self.literal}"


@dataclass(frozen=True, slots=True)
class Plan:
    """``@label trigger : context <- body``.

    ``label`` is that of the source, or an automatic one that starts with ``_``, which no source can contain.
    """

    label: str
    trigger: PlanTrigger
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
        """Whether the source gives it a label."""
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
    """``{ include("file.asl", space) }``; without a namespace, what is included is in that of the including source."""

    path: str
    location: Location
    space: str | None = None


@dataclass(frozen=True, slots=True)
class Program:
    """The source of one agent: its initial beliefs and rules, its initial goals, and its plans.

    ``warnings`` say what its author should know about how it was read, each with its place.
    """

    file: str
    beliefs: tuple[Structure | Rule, ...]
    goals: tuple[Structure, ...]
    plans: tuple[Plan, ...]
    warnings: tuple[str, ...] = ()
    last_number: int = 0
    """No variable is ``_n`` for a greater number n."""
