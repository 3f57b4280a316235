"""The registry of internal actions: `internal_action` defines one, `call_action` finds and calls it for an agent.

The modules beside this one define the actions, each a function of an `Invocation`. When a program is loaded,
`check_calls` refuses calls of actions that do not exist or take another number of arguments.
"""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any, TypeVar

from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import Intention, Outcome
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
Expected = TypeVar("Expected")
WRONG = "wrong_arguments"
"""The kind of failure of an action with unsuitable arguments."""
INTERNAL = "internal_action"
"""The kind of failure of an action that raises an error of its own."""
MANY = 1_000
"""The greatest number of arguments of an action that takes any number: more than any call has."""


class Invocation:
    """One call of an internal action; unifying its arguments adds to `bindings` and to the `trail` for backtracking.

    `intention` is the intention that executes the call as a statement; None for a call in a context, a rule or a test.
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
        """Set by an action that moves its own intention elsewhere than to the next statement."""
        self.failure: tuple[Term, ...] = ()
        """Annotations for the failure event."""

    def value(self, index: int) -> Term:
        """An argument with its variables replaced and its expressions evaluated."""
        term: Term = self.args[index]
        # Most arguments are written out: they need no call.
        return term if type(term) is Structure and term.ground else self.agent.value(term, self.bindings)

    def argument(self, index: int, expected: type[Expected], noun: str, kind: str = WRONG) -> Expected:
        """The value of an argument of a given class; raises EvaluationError (a failure of this `kind`) for others."""
        value = self.value(index)
        if not isinstance(value, expected):
            raise EvaluationError(f"{self.call}: argument {index + 1} is not {noun} but {value}", kind)
        return value

    def number(self, index: int) -> float:
        """An argument that has to be a number."""
        return float(self.argument(index, Number, "a number"))

    def items(self, index: int) -> tuple[Term, ...]:
        """The items of an argument that has to be a list."""
        return self.argument(index, ListTerm, "a list").items

    def literal(self, index: int) -> Structure:
        """An argument that has to be a literal."""
        return self.argument(index, Structure, "a literal")

    def ignore(self) -> bool:
        """Warn that this call has no effect here."""
        self.agent.run.warn(f"{self.agent.name}: {self.call.location}: ignored: {self.call}")
        return True

    def text(self, index: int) -> str:
        """An argument as text, a string without its quotes."""
        value = self.value(index)
        return value.value if isinstance(value, String) else str(value)

    def read(self, text: str, parse: Callable[[str], Parsed], kind: str = WRONG) -> Parsed:
        """Parse a text; raises EvaluationError (a failure of this `kind`) if it cannot be parsed."""
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
        """The intention the call is a statement of; raises BdiError if it is part of a condition."""
        if self.intention is None:
            raise BdiError(f"{self.call.location}: {self.call.name} cannot be part of a condition")
        return self.intention


Body = Callable[[Invocation], Outcome]


@dataclass(frozen=True, slots=True)
class InternalAction:
    """A standard internal action: its name with the dot, its numbers of arguments, whether it inspects or changes
    intentions or plans, and what it does."""

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
    """Define the action ``.name``, which takes ``least`` to ``most`` arguments (see `InternalAction`).

    Decorators may be stacked: an action may have several names.
    """

    def define(body: Body) -> Body:
        ACTIONS[f".{name}"] = InternalAction(f".{name}", least, least if most is None else most, inspects, body)
        return body

    return define


def call_action(invocation: Invocation) -> Outcome:
    """Call an internal action, whose name and number of arguments have been checked when the program was loaded.

    Raises:
        BdiError: the action is unknown here, as those of Java are: the run cannot continue.
    """
    action = ACTIONS.get(invocation.call.name)
    if action is None:
        check_exists(invocation.call)
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


def check_calls(tree: object) -> None:
    """Check that all internal actions and functions in a program, or in a part, exist and get as many arguments as they
    take; raises BdiError for the first that does not, with its location and the nearest names known.

    Those that exist elsewhere, in Java or in Jason, are not errors until they are called: see :func:`foreign_calls`.
    """
    for call in _calls_of(tree):
        check_call(call)


def foreign_calls(tree: object) -> list[Call]:
    """The calls in a part of a program that end a run, because what they call is in Java, or in Jason, and not here."""
    return [call for call in _calls_of(tree) if _is_missing(call) and _is_foreign(call.name)]


def _calls_of(tree: object) -> list[Call]:
    """The calls in a part of a program, in the order of the source."""
    calls = [part for part in parts_of(tree) if isinstance(part, Call)]
    return sorted(calls, key=lambda call: (call.location.file, call.location.line, call.location.column))


def _is_missing(call: Call) -> bool:
    return call.name not in ACTIONS and call.name not in FUNCTIONS


def describe_missing(call: Call) -> str:
    """Describe a missing action or function: what it is, what to write instead, and the place of its call."""
    return f"{call.location}: {_unknown_action(call.name, {*ACTIONS, *FUNCTIONS} - {VALUE_BY_RULE})}"


def check_exists(call: Call) -> None:
    """Raise BdiError unless there is an internal action or function of this name."""
    if _is_missing(call):
        raise BdiError(describe_missing(call))


def check_call(call: Call) -> None:
    """Raise BdiError unless the action or function exists, here or elsewhere, and takes as many arguments."""
    if _is_missing(call):
        if _is_foreign(call.name):
            return
        raise BdiError(describe_missing(call))
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


# --- what to write instead of an action that does not exist

_NAMESPACES = "what is to be known of a namespace is a belief in it, as ns::kind(local)"

_INSTEAD = {
    ".assert": "beliefs are added with +b",
    ".retract": "beliefs are deleted with -b, all of a kind with .abolish",
    ".copy": "terms do not change: use the variable; with new variables, .copy_term",
    ".foreach": "use for (condition) { ... }, or .foreach(condition, { ... })",
    ".forall": "use for (condition) { ... }",
    ".if_then_else": "use if (condition) { ... } else { ... }, or .if_then_else(condition, { ... }, { ... })",
    ".if": "use if (condition) { ... } else { ... }",
    ".while": "use while (condition) { ... }",
    ".for": "use for (condition) { ... }",
    ".loop": "use while (condition) { ... }, or .loop(condition, { ... })",
    ".include": 'use the directive { include("file.asl") }',
    ".get_src_info": "failure plans receive the source location as annotations: -!g[code_src(File), code_line(Line)]",
    ".join": "it is part of .fork: write .fork(and, { ... }, { ... }), or !a |&| !b",
    ".list_files": "runs read no folders: list the choices as beliefs",
    ".namespace_get_prop": _NAMESPACES,
    ".namespace_set_prop": _NAMESPACES,
    ".println_error": "use .print",
    ".sleep": "use .wait(milliseconds)",
    ".stop": "use .stopMAS",
    ".exit": "use .stopMAS",
    ".append": "lists and strings are joined with .concat",
    ".size": "use .length",
    ".setof_count": "use .count",
    ".not": "negation is written not condition",
    ".to_string": "use .term2string",
    ".get_time": "use .time(H, M, S) or system.time",
    ".average": "use math.average",
    "math.power": "powers are written X ** Y",
    "math.pow": "powers are written X ** Y",
    "math.mod": "the remainder is written X mod Y",
}
"""Missing name -> its replacement."""

_OWN_PACKAGES = ("math.", "system.")
"""Functions here, under the names that Jason gives them; everything else with a name before the dot is a Java class."""

_NAMES_OF_JASON = "fork get_src_info include join list_files namespace_get_prop namespace_set_prop"
_OF_JASON = {f".{name}" for name in _NAMES_OF_JASON.split()}
"""Actions of Jason 1.4.2 or 3.3: calling one is not a typo."""


def _is_foreign(name: str) -> bool:
    """Whether an unknown action or function exists in Java, or in Jason itself: other names are slips."""
    return not name.startswith((".", *_OWN_PACKAGES)) or name in _OF_JASON


def _unknown_action(name: str, names: Iterable[str]) -> str:
    """The message for an internal action or function that does not exist: what it is, and what to write instead."""
    if name in _INSTEAD:
        return f"unknown internal action {name}; {_INSTEAD[name]}"
    if not name.startswith((".", *_OWN_PACKAGES)):
        action = name.replace(".", "_")
        return (
            f"{name} is an internal action in Java, and Java is not supported; write a rule, or an external action "
            f"{action}(...) of a Python environment, which answers with a percept"
        )
    ordered = sorted(names)
    # Below difflib's own cutoff of 0.6: for a name that is wrong for certain, a far guess beats the whole list.
    near = difflib.get_close_matches(name, ordered, n=3, cutoff=0.5)
    hint = f"did you mean {' or '.join(near)}?" if near else f"known are {', '.join(ordered)}"
    return f"unknown internal action {name}; {hint}"
