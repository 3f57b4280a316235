"""A plan that is never chosen because an earlier one always is."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.formulas import And, Comparison, Formula, Not, Or
from pytest_hricdv.bdi.language.syntax import Plan, variables_of
from pytest_hricdv.bdi.language.terms import Call, Structure, Term, Variable
from pytest_hricdv.bdi.logic.substitution import Bindings, substitute_only
from pytest_hricdv.bdi.logic.unify import unify

from ..model import System

UNDECIDED = frozenset({".random", "math.random", ".time", "system.time"})
"""Functions and actions that do not give the same twice."""


class ShadowedPlan:
    """Plans behind one for the same event that is applicable whenever they are."""

    name = "shadowed-plan"
    why = "The first applicable plan is taken: this one never runs, and coverage of it can never be reached."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each plan, naming the first that hides it."""
        for agent in system.agents:
            for index, plan in enumerate(agent.plans):
                hiding = next((earlier for earlier in agent.plans[:index] if hides(earlier, plan)), None)
                if hiding is not None:
                    which = f"@{hiding.label}" if hiding.has_label else "the plan"
                    yield plan.location, f"{which} in line {hiding.location.line} is always applicable when this one is"


def hides(earlier: Plan, later: Plan) -> bool:
    """Whether a plan is applicable to every event and in every situation that a later one is."""
    if earlier.trigger.sign != later.trigger.sign:
        return False
    bindings: Bindings = {}
    if not unify(_apart(earlier.trigger.literal), _frozen(later.trigger.literal), bindings, []):
        return False
    return earlier.context is None or _follows(_parts(earlier.context), _parts(later.context), bindings)


def _parts(context: Formula | None) -> tuple[Formula, ...]:
    if context is None:
        return ()
    parts = context.parts if isinstance(context, And) else (context,)
    return tuple(part for part in parts if part != Structure("true"))


def _follows(wanted: tuple[Formula, ...], given: tuple[Formula, ...], bindings: Bindings) -> bool:
    """Whether each of the conditions wanted is one of those given, with the same values throughout."""
    if not wanted:
        return True
    for part in given:
        trial = dict(bindings)
        if _same(wanted[0], part, trial) and _follows(wanted[1:], given, trial):
            return True
    return False


def _same(wanted: object, given: object, bindings: Bindings) -> bool:
    """Whether a condition is an instance of the other, which is frozen on the way."""
    if isinstance(wanted, Comparison) and isinstance(given, Comparison):
        sides = ((wanted.left, given.left), (wanted.right, given.right))
        return wanted.operator == given.operator and all(_same(left, right, bindings) for left, right in sides)
    if isinstance(wanted, Not) and isinstance(given, Not):
        return _same(wanted.part, given.part, bindings)
    if isinstance(wanted, (And, Or)) and isinstance(given, type(wanted)):
        return len(wanted.parts) == len(given.parts) and all(
            _same(left, right, bindings) for left, right in zip(wanted.parts, given.parts, strict=True)
        )
    if isinstance(wanted, Call) and isinstance(given, Call):
        return (
            wanted.name == given.name
            and wanted.name not in UNDECIDED
            and len(wanted.args) == len(given.args)
            and all(_same(left, right, bindings) for left, right in zip(wanted.args, given.args, strict=True))
        )
    if isinstance(wanted, (And, Or, Not, Comparison, Call)) or isinstance(given, (And, Or, Not, Comparison, Call)):
        return False
    return unify(_apart(wanted), _frozen(given), bindings, [])  # type: ignore[arg-type]


def _apart(term: Term) -> Term:
    """The term with variables that the later plan has not."""
    return substitute_only(term, {variable: Variable(f"_Earlier{variable}") for variable in variables_of(term)})


def _frozen(term: Term) -> Term:
    """The term with its variables as constants, so that only the other side is fitted."""
    return substitute_only(term, {variable: Structure(f"${variable}") for variable in variables_of(term)})
