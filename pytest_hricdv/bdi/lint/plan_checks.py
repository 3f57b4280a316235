"""Lint's checks of plans, which `lint` runs: plans never selected, without end, or for failures that cannot occur."""

from __future__ import annotations

from collections.abc import Iterator
from operator import itemgetter

from pytest_hricdv.bdi.language import syntax
from pytest_hricdv.bdi.language.syntax_tree import children, parts_of, variables_of
from pytest_hricdv.bdi.language.terms import Arithmetic, Call, Key, Structure, Term, Variable
from pytest_hricdv.bdi.lint.model import AgentModel, Problem, System, check
from pytest_hricdv.bdi.logic.substitution import Bindings, rename_apart, substitute_only
from pytest_hricdv.bdi.logic.unify import unify

NONDETERMINISTIC = frozenset({".random", "math.random", ".time", "system.time"})
"""Functions and internal actions with a different result each time."""
GOAL_ENDING = frozenset(
    {
        ".drop_all_desires",
        ".drop_all_events",
        ".drop_all_intentions",
        ".drop_desire",
        ".drop_event",
        ".drop_intention",
        ".fail_goal",
        ".stopMAS",
        ".succeed_goal",
        ".suspend",
    }
)
"""Internal actions that may end a goal of another plan."""
VARYING = frozenset({".random", ".time", ".desire", ".intend", ".abolish"})
"""Internal actions in conditions whose result may change."""
_CONDITIONS = (syntax.And, syntax.Or, syntax.Not, syntax.Comparison, Call)


@check("shadowed-plan", "The first applicable plan is selected: this one never runs and can never be covered.")
def find_shadowed_plans(system: System) -> Iterator[Problem]:
    """Plans after one for the same event that is applicable whenever they are."""
    for agent in system.agents:
        for plan, before in _with_earlier(agent.plans):
            shadowing = next((earlier for earlier in before if shadows(earlier, plan)), None)
            if shadowing is not None:
                which = f"@{shadowing.label}" if shadowing.has_label else "the plan"
                yield (
                    plan.location,
                    f"{which} in line {shadowing.location.line} is always applicable when this one is",
                )


def _with_earlier(plans: tuple[syntax.Plan, ...]) -> Iterator[tuple[syntax.Plan, list[syntax.Plan]]]:
    """Each plan with those before it that may be for the same event."""
    seen: dict[syntax.EventKey | None, list[tuple[int, syntax.Plan]]] = {}
    for number, plan in enumerate(plans):
        same, others = seen.setdefault(plan.trigger.key, []), seen.get(None, [])
        yield plan, [other for _, other in (same if same is others else sorted(same + others, key=itemgetter(0)))]
        same.append((number, plan))


def shadows(earlier: syntax.Plan, later: syntax.Plan) -> bool:
    """Whether a plan is applicable for every event and in every state that a later one is."""
    if earlier.trigger.sign != later.trigger.sign:
        return False
    bindings: Bindings = {}
    if not unify(rename_apart(earlier.trigger.literal, "_Earlier"), _frozen(later.trigger.literal), bindings, []):
        return False
    return earlier.context is None or _follows(_parts(earlier.context), _parts(later.context), bindings)


def _parts(context: syntax.Formula | None) -> tuple[syntax.Formula, ...]:
    if context is None:
        return ()
    parts = context.parts if isinstance(context, syntax.And) else (context,)
    return tuple(part for part in parts if part != Structure("true"))


def _follows(wanted: tuple[syntax.Formula, ...], available: tuple[syntax.Formula, ...], bindings: Bindings) -> bool:
    """Whether each of the wanted conditions is among the available ones, with consistent bindings."""
    if not wanted:
        return True
    for part in available:
        trial = dict(bindings)
        if _same(wanted[0], part, trial) and _follows(wanted[1:], available, trial):
            return True
    return False


def _same(wanted: object, candidate: object, bindings: Bindings) -> bool:
    """Whether a condition is equal to a candidate under some bindings of the wanted one's variables."""
    if isinstance(wanted, syntax.Comparison) and isinstance(candidate, syntax.Comparison):
        sides = ((wanted.left, candidate.left), (wanted.right, candidate.right))
        return wanted.operator == candidate.operator and all(_same(left, right, bindings) for left, right in sides)
    if isinstance(wanted, syntax.Not) and isinstance(candidate, syntax.Not):
        return _same(wanted.part, candidate.part, bindings)
    if isinstance(wanted, (syntax.And, syntax.Or)) and isinstance(candidate, type(wanted)):
        return len(wanted.parts) == len(candidate.parts) and all(
            _same(left, right, bindings) for left, right in zip(wanted.parts, candidate.parts, strict=True)
        )
    if isinstance(wanted, Call) and isinstance(candidate, Call):
        return (
            wanted.name == candidate.name
            and wanted.name not in NONDETERMINISTIC
            and len(wanted.args) == len(candidate.args)
            and all(_same(left, right, bindings) for left, right in zip(wanted.args, candidate.args, strict=True))
        )
    if isinstance(wanted, _CONDITIONS) or isinstance(candidate, _CONDITIONS):
        return False
    return unify(rename_apart(wanted, "_Earlier"), _frozen(candidate), bindings, [])  # type: ignore[arg-type]


def _frozen(term: Term) -> Term:
    """The term with its variables as constants, so that only the other side is bound."""
    return substitute_only(term, {variable: Structure(f"${variable}") for variable in variables_of(term)})


@check(
    "endless-spin",
    "Once started it never ends: the goal is never achieved, and only the detection of livelocks ends the run.",
)
def find_endless_spins(system: System) -> Iterator[Problem]:
    """Plans and loops that only poll a condition that never changes."""
    for agent in system.agents:
        if agent.actions & GOAL_ENDING or _receives_unachieve(system, agent):
            continue
        changing = _Changes(system, agent)
        for index, plan in enumerate(agent.plans):
            if _only_pursues_itself(plan) and not changing.may_end(agent.plans[:index], plan):
                yield plan.location, f"nothing can end the pursuit of {plan.trigger}"
            for loop in _loops(plan.body):
                if all(map(_only_waits, loop.body)) and not changing.may_change(loop.condition):
                    yield loop.location, f"nothing can end the loop while ({loop.condition})"


def _receives_unachieve(system: System, agent: AgentModel) -> bool:
    return any(message.force == "unachieve" for sender in system.agents for message in sender.sent)


def _only_pursues_itself(plan: syntax.Plan) -> bool:
    """Whether a plan for a goal only pursues the goal again, perhaps after a wait."""
    if plan.trigger.sign != "+!" or not plan.body:
        return False
    *before, last = plan.body
    return (
        isinstance(last, syntax.AchievementGoal)
        and last.literal == plan.trigger.literal
        and all(map(_only_waits, before))
    )


def _only_waits(statement: syntax.Statement) -> bool:
    return isinstance(statement, syntax.InternalActionCall) and statement.call.name == ".wait"


def _loops(body: syntax.Body) -> Iterator[syntax.While]:
    for statement in body:
        if isinstance(statement, syntax.While):
            yield statement
        for block in ("then", "otherwise", "body"):
            yield from _loops(getattr(statement, block, ()))


class _Changes:
    """Decides which conditions of an agent may change during a run."""

    def __init__(self, system: System, agent: AgentModel) -> None:
        self._agent = agent
        self._added = [addition for addition in system.possible_beliefs(agent) if addition.during_run]
        self._deleted = {mention.literal.key for mention in agent.deletions}
        self._deleted |= {
            message.content.key
            for sender in system.agents
            for message in sender.sent
            if message.force == "untell" and isinstance(message.content, Structure)
        }

    def may_end(self, earlier: tuple[syntax.Plan, ...], plan: syntax.Plan) -> bool:
        """Whether a plan may become inapplicable, or an earlier one applicable."""
        if plan.context is not None and self.may_change(plan.context):
            return True
        return any(
            other.context is not None and self.may_change(other.context)
            for other in earlier
            if other.trigger.sign == plan.trigger.sign and unify(other.trigger.literal, plan.trigger.literal, {}, [])
        )

    def may_change(self, formula: syntax.Formula) -> bool:
        """Whether the result of a condition may change."""
        return any(
            self._predicate_may_change(part.key, set())
            if isinstance(part, Structure)
            else isinstance(part, Call) and part.name in VARYING
            for part in _literals(formula)
        )

    def _predicate_may_change(self, key: Key, seen: set[Key]) -> bool:
        if key in seen:
            return False
        seen.add(key)
        if key in self._deleted or any(addition.may_match(key) for addition in self._added):
            return True
        return any(
            isinstance(part, Call) or self._predicate_may_change(part.key, seen)
            for rule in self._agent.rules
            if rule.head.key == key
            for part in _literals(rule.body)
        )


def _literals(formula: object) -> Iterator[Structure | Call]:
    """The literals and internal actions in a condition, including those in arguments."""
    pending: list[object] = [formula]
    while pending:
        part = pending.pop()
        if isinstance(part, (Structure, Call)):
            yield part
        if not isinstance(part, Structure):
            pending.extend(children(part))


@check("dead-timeout", "The plan never runs: nothing handles the time-out.")
def find_dead_timeouts(system: System) -> Iterator[Problem]:
    """Plans for a time-out that no statement of the agent can have."""
    for agent in system.agents:
        if system.may_receive_plans(agent) or ".fail" in agent.actions or ".fail_goal" in agent.actions:
            continue
        causes = _timeouts(agent)
        for plan in agent.plans:
            error = _error_of(plan)
            if plan.trigger.sign == "-!" and error in _TIMEOUTS and error not in causes:
                yield plan.location, f"nothing in {agent.name} fails with {error}: {_TIMEOUTS[error]}"


_TIMEOUTS = {
    "wait_timeout": "only .wait(event or condition, time) does, without a third argument",
    "deadline_reached": "only a goal with hard_deadline(time) does",
}


def _error_of(plan: syntax.Plan) -> str:
    """The error that a failure plan asks for by name, as in ``-!g[error(wait_timeout)]``."""
    for annot in getattr(plan.trigger.literal, "annots", ()):
        if isinstance(annot, Structure) and annot.functor == "error" and len(annot.args) == 1:
            return str(annot.args[0])
    return ""


def _timeouts(agent: AgentModel) -> set[str]:
    """The errors of time-outs that some statement of an agent may cause."""
    causes: set[str] = set()
    for part in parts_of((agent.plans, tuple(goal.literal for goal in agent.goals))):
        if isinstance(part, Call) and part.name == ".wait" and len(part.args) == 2:
            causes.add("wait_timeout")
        elif isinstance(part, Structure) and part.functor == "hard_deadline":
            causes.add("deadline_reached")
    return causes


@check(
    "dead-failure-plan",
    "The plan never runs: nothing handles a failure of the goal, or its deadline.",
)
def find_dead_failure_plans(system: System) -> Iterator[Problem]:
    """Plans for the failure of a goal that always has a plan to run, of statements that cannot fail."""
    for agent in system.agents:
        if system.may_receive_plans(agent) or agent.actions & {".fail", ".fail_goal"}:
            continue
        for_any_goal = any(plan.trigger.sign == "+!" and plan.trigger.key is None for plan in agent.plans)
        if for_any_goal or "deadline_reached" in _timeouts(agent):
            continue
        goals = _Goals(system, agent)
        for plan in agent.plans:
            goal = plan.trigger.literal
            if plan.trigger.sign != "-!" or not isinstance(goal, Structure) or _error_of(plan) in _TIMEOUTS:
                continue
            if not goals.may_fail(goal.key, frozenset()):
                yield plan.location, f"!{goal.without_annotations()} never fails: no statement of its plans can"


_NEVER_FAIL = frozenset({".print", ".println", ".log"})
_TELLING = frozenset({"tell", "untell", "achieve", "unachieve"})


class _Goals:
    """The goals of an agent that may fail; uncertain ones count as such."""

    def __init__(self, system: System, agent: AgentModel) -> None:
        self._agents = {other.name for other in system.agents}
        self._plans: dict[Key, list[syntax.Plan]] = {}
        for plan in agent.plans:
            if plan.trigger.sign == "+!" and isinstance(plan.trigger.literal, Structure):
                self._plans.setdefault(plan.trigger.literal.key, []).append(plan)

    def may_fail(self, goal: Key, outer: frozenset[Key]) -> bool:
        """Whether a goal may fail while these ones wait for it."""
        if goal in outer:  # one that pursues itself fails only where something else does
            return False
        plans = self._plans.get(goal, [])
        if not any(map(_is_always_applicable, plans)):
            return True
        return any(self._body_may_fail(plan.body, outer | {goal}) for plan in plans)

    def _body_may_fail(self, body: syntax.Body, outer: frozenset[Key]) -> bool:
        return any(self._statement_may_fail(statement, outer) for statement in body)

    def _statement_may_fail(self, statement: syntax.Statement, outer: frozenset[Key]) -> bool:
        if isinstance(statement, (syntax.If, syntax.While, syntax.For)):
            bodies = (statement.then, statement.otherwise) if isinstance(statement, syntax.If) else (statement.body,)
            return _computes(statement.condition) or any(self._body_may_fail(body, outer) for body in bodies)
        if _computes(statement):
            return True
        if isinstance(statement, syntax.BeliefUpdate):
            return not isinstance(statement.literal, Structure)
        if isinstance(statement, syntax.AchievementGoal):
            if not isinstance(statement.literal, Structure):
                return True
            return not statement.new_intention and self.may_fail(statement.literal.key, outer)
        return not isinstance(statement, syntax.InternalActionCall) or self._call_may_fail(statement.call)

    def _call_may_fail(self, call: Call) -> bool:
        if call.name in _NEVER_FAIL:
            return False
        if call.name == ".wait":
            return len(call.args) == 2 or isinstance(call.args[0], Variable)
        if call.name == ".send" and len(call.args) == 3:
            receiver, force, _ = call.args
            is_telling = isinstance(force, Structure) and force.functor in _TELLING
            return not (is_telling and isinstance(receiver, Structure) and receiver.functor in self._agents)
        return True


def _is_always_applicable(plan: syntax.Plan) -> bool:
    goal = plan.trigger.literal
    if not isinstance(goal, Structure) or goal.annots or plan.context not in (None, Structure("true")):
        return False
    return all(isinstance(arg, Variable) for arg in goal.args) and len({*goal.args}) == len(goal.args)


def _computes(part: object) -> bool:
    """Whether there is an expression in it, which has no value where an operand is not a number."""
    inner = part.call.args if isinstance(part, syntax.InternalActionCall) else part
    return any(isinstance(term, (Arithmetic, Call)) for term in parts_of(inner))
