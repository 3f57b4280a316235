"""Events, intentions, and the plans on an intention's stack."""

from __future__ import annotations

import math
from collections import deque
from typing import Any

from pytest_hricdv.bdi.language.formulas import Formula
from pytest_hricdv.bdi.language.syntax import Body, For, Plan, Statement, Trigger, While
from pytest_hricdv.bdi.language.terms import Structure, Term
from pytest_hricdv.bdi.logic.substitution import Bindings

TICKS_PER_MS = 10
"""Ticks of the virtual clock: one a round, which is what Jason itself takes for one, within a factor of two."""
ROOT_OF_ADDED_GOALS = frozenset({"+!", "+?"})


def duration(wait_ms: float) -> float:
    """The ticks that a wait lasts: a whole number."""
    length = wait_ms * TICKS_PER_MS
    if length == math.inf or length <= 0.0:
        return max(0.0, length)
    # Rounded first: a tenth of a millisecond has no exact binary form.
    return length if length.is_integer() else math.ceil(round(length, 6))


NO_LITERAL = Structure("")


class Event:
    """Something an agent may react to; an internal one carries the intention that waits for it."""

    __slots__ = ("intention", "literal", "sign")

    def __init__(self, sign: str, literal: Structure, intention: Intention | None) -> None:
        self.sign = sign
        self.literal = literal
        self.intention = intention

    def __str__(self) -> str:
        return f"{self.sign}{self.literal}"


class Loop:
    """A ``for`` or ``while`` under way: the bindings to restore, and the solutions a ``for`` has left."""

    __slots__ = ("outer", "solutions", "statement")

    def __init__(self, statement: For | While, outer: Bindings, solutions: deque[Bindings]) -> None:
        self.statement = statement
        self.outer = outer
        self.solutions = solutions


class Frame:
    """An intended means: a plan that is being executed, its bindings, and how far it has come."""

    __slots__ = ("blocks", "body", "literal", "loop", "pc", "plan", "sign", "unifier")

    def __init__(self, plan: Plan, sign: str, literal: Structure, unifier: Bindings) -> None:
        self.plan = plan
        self.sign = sign
        self.literal = literal
        self.unifier = unifier
        self.body: Body = plan.body
        self.pc = 0
        self.blocks: list[tuple[Body, int, Loop | None]] = []
        """The bodies around the block being executed, innermost last, and where to go on in them."""
        self.loop: Loop | None = None
        """The loop whose statement is next, if it has been round at least once."""

    @property
    def finished(self) -> bool:
        """Whether the plan has no statement left."""
        return self.pc >= len(self.body)

    @property
    def statement(self) -> Statement:
        """The statement to be executed, or the one waited for."""
        return self.body[self.pc]

    @property
    def is_at_end(self) -> bool:
        """Whether nothing is left after the statement that it waits for."""
        blocks = all(loop is None and pc >= len(body) for body, pc, loop in self.blocks)
        return blocks and self.pc + 1 >= len(self.body)

    def enter(self, body: Body, loop: Loop | None) -> None:
        """Execute a block next; afterwards the loop's statement again, or else the statement after this one."""
        self.blocks.append((self.body, self.pc if loop else self.pc + 1, loop))
        self.body, self.pc = body, 0
        self.leave_blocks()

    def leave_blocks(self) -> None:
        """Return from finished blocks to what is around them."""
        while self.blocks and self.pc >= len(self.body):
            self.body, self.pc, loop = self.blocks.pop()
            if loop is not None:
                self.loop = loop
                return


class Intention:
    """A stack of plans, the one being executed last."""

    __slots__ = ("event", "frames", "number")

    def __init__(self, number: int) -> None:
        self.number = number
        self.frames: list[Frame] = []
        self.event = Event("", NO_LITERAL, self)
        """What it waits for, if it does: there is never more than one event that it waits for."""

    @property
    def atomic(self) -> bool:
        """Whether one of its plans must not be interleaved with other intentions."""
        return any(frame.plan.atomic for frame in self.frames)


class Wait:
    """An intention that waits for an event, for a condition, or for virtual time to pass.

    Args:
        intention: who waits; of a compiled agent, its activity.
        since: when it began, in ticks of the virtual clock.
        deadline: when it stops waiting, in ticks; None for never.
        trigger: the event it waits for.
        condition: the condition it waits for.
        elapsed: what to unify the time waited with, in ms; without it, running into the deadline while
            waiting for something is a failure.
    """

    __slots__ = ("condition", "deadline", "elapsed", "intention", "since", "trigger")

    def __init__(
        self,
        intention: Any,
        since: int,
        deadline: float | None = None,
        trigger: Trigger | None = None,
        condition: Formula | None = None,
        elapsed: Term | None = None,
    ) -> None:
        self.intention = intention
        self.since = since
        self.deadline = deadline
        self.trigger = trigger
        self.condition = condition
        self.elapsed = elapsed


class Message:
    """A speech act on its way.

    Args:
        sender: who sends it.
        force: what kind it is.
        content: what it is about.
        number: its own.
        reply_to: the number of the message that it answers, or empty.
        sourced: the content with its source, as the receiver gets it, if that is the same every time.
    """

    __slots__ = ("content", "force", "number", "reply_to", "sender", "sourced")

    def __init__(
        self,
        sender: str,
        force: str,
        content: Term,
        number: str,
        reply_to: str = "",
        sourced: Structure | None = None,
    ) -> None:
        self.sender = sender
        self.force = force
        self.content = content
        self.number = number
        self.reply_to = reply_to
        self.sourced = sourced


class Letter(Message):
    """A message that is the same every time: a ground literal, told or asked for by one agent of another.

    It has no number of its own: only plans of one's own for messages see that, and agents with such plans get
    no letters.

    Args:
        sender: who sends it.
        told: whether the literal is told, and not a goal to be achieved.
        literal: what it is about.
        annots: the literal's annotations as the receiver gets them, its source among them.
        place: the place of the receiver's table for it, -1 if it is a proposition; None if that is not known.
        slot: its arguments, or the name of a proposition.
        event: what a compiled receiver has to react to, if it does not believe the literal yet.
    """

    __slots__ = ("annots", "event", "literal", "place", "slot", "told")

    def __init__(
        self,
        sender: str,
        told: bool,
        literal: Structure,
        annots: tuple[Term, ...],
        place: int | None,
        slot: Any,
        event: Any,
    ) -> None:
        super().__init__(sender, "tell" if told else "achieve", literal, "")
        self.told = told
        self.literal = literal
        self.annots = annots
        self.place = place
        self.slot = slot
        self.event = event


class Question:
    """An intention that waits for answers, and the term they are unified with.

    Args:
        intention: who waits.
        force: the kind of question.
        answer: what the answer is unified with, or the list of answers when several agents were asked.
        deadline: when it stops waiting, in ticks of the virtual clock; None for never.
        asked: how many agents were asked if it was a list of them, else None.
    """

    __slots__ = ("answer", "answers", "asked", "deadline", "force", "intention")

    def __init__(
        self, intention: Intention, force: str, answer: Term, deadline: float | None, asked: int | None
    ) -> None:
        self.intention = intention
        self.force = force
        self.answer = answer
        self.deadline = deadline
        self.asked = asked
        self.answers: list[Term] = []
