"""How internal actions are defined, found and called."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from pytest_hricdv.bdi.actions.advice import is_foreign, unknown_action
from pytest_hricdv.bdi.agent.agent_state import AgentState, Outcome
from pytest_hricdv.bdi.agent.intentions import Intention
from pytest_hricdv.bdi.language.errors import BdiError, BdiSyntaxError, EvaluationError
from pytest_hricdv.bdi.language.limits import spend
from pytest_hricdv.bdi.language.syntax import Formula, Program
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import (
    VALUE_BY_RULE,
    Call,
    ListTerm,
    Number,
    PlanTerm,
    String,
    Structure,
    Term,
    Variable,
)
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail, undo, unify

Parsed = TypeVar("Parsed")
WRONG = "wrong_arguments"
"""The kind of failure of an action that cannot do with the arguments it is given."""
INTERNAL = "internal_action"
"""The kind of failure of an action that raises an error of its own."""
MANY = 1_000
"""More arguments than any action is given: no upper limit."""


class Invocation:
    """One call of an internal action.

    Args:
        agent: who calls it.
        call: the call as written.
        bindings: the variables bound so far; unifying adds to them.
        trail: what was bound, for backtracking.
        intention: the intention it is a statement of; None in a context, a rule or a test.
    """

    __slots__ = ("agent", "args", "bindings", "call", "failure", "held", "intention", "trail")

    def __init__(
        self, agent: AgentState, call: Call, bindings: Bindings, trail: Trail, intention: Intention | None
    ) -> None:
        self.agent = agent
        self.call = call
        self.args: tuple[Any, ...] = call.args
        self.bindings = bindings
        self.trail = trail
        self.intention = intention
        self.held = False
        """Set by an action that takes its own intention somewhere else than to the next statement."""
        self.failure: tuple[Term, ...] = ()
        """Annotations for the failure event."""

    def value(self, index: int) -> Term:
        """An argument with its variables replaced and its expressions evaluated."""
        term: Term = self.args[index]
        # Most arguments are written out: they need no call.
        return term if type(term) is Structure and term.ground else self.agent.value(term, self.bindings)

    def number(self, index: int) -> float:
        """An argument that has to be a number.

        Raises:
            EvaluationError: it is none.
        """
        value = self.value(index)
        if not isinstance(value, Number):
            raise EvaluationError(f"{self.call}: argument {index + 1} is not a number but {value}", WRONG)
        return float(value)

    def items(self, index: int) -> tuple[Term, ...]:
        """The items of an argument that has to be a list.

        Raises:
            EvaluationError: it is none.
        """
        value = self.value(index)
        if not isinstance(value, ListTerm):
            raise EvaluationError(f"{self.call}: argument {index + 1} is not a list but {value}", WRONG)
        return value.items

    def literal(self, index: int) -> Structure:
        """An argument that has to be a literal.

        Raises:
            EvaluationError: it is none.
        """
        value = self.value(index)
        if not isinstance(value, Structure):
            raise EvaluationError(f"{self.call}: argument {index + 1} is not a literal but {value}", WRONG)
        return value

    def text(self, index: int) -> str:
        """An argument as text, a string without its quotes."""
        value = self.value(index)
        return value.value if isinstance(value, String) else str(value)

    def read(self, text: str, parse: Callable[[str], Parsed], kind: str = WRONG) -> Parsed:
        """What a text says.

        Args:
            text: the text.
            parse: reads it.
            kind: of the failure if it cannot be read.

        Raises:
            EvaluationError: it cannot be read.
        """
        spend(len(text))
        try:
            return parse(text)
        except BdiSyntaxError as error:
            raise EvaluationError(f'{self.call.name}: "{text}" cannot be read: {error.message}', kind) from None

    def formula(self, index: int) -> Formula:
        """An argument that is a condition, as written."""
        formula: Formula = self.args[index]
        return formula

    def is_free(self, index: int) -> bool:
        """Whether an argument is a variable that is not bound."""
        return isinstance(self.value(index), Variable)

    def unify(self, index: int, value: Term) -> bool:
        """Unify an argument with a value; on failure nothing is bound."""
        mark = len(self.trail)
        if unify(self.value(index), value, self.bindings, self.trail):
            return True
        undo(self.bindings, self.trail, mark)
        return False

    def own_intention(self) -> Intention:
        """The intention the call is a statement of.

        Raises:
            BdiError: it is part of a condition, where this action makes no sense.
        """
        if self.intention is None:
            raise BdiError(f"{self.call.location}: {self.call.name} cannot be part of a condition")
        return self.intention


Body = Callable[[Invocation], Outcome]


@dataclass(frozen=True, slots=True)
class InternalAction:
    """A standard internal action.

    Args:
        name: its name, with the dot.
        least: the least number of arguments.
        most: the greatest number of arguments.
        inspects: whether it inspects or changes intentions or plans.
        body: what it does.
    """

    name: str
    least: int
    most: int
    inspects: bool
    body: Body


ACTIONS: dict[str, InternalAction] = {}
FUNCTIONS: dict[str, tuple[int, int]] = {}
"""The names of functions, with the least and the greatest number of their arguments."""


def internal_action(
    name: str, least: int, most: int | None = None, *, inspects: bool = False
) -> Callable[[Body], Body]:
    """Define the action ``.name``, which takes ``least`` to ``most`` arguments.

    Args:
        name: its name, without the dot.
        least: the least number of arguments.
        most: the greatest number of arguments; ``least`` if not given.
        inspects: whether it inspects or changes intentions or plans.
    """

    def define(body: Body) -> Body:
        ACTIONS[f".{name}"] = InternalAction(f".{name}", least, least if most is None else most, inspects, body)
        return body

    return define


def call_action(invocation: Invocation) -> Outcome:
    """Call an internal action, whose name and number of arguments have been checked when the program was loaded.

    Raises:
        BdiError: there is none of this name here, as those of Java: the run cannot go on.
    """
    action = ACTIONS.get(invocation.call.name)
    if action is None:
        see_that_it_is_here(invocation.call)
        raise BdiError(f"{invocation.call.location}: {invocation.call.name} is a function, not an action")
    if len(invocation.args) < action.least:
        # As a function it may have fewer arguments.
        raise _wrong_number(invocation.call, action.least, action.most)
    return action.body(invocation)


def is_function(call: Call) -> bool:
    """Whether a call stands for a value, not for something to do or to ask."""
    action = ACTIONS.get(call.name)
    return call.name in FUNCTIONS and (action is None or len(call.args) < action.least)


def inspects_intentions(program: Program) -> bool:
    """Whether anything in a program may inspect or change intentions, of its own agent or of another one."""
    return any(map(_inspects, parts_of((program.beliefs, program.plans))))


def _inspects(part: object) -> bool:
    if isinstance(part, PlanTerm):
        # A plan or body may be sent or executed, with anything in it.
        return True
    if not isinstance(part, Call):
        return False
    if part.name in _FORCE_AT:
        forces = part.args[_FORCE_AT[part.name] : _FORCE_AT[part.name] + 1]
        return not all(isinstance(force, Structure) and force.functor in _HARMLESS for force in forces)
    action = ACTIONS.get(part.name)
    return action is not None and action.inspects


_HARMLESS = frozenset({"tell", "untell", "achieve", "askOne", "askAll"})
"""Forces of messages that do not make the receiver give up a goal, or learn a plan."""
_FORCE_AT = {".send": 1, ".broadcast": 0}


def check_calls(program: Program) -> None:
    """See that all internal actions and functions of a program exist and get as many arguments as they take.

    Those that exist elsewhere, in Java or in Jason, are no error until they are called: see :func:`foreign_calls`.

    Raises:
        BdiError: with the place of the first that does not, and the nearest names known.
    """
    check_calls_of(program)


def check_calls_of(tree: object) -> None:
    """As :func:`check_calls`, for any part of a program."""
    for call in _calls_of(tree):
        check_call(call)


def foreign_calls(tree: object) -> list[Call]:
    """The calls in a part of a program that end a run, because what they call is in Java, or in Jason, and not here."""
    return [call for call in _calls_of(tree) if _is_missing(call) and is_foreign(call.name)]


def wrong_calls(tree: object) -> list[str]:
    """The errors of :func:`check_calls_of`, all of them."""
    errors: list[str] = []
    for call in _calls_of(tree):
        try:
            check_call(call)
        except BdiError as error:
            errors.append(str(error))
    return errors


def _calls_of(tree: object) -> list[Call]:
    """The calls in a part of a program, in the order of the source."""
    calls = [part for part in parts_of(tree) if isinstance(part, Call)]
    return sorted(calls, key=lambda call: (call.location.file, call.location.line, call.location.column))


def _is_missing(call: Call) -> bool:
    return call.name not in ACTIONS and call.name not in FUNCTIONS


def missing(call: Call) -> str:
    """What an action or function is that is not here, and what to write instead, with the place of its call."""
    return f"{call.location}: {unknown_action(call.name, {*ACTIONS, *FUNCTIONS} - {VALUE_BY_RULE})}"


def see_that_it_is_here(call: Call) -> None:
    """See that there is an internal action or function of this name.

    Raises:
        BdiError: there is none.
    """
    if _is_missing(call):
        raise BdiError(missing(call))


def check_call(call: Call) -> None:
    """See that an internal action or function exists, here or elsewhere, and gets as many arguments as it takes.

    Raises:
        BdiError: it does not.
    """
    if _is_missing(call):
        if is_foreign(call.name):
            return
        raise BdiError(missing(call))
    action = ACTIONS.get(call.name)
    limits = (action.least, action.most) if action is not None else FUNCTIONS[call.name]
    if action is not None and call.name in FUNCTIONS:
        limits = (min(action.least, FUNCTIONS[call.name][0]), action.most)
    least, most = limits
    if not least <= len(call.args) <= most:
        raise _wrong_number(call, least, most)


def _wrong_number(call: Call, least: int, most: int) -> BdiError:
    takes = str(least) if least == most else f"at least {least}" if most == MANY else f"{least} to {most}"
    plural = "" if takes == "1" else "s"
    return BdiError(f"{call.location}: {call.name} takes {takes} argument{plural}, found {len(call.args)}: {call}")
