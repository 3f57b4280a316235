"""`PlanLibrary`: an agent's plans by triggering event; `Agent` selects one for an event in each reasoning cycle.

`MultiAgentSystem` makes a library for each program; ``.add_plan`` and ``.remove_plan`` give the agent a changed one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from operator import itemgetter

from pytest_hricdv.bdi.language.errors import EvaluationError
from pytest_hricdv.bdi.language.namespaces import DEFAULT, LOCAL, split
from pytest_hricdv.bdi.language.syntax import (
    GOAL_STATE,
    SIGNS,
    And,
    Comparison,
    EventKey,
    Formula,
    Not,
    Or,
    Plan,
    PlanTrigger,
)
from pytest_hricdv.bdi.language.terms import (
    SOURCE_SELF,
    Key,
    QualifiedLiteral,
    Structure,
    Term,
    Variable,
    is_evaluable,
    is_ground,
)
from pytest_hricdv.bdi.logic.conditions import Condition, condition_of
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import unify

KQML_RECEIVED = (False, "kqml_received", 4)
"""The goal ``+!kqml_received``, which handles messages that are not processed without a plan (see `messages`)."""

Match = Callable[[Structure], Bindings | None]
"""The bindings of a trigger's variables by the literal of an event; None if the trigger does not match."""
Option = tuple[Plan, Match | None, Condition | None]
"""A relevant plan; how its trigger is matched, unless it matches every event with its key; and its context, if any."""


class PlanLibrary:
    """Plans by triggering event.

    Args:
        plans: in the order in which they are tried.
        private: whether no agent of the system inspects intentions, so that finished plans need not be remembered.
    """

    def __init__(self, plans: tuple[Plan, ...], private: bool = False) -> None:
        self.plans = plans
        self.private = private
        self._by_event: dict[EventKey, tuple[Plan, ...]] = {}
        self.options = {sign: PlanOptions(self, sign) for sign in SIGNS}
        """The :meth:`relevant` plans by sign and predicate, prepared for selection."""
        self._with_key: dict[EventKey, list[tuple[int, Plan]]] = {}
        self._with_any: dict[str, list[tuple[int, Plan]]] = {sign: [] for sign in SIGNS}
        for place in enumerate(plans):
            key = place[1].trigger.key
            (self._with_key.setdefault(key, []) if key else self._with_any[place[1].trigger.sign]).append(place)
        self.follows_goals = any(plan.trigger.sign == GOAL_STATE for plan in plans)
        """Whether a plan is for the states of goals."""
        self._steady: dict[Key, bool] = {}
        message_plans = self.relevant("+!", KQML_RECEIVED)
        self.has_own_message_plans = any(plan.trigger.key and not plan.builtin for plan in message_plans)

    def relevant(self, sign: str, key: Key) -> tuple[Plan, ...]:
        """The plans whose trigger has this sign and predicate, or is a variable, in source order."""
        event = (sign, key)
        plans = self._by_event.get(event)
        if plans is None:
            any_key = [place for place in self._with_any[sign] if _may_match(place[1].trigger, event)]
            places = sorted([*self._with_key.get(event, ()), *any_key], key=itemgetter(0))
            plans = self._by_event[event] = tuple(plan for _, plan in places)
        return plans

    def depends_on_beliefs_only(self, goal: Key) -> bool:
        """Whether the choice of a plan for a goal depends on beliefs only, and has no side effect.

        It could depend on the source of the event, too, and evaluating a context could draw a random number or warn.
        """
        if goal not in self._steady:
            self._steady[goal] = all(map(_depends_on_beliefs, self.relevant("+!", goal)))
        return self._steady[goal]

    def forgets(self, plan: Plan) -> bool:
        """Whether a plan that only waits for its last goal no longer makes a difference.

        It would to a plan for the failure of its own goal, and to actions that inspect intentions.
        """
        key = plan.trigger.key
        return self.private and key is not None and not self.relevant(f"-{key[0][1:]}", key[1])

    def with_plan(self, plan: Plan, origin: Structure, at_the_beginning: bool = False) -> PlanLibrary:
        """A library with one more plan, tried last unless requested otherwise; a known plan gets one more source."""
        for index, own in enumerate(self.plans):
            if (own.trigger, own.context, own.body) == (plan.trigger, plan.context, plan.body):
                if origin in _with_source(own):
                    return self
                own = replace(own, annots=_in_order((*_with_source(own), origin)))
                return PlanLibrary((*self.plans[:index], own, *self.plans[index + 1 :]), self.private)
            if own.label == plan.label:
                label = Structure(own.label).with_annotations(_with_source(own))
                raise EvaluationError(f"There already is a plan with label {label}", "internal_action")
        own_annots = tuple(annot for annot in plan.annots if annot not in _sources(plan))
        plan = replace(plan, annots=_in_order((*own_annots, origin)))
        return PlanLibrary((plan, *self.plans) if at_the_beginning else (*self.plans, plan), self.private)

    def without(self, label: str, origin: Structure) -> PlanLibrary:
        """A library in which the plan of that label has one source less, or is not, if that was its only one."""
        plans = []
        for plan in self.plans:
            if plan.label != label or origin not in _with_source(plan):
                plans.append(plan)
            elif len(_sources(plan)) > 1:
                plans.append(replace(plan, annots=tuple(annot for annot in plan.annots if annot != origin)))
        return PlanLibrary(tuple(plans), self.private)


def _in_order(annots: tuple[Term, ...]) -> tuple[Term, ...]:
    return Structure("annotated").with_annotations(annots).annots


def _sources(plan: Plan) -> list[Term]:
    return [annot for annot in plan.annots if isinstance(annot, Structure) and annot.key == SOURCE_SELF.key]


def _with_source(plan: Plan) -> tuple[Term, ...]:
    """The annotations of a plan; plans of the agent's own program are from itself without one."""
    return plan.annots if _sources(plan) else (*plan.annots, SOURCE_SELF)


class PlanOptions(dict[Key, tuple[Option, ...]]):
    """The relevant plans for the events of a sign by predicate, prepared when there is the first such event.

    Args:
        sign: the sign of the events.
    """

    def __init__(self, library: PlanLibrary, sign: str) -> None:
        super().__init__()
        self._library = library
        self._sign = sign

    def __missing__(self, key: Key) -> tuple[Option, ...]:
        options = self[key] = tuple([_option(plan) for plan in self._library.relevant(self._sign, key)])
        return options


def _may_match(trigger: PlanTrigger, event: EventKey) -> bool:
    """Whether a trigger without a key may match these events; a bare variable stands for those without a namespace."""
    literal, (_, functor, arity) = trigger.literal, event[1]
    space, name = split(functor)
    if not isinstance(literal, QualifiedLiteral):
        return space == DEFAULT
    if literal.space != Structure(space) and (isinstance(literal.space, Structure) or space.startswith(LOCAL)):
        return False
    inner = literal.literal
    return not isinstance(inner, Structure) or inner.key == (event[1][0], name, arity)


def _option(plan: Plan) -> Option:
    match = None if plan.matches_every_event else _match(plan.trigger)
    return plan, match, None if plan.context is None else condition_of(plan.context)


def _match(trigger: PlanTrigger) -> Match:
    wanted = trigger.literal

    # Which way to match is decided once, when the plan is first relevant, not for each event.
    def match(literal: Structure) -> Bindings | None:
        bindings: Bindings = {}
        return bindings if unify(wanted, literal, bindings, []) else None

    if not isinstance(wanted, Structure) or wanted.annots_tail is not None or not all(map(is_ground, wanted.annots)):
        return match
    names, annots = wanted.args, wanted.annots
    if not all(isinstance(arg, Variable) for arg in names) or len({*names}) < len(names):
        return match

    def match_names(literal: Structure) -> Bindings | None:
        """Like ``match``, for a trigger that only names the arguments of the event, as most do."""
        if not literal.ground:
            return match(literal)
        for annot in annots:
            if annot not in literal.annots:
                return match(literal)
        # Both have the same key: ``strict`` would only take time.
        return dict(zip(names, literal.args)) if names else {}  # type: ignore[arg-type]  # noqa: B905

    return match_names


def _depends_on_beliefs(plan: Plan) -> bool:
    goal = plan.trigger.literal
    if not isinstance(goal, Structure) or goal.annots or goal.annots_tail is not None:
        return False
    return plan.context is None or _has_no_effect(plan.context)


def _has_no_effect(formula: Formula) -> bool:
    if isinstance(formula, (And, Or)):
        return all(map(_has_no_effect, formula.parts))
    if isinstance(formula, Not):
        return _has_no_effect(formula.part)
    if isinstance(formula, Comparison):
        return not is_evaluable(formula.left) and not is_evaluable(formula.right)
    return isinstance(formula, Structure) and not formula.evaluable
