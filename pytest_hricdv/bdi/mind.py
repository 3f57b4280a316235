"""An agent's mental state."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import Plan
from pytest_hricdv.bdi.language.terms import Structure, Variable
from pytest_hricdv.bdi.logic.inference import MAX_NESTED_QUERIES

from .beliefs import BeliefBase
from .intentions import Event, Intention
from .library import PlanLibrary
from .participant import Participant

if TYPE_CHECKING:
    from .scheduler import Run


class Mind(Participant):
    """What an interpreted agent believes, intends and has yet to react to.

    Args:
        name: the name of the agent.
        run: the run it takes part in.
        beliefs: what it believes at first; the agent makes it its own.
        library: its plans.
        events: what it has to react to at first.
    """

    def __init__(
        self,
        name: str,
        run: Run,
        beliefs: BeliefBase,
        library: PlanLibrary,
        events: list[tuple[str, Structure]],
    ) -> None:
        super().__init__(name, run, takes_letters=False)
        self.beliefs = beliefs
        self.library = library
        self.looked = -1
        """The round in which it has selected a plan that does nothing but look again."""
        self.events: deque[Event] = deque(Event(sign, literal, None) for sign, literal in events)
        self.feedback: deque[tuple[Intention, bool]] = deque()
        self.intentions: deque[Intention] = deque()
        self.woken: list[Intention] = []
        """Intentions that will go on with the next cycle: what they waited for has happened in this one."""
        self.listed: tuple[Structure, ...] = ()
        """What its environment listed when it last looked."""
        self.suspended: list[Intention] = []
        self.suspending: list[Intention] = []
        """Intentions that will be suspended as soon as what they wait for has come."""
        self.current: Intention | None = None
        """The intention whose statement is being executed."""
        self.left = 1
        """How many cycles it may do at once, the one under way among them."""
        self.disturbed = True
        """Whether more may have changed than what it believes and intends, so that it has to look around."""
        self.has_own_message_plans = library.has_own_message_plans
        self._considered: Plan | None = None
        self._atomic: Intention | None = None
        self._percept_versions = run.percept_versions(name)
        self._seen_percepts = 0
        self._queries = 0
        self._intention_count = 0
        self._condition_version = -1
        self.awake = self.has_work()

    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""
        return bool(self.events) or self.has_news()

    def has_news(self) -> bool:
        """Whether a cycle would do anything besides reacting to an event."""
        return bool(
            self.intentions
            or self.mailbox
            or self.feedback
            or self.woken
            or self._seen_percepts != self._percept_versions.get(self.name, 0)
        )

    def take_over(self, intentions: int, seen_percepts: int) -> None:
        """Go on where a compiled agent has left off, whose queues have been handed over.

        Args:
            intentions: how many it has had.
            seen_percepts: the version of its percepts when it last looked.
        """
        self._intention_count = intentions
        self._seen_percepts = seen_percepts

    def new_intention(self) -> Intention:
        """An intention without plans yet."""
        self._intention_count += 1
        return Intention(self._intention_count)

    def resume(self, intention: Intention) -> None:
        """What an intention waited for has come: it is ready for the next statement, if any, in its turn."""
        frame = intention.frames[-1]
        frame.pc += 1
        if frame.blocks:
            frame.leave_blocks()
        if self.suspending:
            self.ready(intention)
        else:
            self.intentions.append(intention)

    def ready(self, intention: Intention) -> None:
        """An intention can go on, unless it has been suspended meanwhile."""
        if intention in self.suspending:
            self.suspending.remove(intention)
            self.suspended.append(intention)
        else:
            self.intentions.append(intention)

    def attend(self, intention: Intention | None) -> None:
        """Begin to execute a statement of an intention, or end that."""
        self.current = intention

    def note_end(self, intention: Intention) -> None:
        """An intention has ended, by success or failure."""
        if self._atomic is intention:
            self._atomic = None

    def _atomic_event(self) -> Event | None:
        """The event of the intention that must not be interleaved with others.

        None if it is ready, or waits for an answer, an action or time: nothing may come between.
        """
        for event in self.events:
            if event.intention is self._atomic:
                self.events.remove(event)
                return event
        return None

    def _atomic_intention(self) -> Intention | None:
        """The intention that must not be interleaved with others.

        None if it waits for its own event or for time to pass: nothing may come between.
        """
        atomic = self._atomic
        if atomic is None or atomic not in self.intentions:
            return None
        self.intentions.remove(atomic)
        return atomic

    def only_spins(self, goal: Structure) -> bool:
        """Whether the event of a goal is all that it has, and nothing but what comes from outside changes that."""
        if len(self.events) > 1 or self.suspending or self.has_news():
            return False
        # What the plan looks for may have come after the plan was selected.
        return self.looked == self.run.rounds and not self.beliefs.open and self.library.is_steady(goal.key)

    def fresh(self) -> Variable:
        """A variable that occurs nowhere else in the run."""
        return self.run.fresh()

    def enter_query(self, formula: Formula) -> None:
        """Count a query within queries.

        Raises:
            BdiError: too many of them: rules that call each other through ``not`` for ever.
        """
        self._queries += 1
        if self._queries > MAX_NESTED_QUERIES:
            raise BdiError(f"{self.name}: runaway recursion while looking for {formula}: {self.doing()}")

    def leave_query(self) -> None:
        """The end of a query."""
        self._queries -= 1

    def doing(self) -> str:
        """Where the agent is, for error messages."""
        if self.current is not None and self.current.frames:
            frame = self.current.frames[-1]
            place = frame.plan.location if frame.finished else frame.statement.location
            return f"in plan @{frame.plan.label} ({place})"
        if self._considered is not None:
            return f"in the context of plan @{self._considered.label} ({self._considered.location})"
        return "before any plan"
