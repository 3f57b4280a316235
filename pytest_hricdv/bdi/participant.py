"""What the scheduler and other agents know of an agent, whether it is interpreted or compiled."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Protocol

from .intentions import Message, Question, Wait
from .spinning import Spin

if TYPE_CHECKING:
    from .agent import Agent
    from .scheduler import Run


class Participant(Protocol):
    """An agent in a run."""

    name: str
    run: Run
    takes_letters: bool
    """Whether messages to it may be letters."""
    awake: bool
    """Whether it may have something to do; an agent that has not is left alone by the scheduler."""
    spin: Spin | None
    """What it does all the time, if it is left alone with that."""
    place: int
    """Its place in the order in which agents act."""
    mailbox: deque[Message]
    waits: list[Wait]
    questions: dict[str, Question]
    executed: list[str]
    """The labels of the plans selected as intended means, in order."""

    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""

    def has_news(self) -> bool:
        """Whether a cycle would do anything besides reacting to an event."""

    def cycle(self) -> None:
        """Do one reasoning cycle."""

    def work(self, rounds: int) -> int:
        """Do cycles while every other agent is idle, at most so many; the number done, at least one."""

    def end_waits(self, now: int) -> None:
        """Let the intentions go on, or fail, whose wait is over at a tick of the virtual clock."""

    def interpreted(self) -> Agent:
        """The agent in the form that the interpreter runs; it takes this one's place."""

    def doing(self) -> str:
        """Where the agent is, for error messages."""
