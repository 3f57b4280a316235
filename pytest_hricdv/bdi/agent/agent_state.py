"""`AgentState`: the mental state of an agent, and the basic changes of it.

`Agent` adds the reasoning cycle; the modules that execute statements and internal actions need only the state.
"""

from __future__ import annotations

from collections import deque

from pytest_hricdv.bdi.agent.intentions import (
    ActionTable,
    Event,
    ForkedIntention,
    HardDeadline,
    IntendedMeans,
    Intention,
    Outcome,
    PendingQuestion,
    PendingWait,
    RunServices,
    SpeechAct,
)
from pytest_hricdv.bdi.agent.plan_library import PlanLibrary
from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.syntax import GOAL_STATE, Formula, Plan, Rule, with_state
from pytest_hricdv.bdi.language.terms import Call, Structure, Term, Variable
from pytest_hricdv.bdi.logic.beliefs import BeliefBase
from pytest_hricdv.bdi.logic.inference import MAX_NESTED_QUERIES
from pytest_hricdv.bdi.logic.substitution import Bindings, free_variables, substitute, substitute_only
from pytest_hricdv.bdi.logic.unify import Trail


class AgentState:
    """The beliefs and intentions of an agent, and the events that it has yet to react to.

    Args:
        beliefs: the initial beliefs; the agent changes this base.
        events: the sign and literal of each initial event.
    """

    def __init__(
        self,
        name: str,
        run: RunServices,
        actions: ActionTable,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        self.name = name
        self.run = run
        self.actions = actions
        self.beliefs = beliefs
        self.library = library
        self.mailbox: deque[SpeechAct] = deque()
        self.events: deque[Event] = deque((sign, literal, None) for sign, literal in events)
        self.feedback: deque[tuple[Intention, bool]] = deque()
        """Intentions whose external action has been executed, and whether it succeeded."""
        self.intentions: deque[Intention] = deque()
        """The intentions that are ready for their next statement."""
        self.waits: list[PendingWait] = []
        self.awaits_goals = False
        """Whether an intention has ever waited for what becomes of a goal."""
        self.questions: dict[str, PendingQuestion] = {}
        """The questions of intentions to other agents, by the name of the message."""
        self.deadlines: list[HardDeadline] = []
        """The deadlines of goals, in the order of posting; some goals may have ended."""
        self.woken: list[Intention] = []
        """Intentions that will continue in the next cycle: what they waited for has happened in this one."""
        self.suspended: list[Intention] = []
        self.held_events: list[Event] = []
        """Events of goals that were suspended before a plan was selected for them."""
        self.forked: list[ForkedIntention] = []
        """Intentions that wait for their branches."""
        self.suspending: list[Intention] = []
        """Intentions that will be suspended as soon as what they wait for has come."""
        self.current: Intention | None = None
        """The intention whose statement is being executed."""
        self.atomic: Intention | None = None
        """The intention that must not be interleaved with others, if there is one."""
        self.executed: list[str] = []
        """The labels of the plans selected as intended means, in order."""
        self.awake = True
        """Whether it may have something to do; otherwise it is skipped in a round."""
        self.considered: Plan | None = None
        """The plan whose context is being evaluated, for error messages."""
        self.rule: Rule | None = None
        """The rule that was used last, for error messages."""
        self._queries = 0
        self._intention_count = 0

    # --- intentions

    def new_intention(self) -> Intention:
        """An intention without plans yet."""
        self._intention_count += 1
        return Intention(self._intention_count)

    def go_on(self, intention: Intention) -> None:
        """Make an intention ready for the next statement after one is done."""
        if not intention.stack:  # its outermost goal was declared achieved
            self.note_end(intention)
            return
        means = intention.stack[-1]
        means.pc += 1
        # The common case first: a plan that is not at its end, while nobody suspends anything.
        if means.pc < len(means.body) and not self.suspending:
            self.intentions.append(intention)
        else:
            if means.blocks:
                means.leave_blocks()
            self.requeue(intention)

    def resume(self, intention: Intention) -> None:
        """Resume an intention whose wait is over: it is ready for the next statement, if any, in its turn."""
        # A plan that is at its end now is ended in the intention's next turn, not here as by `go_on`.
        means = intention.stack[-1]
        means.pc += 1
        if means.blocks:
            means.leave_blocks()
        self.ready(intention)

    def requeue(self, intention: Intention) -> None:
        """Make an intention ready for the statement that it is at, or end the plan if it has none left."""
        means = intention.stack[-1]
        if means.pc >= len(means.body):
            self.end_plans(intention)
        else:
            self.ready(intention)

    def ready(self, intention: Intention) -> None:
        """Make an intention ready, unless it has been suspended meanwhile."""
        if intention in self.suspending:
            self.suspending.remove(intention)
            self.suspended.append(intention)
        else:
            self.intentions.append(intention)

    def end_plans(self, intention: Intention) -> None:
        """Remove finished plans from an intention; it continues in the plan that called them, or ends."""
        stack = intention.stack
        while stack and (done := stack[-1]).pc >= len(done.body):
            if intention.branch_of is not None and len(stack) == intention.branch_of.depth:
                self.ready(intention)  # to be joined in its next turn, as in Jason
                return
            stack.pop()
            if done.sign == "+!" and (self.library.follows_goals or self.awaits_goals):
                self.note_goal(done.literal, "finished")
            if stack:
                caller = stack[-1]
                if not done.literal.ground:
                    self._bind_results(done, caller)
                caller.pc += 1
                if caller.blocks:
                    caller.leave_blocks()
        if self.atomic is intention and not intention.atomic:
            self.atomic = None
        if stack:
            self.ready(intention)

    def join(self, branch: Intention, forked: ForkedIntention) -> None:
        """End a branch: the intention continues with its bindings, unless it needs the other branches, too."""
        forked.branches.remove(branch)
        forked.intention.top.unifier.update(branch.top.unifier)
        if not forked.needs_all or not forked.branches:
            self._drop_branches(forked)
            self.go_on(forked.intention)

    def _drop_branches(self, forked: ForkedIntention) -> None:
        """Drop all branches of a fork."""
        if forked in self.forked:
            self.forked.remove(forked)
        for branch in forked.branches:
            self.remove_intention(branch)
            for inner in [inner for inner in self.forked if inner.intention is branch]:
                self._drop_branches(inner)
            branch.branch_of = None
            branch.stack.clear()  # so that whoever goes through all intentions does not take it for one
        forked.branches.clear()

    def leave_fork(self, branch: Intention, depth: int) -> None:
        """Give up the forks above a plan that is given up, at a depth of a branch's stack, with their branches."""
        while branch.branch_of is not None and depth < branch.branch_of.depth:
            forked = branch.branch_of
            if branch in forked.branches:
                forked.branches.remove(branch)
            branch.branch_of = forked.intention.branch_of
            self._drop_branches(forked)
            outer = branch.branch_of
            if outer is not None:  # it takes the place of the branch that it was itself a branch of
                outer.branches[outer.branches.index(forked.intention)] = branch

    def _bind_results(self, done: IntendedMeans, caller: IntendedMeans) -> None:
        """Bind the caller's variables that the plan for its goal has bound."""
        asked = free_variables(done.literal)
        for variable in asked:
            value = self.value(variable, done.unifier)
            if value == variable:
                continue
            # Unbound variables inside the value must not be confused with the caller's variables of the same names.
            renaming: Bindings = {free: self.fresh() for free in free_variables(value) if free not in asked}
            caller.unifier[variable] = substitute_only(value, renaming) if renaming else value

    def note_end(self, intention: Intention) -> None:
        """Note that an intention has ended, by success or failure."""
        if intention.branch_of is not None:
            self.leave_fork(intention, -1)
        if self.atomic is intention:
            self.atomic = None

    def all_intentions(self) -> list[tuple[Intention, Event | None]]:
        """All intentions, whatever they are doing or waiting for, and the goal events that wait for a plan."""
        goals = [(event[2] or Intention(0), event) for event in (*self.events, *self.held_events)]
        others = [
            *self.intentions,
            *(intention for intention, _ in self.feedback),
            *(wait.intention for wait in self.waits),
            *self.woken,
            *(question.intention for question in self.questions.values()),
            *self.suspended,
            *filter(None, [self.current]),
        ]
        return [*goals, *((intention, None) for intention in others)]

    def open_deadlines(self) -> list[HardDeadline]:
        """The deadlines of goals that have not ended yet; the others are forgotten."""
        if self.deadlines:
            posted = {id(literal) for _, literal, _ in (*self.events, *self.held_events)}
            posted.update(id(means.literal) for intention, _ in self.all_intentions() for means in intention.stack)
            self.deadlines = [deadline for deadline in self.deadlines if id(deadline.goal) in posted]
        return self.deadlines

    def remove_intention(self, intention: Intention) -> None:
        """Remove an intention from all queues; it is neither ready nor waiting any more."""
        self.events = deque(event for event in self.events if event[2] is not intention)
        self.held_events = [event for event in self.held_events if event[2] is not intention]
        self.intentions = deque(other for other in self.intentions if other is not intention)
        self.feedback = deque(entry for entry in self.feedback if entry[0] is not intention)
        self.waits = [wait for wait in self.waits if wait.intention is not intention]
        self.woken = [other for other in self.woken if other is not intention]
        questions = self.questions.items()
        self.questions = {name: asked for name, asked in questions if asked.intention is not intention}
        self.suspended = [other for other in self.suspended if other is not intention]

    def remove_event(self, event: Event) -> None:
        """Remove an event that waits for a plan, if it still does."""
        for events in (self.events, self.held_events):
            if event in events:
                events.remove(event)

    # --- events and beliefs

    def post(self, sign: str, literal: Structure, intention: Intention | None) -> None:
        """Add an event, with the intention that waits for it, if any; an external one only if a plan is relevant."""
        if self.waits:
            self._wake_waiting_for(sign, literal)
        if intention is not None or self.library.options[sign][literal.key]:
            self.events.append((sign, literal, intention))
        if sign == "+!" and (self.library.follows_goals or self.awaits_goals):
            self.note_goal(literal, "started")

    def post_goal(self, goal: Structure) -> None:
        """Add a goal to be pursued in a new intention."""
        if self.waits:
            self._wake_waiting_for("+!", goal)
        self.events.append(("+!", goal, None))
        if self.library.follows_goals or self.awaits_goals:
            self.note_goal(goal, "started")

    def note_goal(self, goal: Structure, state: str) -> None:
        """Report the new state of a goal; as in Jason, the agent reacts to it before anything else."""
        event = with_state(goal, state)
        self._wake_waiting_for(GOAL_STATE, event)
        if self.library.options[GOAL_STATE][event.key]:
            self.events.appendleft((GOAL_STATE, event, None))

    def _wake_waiting_for(self, sign: str, literal: Structure) -> None:
        """Resume intentions that wait for an event like this one, in the next cycle."""
        for wait in list(self.waits):  # a copy: those that are over are removed
            if wait.is_for(sign, literal):
                self.end_wait(wait)
                self.woken.append(wait.intention)

    def end_wait(self, wait: PendingWait) -> None:
        """Remove a wait and bind how long it took."""
        self.waits.remove(wait)
        wait.bind_elapsed(self.run.ticks)

    def believe(self, belief: Structure) -> None:
        """Add a belief and post its event, if that changes anything."""
        new = self.beliefs.add(belief)
        if new is not None:
            self.run.progress += 1
            self.post("+", new, None)

    def disbelieve(self, belief: Structure) -> None:
        """Remove a belief's annotations and post its event, if that changes anything."""
        if self.beliefs.remove(belief):
            self.run.progress += 1
            self.post("-", belief, None)

    # --- evaluation

    def value(self, term: Term, bindings: Bindings) -> Term:
        """The term with variables replaced and expressions evaluated."""
        return substitute(term, bindings, self.function)

    def function(self, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""
        return self.actions.function(self, call, bindings)

    def call(self, call: Call, bindings: Bindings, trail: Trail) -> Outcome:
        """The outcome of an internal action as a condition."""
        return self.actions.solve(self, call, bindings, trail)

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        return self.run.fresh()

    def enter_query(self, formula: Formula) -> None:
        """Count a query inside another.

        Raises:
            BdiError: too many of them: rules that call each other through ``not`` for ever.
        """
        self._queries += 1
        if self._queries > MAX_NESTED_QUERIES:
            raise BdiError(
                f"{self.name}: runaway recursion while looking for {formula}, more than {MAX_NESTED_QUERIES} queries "
                f"within queries: {self.activity()}"
            )

    def leave_query(self) -> None:
        """The end of a query."""
        self._queries -= 1

    def activity(self) -> str:
        """A description of the agent's activity, for error messages."""
        if self.current is not None and self.current.stack:
            means = self.current.top
            place = means.plan.location if means.is_finished else means.statement.location
            return f"in plan @{means.plan.label} ({place})"
        if self.considered is not None:
            return f"in the context of plan @{self.considered.label} ({self.considered.location})"
        return "before any plan"
