"""The check for plans that are never selected because an earlier one always is."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax import And, Comparison, Formula, Not, Or, Plan
from pytest_hricdv.bdi.language.syntax_tree import variables_of
from pytest_hricdv.bdi.language.terms import Call, Structure, Term, Variable
from pytest_hricdv.bdi.lint.model import System
from pytest_hricdv.bdi.logic.substitution import Bindings, substitute_only
from pytest_hricdv.bdi.logic.unify import unify

NONDETERMINISTIC = frozenset({".random", "math.random", ".time", "system.time"})
"""Functions and internal actions with a different result each time."""


class ShadowedPlan:
    """Plans after one for the same event that is applicable whenever they are."""

    name = "shadowed-plan"
    why = "The first applicable plan is selected: this one never runs and can never be covered."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each plan, naming the first plan that shadows it."""
        for agent in system.agents:
            for index, plan in enumerate(agent.plans):
                shadowing = next((earlier for earlier in agent.plans[:index] if shadows(earlier, plan)), None)
                if shadowing is not None:
                    which = f"@{shadowing.label}" if shadowing.has_label else "the plan"
                    yield (
                        plan.location,
                        f"{which} in line {shadowing.location.line} is always applicable when this one is",
                    )


def shadows(earlier: Plan, later: Plan) -> bool:
    """Whether a plan is applicable for every event and in every state that a later one is."""
    if earlier.trigger.sign != later.trigger.sign:
        return False
    bindings: Bindings = {}
    if not unify(_standardized_apart(earlier.trigger.literal), _frozen(later.trigger.literal), bindings, []):
        return False
    return earlier.context is None or _follows(_parts(earlier.context), _parts(later.context), bindings)


def _parts(context: Formula | None) -> tuple[Formula, ...]:
    if context is None:
        return ()
    parts = context.parts if isinstance(context, And) else (context,)
    return tuple(part for part in parts if part != Structure("true"))


def _follows(wanted: tuple[Formula, ...], given: tuple[Formula, ...], bindings: Bindings) -> bool:
    """Whether each of the wanted conditions is among the given ones, with consistent bindings."""
    if not wanted:
        return True
    for part in given:
        trial = dict(bindings)
        if _same(wanted[0], part, trial) and _follows(wanted[1:], given, trial):
            return True
    return False


def _same(wanted: object, given: object, bindings: Bindings) -> bool:
    """Whether a condition is equal to the given one under some bindings of the wanted one's variables."""
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
            and wanted.name not in NONDETERMINISTIC
            and len(wanted.args) == len(given.args)
            and all(_same(left, right, bindings) for left, right in zip(wanted.args, given.args, strict=True))
        )
    if isinstance(wanted, (And, Or, Not, Comparison, Call)) or isinstance(given, (And, Or, Not, Comparison, Call)):
        return False
    return unify(_standardized_apart(wanted), _frozen(given), bindings, [])  # type: ignore[arg-type]


def _standardized_apart(term: Term) -> Term:
    """The term with renamed variables, which the later plan does not have."""
    return substitute_only(term, {variable: Variable(f"_Earlier{variable}") for variable in variables_of(term)})


def _frozen(term: Term) -> Term:
    """The term with its variables as constants, so that only the other side is bound."""
    return substitute_only(term, {variable: Structure(f"${variable}") for variable in variables_of(term)})
