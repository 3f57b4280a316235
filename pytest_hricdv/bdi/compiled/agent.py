"""An agent that runs compiled code."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from ..beliefs import BeliefBase
from ..environment import Environment
from ..intentions import Message, Question, Wait
from ..library import PlanLibrary
from ..syntax import Rule
from ..terms import Key, Structure, Term, in_order, source
from ..waiting import end_waits
from .handover import to_interpreter
from .program import Annots, PlanCode, ProgramCode, TriggerCode, Values
from .runtime import BailError

if TYPE_CHECKING:
    from ..agent import Agent
    from ..scheduler import Run

Args = tuple[Term, ...]
Table = dict[Args, Annots]
Slot = Any
"""A proposition's name, or a belief's arguments."""
Store = dict[Slot, Annots]
Pending = tuple[TriggerCode, Args, Annots, "Activity | None"]
Caller = tuple[PlanCode, int, Values, TriggerCode, Args, Annots]


class Activity:
    """What an intention is to the interpreter: the plan being executed, and those that called it."""

    __slots__ = ("annots", "args", "below", "left", "number", "pc", "plan", "trigger", "values")

    def __init__(self, number: int) -> None:
        self.number = number
        self.below: list[Caller] = []
        self.left = 0
        self.plan: PlanCode
        self.pc = 0
        self.values: Values = ()
        self.trigger: TriggerCode
        self.args: Args = ()
        self.annots: Annots = ()


class AgentCode:
    """What is the same for an agent in all runs.

    Args:
        program: the compiled form of its program.
        beliefs: what it believes at first, without rules.
        library: its plans.
        events: what it has to react to at first.
    """

    def __init__(
        self, program: ProgramCode, beliefs: BeliefBase, library: PlanLibrary, events: list[tuple[str, Structure]]
    ) -> None:
        self.program = program
        self.library = library
        self.propositions: dict[str, Annots] = {}
        self.tables: list[Table] = [{} for _ in program.tables]
        self.others: dict[Key, Table] = {}
        for belief in beliefs:
            assert not isinstance(belief, Rule)
            if not belief.args:
                self.propositions[f"~{belief.functor}" if belief.negated else belief.functor] = belief.annots
            elif belief.key in program.tables:
                self.tables[program.tables[belief.key]][belief.args] = belief.annots
            else:
                self.others.setdefault(belief.key, {})[belief.args] = belief.annots
        self.events: list[Pending] = [
            (program.trigger(sign, literal.key), literal.args, literal.annots, None) for sign, literal in events
        ]


class CompiledAgent:
    """An agent in a run, compiled.

    Where there is no compiled form for what comes next, it hands over to the interpreter, for the rest of the run.

    Args:
        name: its name.
        run: the run it takes part in.
        code: its program and how it begins.
    """

    __slots__ = (
        "_code",
        "_listens",
        "_seen_percepts",
        "_versions",
        "acts_alone",
        "awake",
        "count",
        "events",
        "executed",
        "feedback",
        "granted",
        "intentions",
        "listed",
        "mailbox",
        "name",
        "others",
        "p",
        "questions",
        "run",
        "tables",
        "unused",
        "waits",
    )

    def __init__(self, name: str, run: Run, code: AgentCode) -> None:
        self.name = name
        self.run = run
        self._code = code
        self.p = dict(code.propositions)
        """Beliefs without arguments: their names, and their annotations."""
        self.tables = list(map(dict, code.tables))
        """Beliefs with arguments of the predicates that the program tests."""
        self.others = {key: dict(table) for key, table in code.others.items()} if code.others else {}
        """Beliefs of other predicates."""
        self.mailbox: deque[Message] = deque()
        self.events: deque[Pending] = deque(code.events)
        self.feedback: deque[tuple[Activity, bool]] = deque()
        self.intentions: deque[Activity] = deque()
        self.waits: list[Wait] = []
        self.questions: dict[str, Question] = {}
        self.executed: list[str] = []
        self.count = 0
        """Activities so far."""
        self.granted = 0
        """The cycles that may be done at once."""
        self.unused = 0
        """The part of them that was not needed."""
        self.acts_alone = type(run.environment) is Environment
        """Whether actions do nothing but succeed, so that they need not be executed."""
        self._versions = run.percept_versions(name)
        self._seen_percepts = 0
        self.listed: tuple[Structure, ...] = ()
        """What its environment listed when it last looked."""
        self._listens = not self.acts_alone or bool(self._versions.get(name, 0))
        self.awake = self.has_work()

    # --- the reasoning cycle

    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""
        return bool(
            self.intentions
            or self.events
            or self.mailbox
            or self.feedback
            or self._seen_percepts != self._versions.get(self.name, 0)
        )

    def cycle(self) -> None:
        """Do one reasoning cycle."""
        self.work(1)

    def work(self, rounds: int) -> int:
        """Do cycles while every other agent is idle, at most so many; the number done."""
        if self._listens and not self._perceive():
            self.interpreted().cycle()
            return 1
        if self.mailbox and not self._receive(self.mailbox[0]):
            self.interpreted().cycle()
            return 1
        if self.feedback and not self.feedback[0][1]:
            self.interpreted().reason()
            return 1
        events = self.events
        while events:
            trigger, args, annots, activity = pending = events.popleft()
            try:
                done = self._react(trigger, args, annots, activity)
            except BailError:
                events.appendleft(pending)
                self.interpreted().reason()
                return 1
            if done:
                break
        if self.feedback:
            self._acted(self.feedback.popleft()[0])
        intentions = self.intentions
        done_rounds = 1
        if intentions:
            activity = intentions.popleft()
            n = 1 if intentions or events or self.mailbox or self.feedback else rounds
            self.granted = n
            self.unused = 0
            left = n
            try:
                while left:
                    left = activity.plan.run(self, activity, left)
            except BailError:
                return self._leave(activity)
            done_rounds = n - self.unused
        self.awake = bool(intentions or events or self.mailbox or self.feedback)
        return done_rounds

    def _leave(self, activity: Activity) -> int:
        """The statement an activity is at, or the selection of a plan for its goal, is left to the interpreter."""
        done = self.granted - activity.left
        if not (self.events and self.events[0][3] is activity):
            self.intentions.appendleft(activity)
        agent = self.interpreted()
        if done:
            # Before it: other cycles have been done already, and the virtual clock does not know of them yet.
            return done
        agent.act()
        return 1

    def _perceive(self) -> bool:
        """Believe what is perceived at first; False if percepts change later, which is left to the interpreter."""
        version = self._versions.get(self.name, 0)
        if version == self._seen_percepts:
            return True
        if self._seen_percepts:
            return False
        self._seen_percepts = version
        self._listens = not self.acts_alone
        self.run.progress += 1
        self.listed = self.run.environment.percepts(self.name)
        for percept in self.listed:
            self._believe(percept, percept.annots)
        return True

    def _receive(self, message: Message) -> bool:
        """Act on a message; False if that is left to the interpreter."""
        content = message.content
        if not isinstance(content, Structure) or not content.ground or message.reply_to:
            return False
        annots: Annots = (source(message.sender),)
        if content.annots:
            annots = in_order(content.annots + annots)
        if message.force == "tell":
            self._believe(content, annots)
        elif message.force == "achieve":
            trigger = self._code.program.triggers.get(("+!", content.key))
            if trigger is None:
                return False
            self.events.append((trigger, content.args, annots, None))
        else:
            return False
        self.mailbox.popleft()
        return True

    def _believe(self, literal: Structure, annots: Annots) -> None:
        """Add a belief that comes from outside."""
        if not literal.args:
            new = self.add(self.p, f"~{literal.functor}" if literal.negated else literal.functor, annots)
        else:
            place = self._code.program.tables.get(literal.key)
            table = self.others.setdefault(literal.key, {}) if place is None else self.tables[place]
            new = self.add(table, literal.args, annots)
        if new is not None:
            trigger = self._code.program.triggers.get(("+", literal.key))
            if trigger is not None and trigger.select is not None:
                self.events.append((trigger, literal.args, new, None))

    def _react(self, trigger: TriggerCode, args: Args, annots: Annots, activity: Activity | None) -> bool:
        """Find a plan for an event; False for a belief event without one: another event is selected at once."""
        selected = None if trigger.select is None else trigger.select(self, args, annots)
        if selected is None:
            if trigger.sign == "+!":
                raise BailError
            if activity is None:
                return False
            self.resume(activity)
            return True
        if activity is None:
            self.count += 1
            activity = Activity(self.count)
        else:
            self._push(activity, trigger)
        activity.plan, activity.values = selected
        activity.pc = 0
        activity.trigger, activity.args, activity.annots = trigger, args, annots
        self.intentions.append(activity)
        return True

    def _push(self, activity: Activity, trigger: TriggerCode) -> None:
        """Keep the plan that has called another, unless it ends by pursuing its own goal again."""
        plan = activity.plan
        if trigger is not activity.trigger or activity.pc != plan.last or trigger.sign != "+!":
            activity.below.append(
                (plan, activity.pc, activity.values, activity.trigger, activity.args, activity.annots)
            )

    # --- what plans do

    def enter(self, activity: Activity, trigger: TriggerCode, args: Args, annots: Annots, left: int) -> int:
        """Post an event that an activity waits for and react to it at once: nothing can come between."""
        try:
            self._react(trigger, args, annots, activity)
        except BailError:
            activity.left = left
            self.events.appendleft((trigger, args, annots, activity))
            raise
        self.intentions.pop()
        return left

    def resume(self, activity: Activity) -> None:
        """What an activity waited for has come: it is ready for the next statement, if any, in its turn."""
        activity.pc = activity.plan.after[activity.pc]
        self.intentions.append(activity)

    def _acted(self, activity: Activity) -> None:
        """An action has succeeded."""
        activity.pc = activity.plan.after[activity.pc]
        if activity.pc < len(activity.plan.after) or self._return(activity):
            self.intentions.append(activity)

    def _return(self, activity: Activity) -> bool:
        """Go back to where a finished plan was called; False if the activity has ended."""
        below = activity.below
        while below:
            plan, pc, values, activity.trigger, activity.args, activity.annots = below.pop()
            activity.plan, activity.values = plan, values
            activity.pc = plan.after[pc]
            if activity.pc < len(plan.after):
                return True
        return False

    def finish(self, activity: Activity, left: int) -> int:
        """The last statement of a plan is done, with so many cycles left; those that can be used now."""
        if self._return(activity):
            if left:
                return left
            self.intentions.append(activity)
        else:
            self.unused += left
        return 0

    def finish_acted(self, activity: Activity, left: int) -> int:
        """As :meth:`finish` after an action, whose outcome comes in the next cycle."""
        if self._return(activity):
            return left
        self.unused += left - 1
        return 0

    def add(self, store: Store, slot: Slot, annots: Annots) -> Annots | None:
        """Add a belief, or its annotations; those that are new, None if none is."""
        held = store.get(slot)
        if held is None:
            store[slot] = annots
        else:
            added = tuple(annot for annot in annots if annot not in held)
            if not added:
                return None
            store[slot] = in_order(held + added)
            annots = added
        self.run.progress += 1
        return annots

    def remove(self, store: Store, slot: Slot, annots: Annots) -> Annots | None:
        """Remove a belief's annotations, and the belief with its last source; None if that changes nothing."""
        held = store.get(slot)
        if held is None:
            return None
        if held != annots:
            if not all(annot in held for annot in annots):
                return None
            left = tuple(annot for annot in held if annot not in annots)
            if any(isinstance(annot, Structure) and annot.key == _SOURCE for annot in left):
                store[slot] = left
                self.run.progress += 1
                return annots
        del store[slot]
        self.run.progress += 1
        return annots

    def displace(self, store: Store, slot: Slot | None, annots: Annots, trigger: TriggerCode) -> bool:
        """Remove the newest belief of a predicate that has these annotations; whether that is an event for a plan."""
        for candidate in reversed(list(store)) if slot is None else (slot,):
            held = store.get(candidate)
            if held is not None and all(annot in held for annot in annots):
                self.remove(store, candidate, annots)
                args: Args = candidate if isinstance(candidate, tuple) else ()
                return self._lost(trigger, args, annots)
        return False

    def abolish(self, store: Store, slots: Iterable[Slot], trigger: TriggerCode) -> bool:
        """Remove beliefs with all their sources; whether that is an event for a plan."""
        event = False
        for slot in slots:
            held = store.pop(slot, None)
            if held is not None:
                self.run.progress += 1
                event |= self._lost(trigger, slot if isinstance(slot, tuple) else (), held)
        return event

    def _lost(self, trigger: TriggerCode, args: Args, annots: Annots) -> bool:
        if trigger.select is None:
            return False
        self.events.append((trigger, args, annots, None))
        return True

    def send(self, receiver: str, force: str, content: Term) -> None:
        """Send a message."""
        run = self.run
        to = run.agents[receiver]
        sender = "self" if receiver == self.name else self.name
        run.deliver(to, Message(sender, force, content, run.next_message_number()))

    def wait(self, activity: Activity, wait_ms: float, left: int) -> int:
        """Let an activity wait; no cycle can be used now."""
        run = self.run
        now = run.ticks + self.granted - left
        deadline = run.after(wait_ms) + now - run.ticks
        self.waits.append(Wait(activity, now, deadline))  # type: ignore[arg-type]
        run.note_deadline(deadline)
        self.unused += left - 1
        return 0

    # --- what others do with it

    def end_waits(self, now: int) -> None:
        """Let the activities go on whose wait is over."""
        end_waits(self, now)  # type: ignore[arg-type]

    def interpreted(self) -> Agent:
        """The agent in the form that the interpreter runs; it takes this one's place."""
        agent = to_interpreter(self, self._code, self._seen_percepts)
        self.run.agents[self.name] = agent
        return agent

    def doing(self) -> str:
        """Where the agent is, for error messages."""
        return "in a compiled plan"


_SOURCE: Key = (False, "source", 1)
