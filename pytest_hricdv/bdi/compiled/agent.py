"""An agent that runs compiled code."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pytest_hricdv.bdi.language.terms import Structure, sorted_terms, source

from ..intentions import Letter, Message
from ..spinning import take_up
from .activity import Activity, begin, resumed
from .changes import add
from .handover import to_interpreter
from .mind import CompiledMind
from .program import Annots, Slot, Store, proposition
from .runtime import BailError

if TYPE_CHECKING:
    from ..agent import Agent

_SENT: dict[str, Annots] = {}
"""The annotations of what an agent has sent, by its name: the same object every time."""


class CompiledAgent(CompiledMind):
    """An agent in a run, compiled.

    Where there is no compiled form for what comes next, it hands over to the interpreter, for the rest of the run.

    Args:
        name: its name.
        run: the run it takes part in.
        code: its program and how it begins.
    """

    __slots__ = ()

    # --- the reasoning cycle

    def cycle(self) -> None:
        """Do one reasoning cycle."""
        self.work(1)

    def work(self, rounds: int) -> int:
        """Do cycles while every other agent is idle, at most so many; the number done, at least one."""
        mailbox, events, feedback, intentions = self._queues
        if (mailbox or self._listens) and not self._take_in():
            self.interpreted().cycle()
            return 1
        try:
            if feedback or intentions:
                if events or feedback:
                    activity = self._react()
                else:
                    activity = self.resumed = intentions.popleft()
            else:
                activity = self._select() if events else None
        except BailError:
            self.interpreted().reason()
            return 1
        if activity is not None:
            if rounds > 1 and (intentions or events or mailbox or feedback):
                rounds = 1
            self.granted = left = rounds
            try:
                while left > 0:
                    left = activity.plan.run(self, self.p, self.tables, activity, activity.pc, activity.values, left)
            except BailError:
                return self._leave(activity)
            rounds = self.granted + left
        else:
            rounds = 1
        if not (intentions or events or feedback or mailbox):
            self.awake = False
        return self._fall_in(rounds) if self.ahead else rounds

    def _fall_in(self, done: int) -> int:
        """Let the others catch up; the cycles done when the first of them had something to do."""
        before, self.ahead = self.ahead, 0
        self.run.hold(self, self.run.rounds + done)
        return before

    def _take_in(self) -> bool:
        """Perceive, and act on one message; False if that is left to the interpreter."""
        if self._listens and not self._perceive():
            return False
        mailbox = self.mailbox
        if not mailbox:
            return True
        message = mailbox.popleft()
        if type(message) is not Letter:
            mailbox.appendleft(message)
            return self._receive(message)
        if message.told:
            place = message.place
            store = None if place is None else self.p if place < 0 else self.tables[place]
            if store is None or self.is_watched or message.slot in store:
                self._believe(message.literal, message.annots)
                return True
            store[message.slot] = message.annots
            self.run.progress += 1
        if message.event is not None:
            self.events.append(message.event)
        return True

    def _react(self) -> Activity | None:
        """React to one event and to the outcome of one action, with others ready; what to execute then.

        Raises:
            BailError: that is left to the interpreter.
        """
        _, events, feedback, intentions = self._queues
        if feedback and not feedback[0][1]:
            raise BailError
        activity = self._select() if events else None
        if activity is not None:
            intentions.append(activity)
        if feedback:
            acted, _ = feedback.popleft()
            if resumed(acted):
                intentions.append(acted)
        if not intentions:
            return None
        chosen = intentions.popleft()
        self.resumed = None if chosen is activity else chosen
        return chosen

    def _select(self) -> Activity | None:
        """Find a plan for an event; the activity that goes on with it.

        Raises:
            BailError: that is left to the interpreter.
        """
        events = self.events
        while events:
            goal, activity = events.popleft()
            trigger, args, annots = goal
            try:
                selected = None if trigger.select is None else trigger.select(self, self.p, self.tables, args, annots)
                if selected is None and trigger.is_goal:
                    raise BailError
            except BailError:
                events.appendleft((goal, activity))
                raise
            if selected is not None:
                self.resumed = None
                plan, values = selected
                self.executed.append(plan.label)
                if activity is not None:
                    begin(activity, goal, plan, values)
                    return activity
                self.activities += 1
                return Activity(self.activities, plan, values, goal)
            if activity is not None:
                activity.pc = activity.plan.after[activity.pc]
                return activity
            # A belief event without a plan lets another be selected at once.
        return None

    def _perceive(self) -> bool:
        """Believe what is perceived at first; False if percepts change later, which is left to the interpreter."""
        if self.spin is not None:
            take_up(self)
            self._listens = not self.acts_alone
        version = self._versions.get(self.name, 0)
        if version == self.seen_percepts:
            return True
        if self.seen_percepts:
            return False
        self.seen_percepts = version
        self._listens = not self.acts_alone
        self.run.progress += 1
        self.listed = self.run.environment.percepts(self.name)
        for percept in self.listed:
            self._believe(percept, percept.annots)
        return True

    def _receive(self, message: Message) -> bool:
        """Act on a message; False if that is left to the interpreter."""
        content = message.content
        if type(content) is not Structure or not content.ground or message.reply_to:
            return False
        sender = message.sender
        annots: Annots = _SENT[sender] if sender in _SENT else _SENT.setdefault(sender, (source(sender),))
        if content.annots:
            annots = sorted_terms(content.annots + annots)
        if message.force == "tell":
            self.mailbox.popleft()
            self._believe(content, annots)
            return True
        trigger = self.code.program.triggers.get(("+!", content.key))
        if trigger is None or message.force != "achieve":
            return False
        self.mailbox.popleft()
        self.events.append(((trigger, content.args, annots), None))
        return True

    def _believe(self, literal: Structure, annots: Annots) -> None:
        """Add a belief that comes from outside."""
        key = literal.key
        program = self.code.program
        store: Store
        slot: Slot
        if not literal.args:
            store, slot = self.p, proposition(literal) if literal.negated else literal.functor
        else:
            place = program.tables.get(key)
            store = self.others.setdefault(key, {}) if place is None else self.tables[place]
            slot = literal.args
        new: Annots | None = annots
        if slot in store:
            new = add(self, store, slot, annots)
        else:
            store[slot] = annots
            self.run.progress += 1
        if new is not None and key in program.noticed:
            self.events.append(((program.noticed[key], literal.args, new), None))

    def _leave(self, activity: Activity) -> int:
        """The statement an activity is at, or the selection of a plan for its goal, is left to the interpreter."""
        done = self.granted - activity.left
        ahead, self.ahead = self.ahead, 0
        if not (self.events and self.events[0][1] is activity):
            self.intentions.appendleft(activity)
        agent = self.interpreted()
        if done:
            # In the next round: cycles have been done already, and the virtual clock does not know of them yet.
            if ahead:
                self.run.hold(agent, self.run.rounds + done)
            return ahead or done
        agent.act()
        return 1

    # --- what others do with it

    def resume(self, activity: Activity) -> None:
        """What an activity waited for has come: it is ready for the next statement, if any, in its turn."""
        activity.pc = activity.plan.after[activity.pc]
        self.intentions.append(activity)

    def end_waits(self, now: int) -> None:
        """Let the activities go on whose wait is over at a tick of the virtual clock, the earliest first."""
        waits = self.waits if len(self.waits) == 1 else sorted(self.waits, key=lambda wait: wait.deadline or 0)
        for wait in waits.copy():
            if wait.deadline is not None and wait.deadline <= now:
                self.waits.remove(wait)
                self.resume(wait.intention)

    def interpreted(self) -> Agent:
        """The agent in the form that the interpreter runs; it takes this one's place."""
        spins = self.spin is not None
        take_up(self)
        agent = to_interpreter(self)
        self.run.replace(agent)
        if spins:
            self.run.wake(agent)
        return agent

    def doing(self) -> str:
        """Where the agent is, for error messages."""
        return "in a compiled plan"
