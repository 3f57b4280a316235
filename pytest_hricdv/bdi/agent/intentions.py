"""What an agent's reasoning consists of: events, intentions, and what intentions wait for.

An `Intention` is a stack of `IntendedMeans`: plans that are being executed. `RunServices` is the interface of the run
that agents use (implemented by `SystemRun`), `ActionTable` that of the internal actions (`StandardActions`).
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from pytest_hricdv.bdi.agent.directory import Directory
from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax import Body, ExternalAction, For, Formula, Plan, PlanTrigger, Statement, While
from pytest_hricdv.bdi.language.terms import Call, Number, Structure, Term, Variable
from pytest_hricdv.bdi.logic.substitution import Bindings
from pytest_hricdv.bdi.logic.unify import Trail, undo, unify

TICKS_PER_MS = 10
"""Ticks of virtual time in a millisecond. A round takes one tick, 0.1 ms: a cycle of Jason takes half to twice that."""
_OF_FAILURES = frozenset({"error", "error_msg", "code", "code_src", "code_line"})
"""The annotations that say how a goal has failed."""
ADDED_GOALS = frozenset({"+!", "+?"})
"""The signs of events that add a goal or a test goal."""


def ticks_of(wait_ms: float) -> float:
    """The ticks that a wait lasts: a whole number."""
    length = wait_ms * TICKS_PER_MS
    if length == math.inf or length <= 0.0:
        return max(0.0, length)
    # Rounded first: a tenth of a millisecond has no exact binary form.
    return length if length.is_integer() else math.ceil(round(length, 6))


@dataclass(slots=True, eq=False)
class LoopState:
    """A ``for`` or ``while`` being executed: the bindings to restore, and the solutions that a ``for`` has left."""

    statement: For | While
    outer: Bindings
    solutions: deque[Bindings]


class IntendedMeans:
    """A plan that is being executed for an event: its bindings, and the next statement."""

    __slots__ = ("blocks", "body", "literal", "loop", "pc", "plan", "sign", "unifier")

    def __init__(self, plan: Plan, sign: str, literal: Structure, unifier: Bindings) -> None:
        self.plan = plan
        self.sign = sign
        self.literal = literal
        self.unifier = unifier
        self.body: Body = plan.body
        self.pc = 0
        """The index of the next statement in the body."""
        self.blocks: list[tuple[Body, int, LoopState | None]] = []
        """The enclosing bodies of the block being executed, the innermost last, and where to continue in them."""
        self.loop: LoopState | None = None
        """The loop whose statement is next, if it has been executed at least once."""

    @property
    def goal(self) -> Structure | None:
        """The achievement goal that it pursues, or whose failure it handles: as in Jason, that is pursued still."""
        if self.sign != "-!":
            return self.literal if self.sign == "+!" else None
        annots = self.literal.annots
        own = tuple(annot for annot in annots if not isinstance(annot, Structure) or annot.functor not in _OF_FAILURES)
        return self.literal.with_annotations(own)

    def copy(self) -> IntendedMeans:
        """The plan at the same statement, with bindings of its own."""
        means = IntendedMeans(self.plan, self.sign, self.literal, dict(self.unifier))
        means.body, means.pc, means.blocks, means.loop = self.body, self.pc, list(self.blocks), self.loop
        return means

    @property
    def is_finished(self) -> bool:
        """Whether the plan has no statement left."""
        return self.pc >= len(self.body)

    @property
    def statement(self) -> Statement:
        """The statement to be executed, or the one being waited for."""
        return self.body[self.pc]

    @property
    def is_at_end(self) -> bool:
        """Whether nothing is left after the statement that it waits for."""
        blocks = all(loop is None and pc >= len(body) for body, pc, loop in self.blocks)
        return blocks and self.pc + 1 >= len(self.body)

    def enter(self, body: Body, loop: LoopState | None) -> None:
        """Execute a block next; afterwards the loop's statement again, or else the statement after this one."""
        self.blocks.append((self.body, self.pc if loop else self.pc + 1, loop))
        self.body, self.pc = body, 0
        self.leave_blocks()

    def leave_blocks(self) -> None:
        """Return from finished blocks to the enclosing ones."""
        while self.blocks and self.pc >= len(self.body):
            self.body, self.pc, loop = self.blocks.pop()
            if loop is not None:
                self.loop = loop
                return


class Intention:
    """A stack of plans, the one being executed last."""

    __slots__ = ("branch_of", "number", "stack")

    def __init__(self, number: int) -> None:
        self.number = number
        self.branch_of: ForkedIntention | None = None
        """The intention that continues after a branch of a fork; the branch has copies of the plans below."""
        self.stack: list[IntendedMeans] = []

    @property
    def top(self) -> IntendedMeans:
        """The plan being executed."""
        return self.stack[-1]

    @property
    def atomic(self) -> bool:
        """Whether one of its plans must not be interleaved with other intentions."""
        return any(means.plan.atomic for means in self.stack)

    def optimize_tail_recursion(self, sign: str) -> None:
        """Drop a plan that ends by pursuing its own goal again (an event of this sign): such loops need no memory."""
        # Only where nothing is left to do after the goal, neither in this plan nor in an enclosing block, where no
        # variable of its own goal is still to be bound for a caller, and where its own goal has no deadline.
        top = self.stack[-1]
        if (
            sign == "+!"
            and top.sign == "+!"
            and top.pc == len(top.body) - 1
            and not top.blocks
            and not top.plan.atomic
            and self.branch_of is None
            and top.literal.ground
            and len(top.literal.annots) < 2
        ):
            self.stack.pop()


class ForkedIntention:
    """An intention that waits for all of its branches, or for one."""

    __slots__ = ("branches", "depth", "intention", "needs_all")

    def __init__(self, intention: Intention, needs_all: bool) -> None:
        self.intention = intention
        self.needs_all = needs_all
        self.depth = len(intention.stack)
        """The number of plans that each branch has copies of; what is above is the branch's own."""
        self.branches: list[Intention] = []
        """The branches that are not done."""


Event = tuple[str, Structure, Intention | None]
"""Something an agent may react to: sign and literal; for an internal event, also the intention that waits for it."""


@dataclass(slots=True, eq=False)
class PendingWait:
    """An intention that waits for an event, for a condition, or for virtual time to pass."""

    intention: Intention
    since: int
    """When it began, in ticks of the virtual clock."""
    deadline: float | None = None
    """When it stops waiting, in ticks."""
    trigger: PlanTrigger | None = None
    condition: Formula | None = None
    elapsed: Term | None = None
    """Unified with the time waited, in ms; without it, reaching the deadline of a wait for something is a failure."""

    def is_for(self, sign: str, literal: Structure) -> bool:
        """Whether an event is the one it waits for; then the plan's variables are bound."""
        if self.trigger is None or self.trigger.sign != sign:
            return False
        bindings = self.intention.top.unifier
        trail: Trail = []
        if unify(self.trigger.literal, literal, bindings, trail):
            return True
        undo(bindings, trail, 0)
        return False

    def bind_elapsed(self, now: int) -> None:
        """Unify the time waited until a tick with the variable given for it."""
        if self.elapsed is not None:
            unify(self.elapsed, Number(round((now - self.since) / TICKS_PER_MS)), self.intention.top.unifier, [])


@dataclass(slots=True, eq=False)
class HardDeadline:
    """The deadline of a goal posted with the annotation ``hard_deadline(Ms)``: it fails then, unless it has ended."""

    goal: Structure
    """The goal object of its event and its plan."""
    deadline: float
    """The tick of the virtual clock."""


@dataclass(slots=True, eq=False)
class SpeechAct:
    """A speech act."""

    sender: str
    """The sending agent; ``self`` for the receiver itself."""
    force: str
    """Its illocutionary force, such as ``tell``."""
    content: Term
    number: int
    """Identifies it in its run."""
    reply_to: str = ""
    """The name of the message that it answers, or empty."""

    @property
    def name(self) -> str:
        """The name that agents use for it."""
        return f"mid{self.number}"


@dataclass(slots=True, eq=False)
class PendingQuestion:
    """An intention that waits for answers, and the term that they are unified with."""

    intention: Intention
    force: str
    answer: Term
    """Unified with the answer, or with the list of answers if several agents were asked."""
    deadline: float | None
    """When it stops waiting, in ticks of the virtual clock."""
    asked: int | None
    """How many agents were asked if it was a list of them, else None."""
    answers: list[Term] = field(default_factory=list)


class PerceptSource(Protocol):
    """The percepts of an agent."""

    @property
    def version(self) -> int:
        """Grows with every change."""

    def literals(self) -> Iterable[Structure]:
        """The present percepts."""


class RunServices(Protocol):
    """The services that a run offers to its agents."""

    progress: int
    """Grows with everything that another agent, or the user, could notice, or that the agent could remember."""
    busy_waiting: bool
    """Set when an agent has waited busily in this round."""
    messages: int
    """The number of messages sent so far."""
    directory: Directory
    """The directory of services."""

    @property
    def agents(self) -> Mapping[str, object]:
        """The agents by name."""

    @property
    def ticks(self) -> int:
        """The virtual clock."""

    @property
    def time_ms(self) -> float:
        """Virtual time."""

    def deadline(self, wait_ms: float) -> float:
        """The tick at which a wait that begins now is over."""

    def note_deadline(self, deadline: float) -> None:
        """An intention has begun to wait until then."""

    def percepts_of(self, agent: str) -> PerceptSource:
        """The percepts of an agent, now and later."""

    def deliver(self, receiver: str, message: SpeechAct) -> None:
        """Put a message into its receiver's mailbox."""

    def create_agent(self, name: str, source: str, place: Location) -> None:
        """Let a new agent take part from the next round on, with what a source file says."""

    def clone_agent(self, original: str, name: str, place: Location) -> None:
        """Let a new agent take part from the next round on, with what another one believes and its plans."""

    def kill_agent(self, name: str) -> bool:
        """Let an agent take part no longer; whether there was one of that name."""

    def act(self, agent: str, action: Structure, plan: Plan, statement: ExternalAction) -> bool:
        """Let the environment execute an action; whether it succeeded."""

    def print(self, agent: str, text: str) -> None:
        """Record what an agent prints."""

    def warn(self, text: str) -> None:
        """Record what the author of the model should know."""

    def draw(self) -> float:
        """The next random number, from 0 inclusive to 1 exclusive."""

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""

    def is_fresh(self, variable: Variable) -> bool:
        """Whether :meth:`fresh` made the variable."""

    def stop(self) -> None:
        """End the run after this round."""


Outcome = bool | Iterator[object]
"""Success or failure of an internal action, or an iterator that binds variables anew for each solution."""
ActionResult = tuple[bool, bool, tuple[Term, ...]]
"""The result of an internal action as a statement: whether it succeeded; whether it moved its own intention, which then
does not continue with the next statement by itself; annotations for the failure event."""


class ActionTable(Protocol):
    """The internal actions and functions that agents can use."""

    def execute(self, agent: Any, call: Call, bindings: Bindings, intention: Intention) -> ActionResult:
        """Execute an internal action as a statement of an intention."""

    def solve(self, agent: Any, call: Call, bindings: Bindings, trail: Trail) -> Outcome:
        """Evaluate an internal action as a condition."""

    def function(self, agent: Any, call: Call, bindings: Bindings) -> Term:
        """The value of a function in an expression."""
