"""The compiled form of an agent's program: what it does on events, and its plans, as Python functions."""

from __future__ import annotations

from collections.abc import Callable, MutableMapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from pytest_hricdv.bdi.language.syntax import EventKey, Plan
from pytest_hricdv.bdi.language.terms import Key, Structure, Term, Variable

if TYPE_CHECKING:
    from .activity import Activity
    from .agent import CompiledAgent

Annots = tuple[Term, ...]
Calm = tuple[int, int]
"""Cycles: with nothing that waits for what is being done, and with a plan that goes on afterwards."""
Values = tuple[object, ...]
"""What the variables of a plan's body stand for, in the order of :attr:`PlanCode.variables`, None where nothing,
and then for each of its loops under way the solutions that are left."""
Slot = Any
"""A proposition's name, or a belief's arguments."""
Store = MutableMapping[Slot, Annots]
"""Beliefs by their slots, with their annotations, the oldest first. A dictionary, but maybe one that notes who looks:
declared as one, compiled code would look past that."""
Select = Callable[["CompiledAgent", Store, list[Store], tuple[Term, ...], Annots], "tuple[PlanCode, Values] | None"]
"""Finds a plan for the arguments and the annotations of an event."""
Run = Callable[["CompiledAgent", Store, list[Store], "Activity", int, Values, int], int]
"""Executes an activity's statements from a number on, with the values of its variables, for at most so many cycles.
Returns those left if the activity can use them now; else those not needed, as a negative number."""


@dataclass(frozen=True, slots=True)
class LoopCode:
    """A loop.

    Args:
        outer: the variables bound before it.
        new: the variables bound by each solution of its condition.
    """

    outer: tuple[Variable, ...]
    new: tuple[Variable, ...]


@dataclass(slots=True, eq=False)
class PlanCode:
    """A plan.

    Args:
        plan: what it was compiled from.
        variables: the variables in its body.
        loops: its loops by the number of their statement; each has a place among the values, after the variables.
        after: for each statement, in the order of the text, the number of the one to go on with.
        last: the number of the last statement, if no block is around it; else -1.
        forgotten: whether it need not be remembered once it has nothing left to do.
    """

    plan: Plan
    variables: tuple[Variable, ...]
    loops: dict[int, LoopCode]
    after: tuple[int, ...]
    last: int
    forgotten: bool
    label: str = field(init=False)
    end: int = field(init=False)
    """The number after the last statement: where the plan is finished."""
    run: Run = field(init=False, repr=False)
    """Set when the source of the whole program is compiled: its functions name each other's plans."""

    def __post_init__(self) -> None:
        self.label = self.plan.label
        self.end = len(self.after)


@dataclass(slots=True, eq=False)
class TriggerCode:
    """What an agent does on an event.

    Args:
        sign: that of the event.
        key: that of its literal.
        select: finds the first applicable plan; None when no plan is for such an event. It returns None if there is
            none, or, for a goal, if that is left to the interpreter.
    """

    sign: str
    key: Key
    select: Select | None = None
    calm: Calm = (0, 0)
    """For how many cycles the agent keeps to itself from the one on in which it selects a plan."""
    is_goal: bool = field(init=False)

    def __post_init__(self) -> None:
        self.is_goal = self.sign == "+!"


@dataclass(slots=True, eq=False)
class ProgramCode:
    """All that is the same for all agents with a program.

    Args:
        relevant: the events that plans are for.
        triggers: what to do on events, those without a plan included.
        noticed: what to do when a belief has come that a plan is for.
        tables: the place of the table of each predicate with arguments that the program tests.
        selects: the name of the function that selects a plan, for each event that plans are for.
        lines: the actions that are done together and are always the same.
        letters: the messages that are always the same: to whom, whether told, what.
        forms: the messages that differ: to whom, whether told, and what but for the arguments, if they alone differ.
        source: the Python text, to be read by people.
    """

    relevant: frozenset[EventKey]
    triggers: dict[EventKey, TriggerCode] = field(default_factory=dict)
    noticed: dict[Key, TriggerCode] = field(default_factory=dict)
    tables: dict[Key, int] = field(default_factory=dict)
    selects: dict[EventKey, str] = field(default_factory=dict)
    lines: list[tuple[str, ...]] = field(default_factory=list)
    letters: list[tuple[str, bool, Structure]] = field(default_factory=list)
    forms: list[tuple[str, bool, Structure | None]] = field(default_factory=list)
    source: str = ""

    def trigger(self, sign: str, key: Key) -> TriggerCode:
        """What to do on an event."""
        found = self.triggers.get((sign, key))
        if found is None:
            found = self.triggers[sign, key] = TriggerCode(sign, key)
        return found

    def table(self, literal: Structure) -> str:
        """The Python expression for the table of a predicate with arguments."""
        return f"b[{self.tables.setdefault(literal.key, len(self.tables))}]"


def proposition(literal: Structure) -> str:
    """The name under which a literal without arguments is kept."""
    return f"~{literal.functor}" if literal.negated else literal.functor
