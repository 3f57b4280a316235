"""An agent's plan library: plans found by the event they are for, in source order."""

from __future__ import annotations

from pytest_hricdv.bdi.language.syntax import SIGNS, EventKey, Plan
from pytest_hricdv.bdi.language.terms import Key

from .selection import Option, option_of
from .spinning import is_steady

KQML_RECEIVED = (False, "kqml_received", 4)
"""The goals that messages are that are not acted on at once."""


class Options(dict[Key, tuple[Option, ...]]):
    """The relevant plans of the events of a sign, made ready when there is such an event for the first time."""

    __slots__ = ("_library", "_sign")

    def __init__(self, library: PlanLibrary, sign: str) -> None:
        super().__init__()
        self._library = library
        self._sign = sign

    def __missing__(self, key: Key) -> tuple[Option, ...]:
        options = self[key] = tuple([option_of(plan) for plan in self._library.relevant(self._sign, key)])
        return options


class PlanLibrary:
    """Plans by triggering event.

    Args:
        plans: the plans, in the order in which they are tried.
    """

    __slots__ = ("_by_event", "_by_sign", "_steady", "has_own_message_plans", "options", "plans", "private")

    def __init__(self, plans: tuple[Plan, ...]) -> None:
        self.plans = plans
        self._by_event: dict[EventKey, tuple[Plan, ...]] = {}
        self._by_sign: dict[str, tuple[Plan, ...]] = {}
        """Plans for any event of a sign: their trigger is a variable."""
        self.options = {sign: Options(self, sign) for sign in SIGNS}
        """:meth:`relevant` plans, ready to be selected, by sign and key."""
        self._steady: dict[Key, bool] = {}
        self.private = False
        """Whether nothing in the agent's system looks at what intentions consist of."""
        for plan in plans:
            if plan.trigger.key is None:
                self._by_sign[plan.trigger.sign] = (*self._by_sign.get(plan.trigger.sign, ()), plan)
        for key in {plan.trigger.key for plan in plans} - {None}:
            if key is not None:
                sign = key[0]
                self._by_event[key] = tuple(
                    plan
                    for plan in plans
                    if plan.trigger.key == key or (plan.trigger.key is None and plan.trigger.sign == sign)
                )
        message_plans = self.relevant("+!", KQML_RECEIVED)
        self.has_own_message_plans = any(not plan.builtin for plan in message_plans)

    def relevant(self, sign: str, key: Key) -> tuple[Plan, ...]:
        """The plans that may be for an event, in the order in which they are tried."""
        plans = self._by_event.get((sign, key))
        return plans if plans is not None else self._by_sign.get(sign, ())

    def is_steady(self, goal: Key) -> bool:
        """Whether it depends on beliefs alone which plan is selected for a goal, and to select one does nothing."""
        if goal not in self._steady:
            self._steady[goal] = is_steady(self.relevant("+!", goal))
        return self._steady[goal]

    def forgets(self, plan: Plan) -> bool:
        """Whether a plan need not be remembered once it has nothing left to do but to wait for a goal.

        It only matters then to a plan for the failure of its own goal, and to actions that look at intentions.
        """
        key = plan.trigger.key
        return self.private and key is not None and not self.relevant(f"-{key[0][1:]}", key[1])

    def with_plan(self, plan: Plan, at_the_beginning: bool = False) -> PlanLibrary:
        """A library with one plan more, tried last unless asked otherwise."""
        return PlanLibrary((plan, *self.plans) if at_the_beginning else (*self.plans, plan))

    def without(self, label: str) -> PlanLibrary:
        """A library without the plan of that label."""
        return PlanLibrary(tuple(plan for plan in self.plans if plan.label != label))
