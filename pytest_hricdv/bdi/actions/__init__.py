"""Internal actions such as ``.send``, and functions such as ``math.abs``, which plans call by name.

Every agent executes them through `StandardActions`. When a program is loaded, `MultiAgentSystem` and lint refuse
unknown actions with `check_calls`; `foreign_calls` lists actions that only Jason has, or that are written in Java.
"""

from __future__ import annotations

# Each of these modules defines its actions in the registry.
from pytest_hricdv.bdi.actions import collections, goals, knowledge, lists, messages, terms, time  # noqa: F401
from pytest_hricdv.bdi.actions.functions import function_value
from pytest_hricdv.bdi.actions.registry import (
    Invocation,
    call_action,
    check_calls,
    describe_missing,
    foreign_calls,
    inspects_intentions,
)
from pytest_hricdv.bdi.agent.agent_state import AgentState
from pytest_hricdv.bdi.agent.intentions import ActionResult, Intention, Outcome
from pytest_hricdv.bdi.language.terms import Call, Term
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail

__all__ = ["StandardActions", "check_calls", "describe_missing", "foreign_calls", "inspects_intentions"]


class StandardActions:
    """An `ActionTable` of the internal actions and functions of Jason's standard library."""

    def execute(self, agent: AgentState, call: Call, bindings: Bindings, intention: Intention) -> ActionResult:
        """Execute an internal action as a statement; its first solution counts."""
        invocation = Invocation(agent, call, bindings, [], intention)
        outcome = call_action(invocation)
        if not isinstance(outcome, bool):
            outcome = next(iter(outcome), None) is not None
        return outcome, invocation.held, invocation.failure

    def solve(self, agent: AgentState, call: Call, bindings: Bindings, trail: Trail) -> Outcome:
        """Evaluate an internal action as a condition."""
        return call_action(Invocation(agent, call, bindings, trail, None))

    def function(self, agent: AgentState, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""
        return function_value(agent, call, bindings)
