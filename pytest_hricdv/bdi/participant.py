"""What the scheduler and other agents know of an agent, whether it is interpreted or compiled."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import deque
from typing import TYPE_CHECKING

from .intentions import Message, Question, Wait
from .spinning import Spin

if TYPE_CHECKING:
    from .agent import Agent
    from .scheduler import Run


class Participant(ABC):
    """An agent in a run.

    Args:
        name: its name.
        run: the run it takes part in.
        takes_letters: whether messages to it may be letters.
    """

    __slots__ = ("awake", "executed", "mailbox", "name", "place", "questions", "run", "spin", "takes_letters", "waits")

    def __init__(self, name: str, run: Run, takes_letters: bool) -> None:
        self.name = name
        self.run = run
        self.takes_letters = takes_letters
        self.awake = True
        """Whether it may have something to do; an agent that has not is left alone by the scheduler."""
        self.spin: Spin | None = None
        """What it does all the time, if it is left alone with that."""
        self.place = 0
        """Its place in the order in which agents act."""
        self.mailbox: deque[Message] = deque()
        self.waits: list[Wait] = []
        self.questions: dict[str, Question] = {}
        self.executed: list[str] = []
        """The labels of the plans selected as intended means, in order."""

    @abstractmethod
    def has_work(self) -> bool:
        """Whether a reasoning cycle would do anything."""

    @abstractmethod
    def has_news(self) -> bool:
        """Whether a cycle would do anything besides reacting to an event."""

    @abstractmethod
    def cycle(self) -> None:
        """Do one reasoning cycle."""

    @abstractmethod
    def work(self, rounds: int) -> int:
        """Do cycles while every other agent is idle, at most so many; the number done, at least one."""

    @abstractmethod
    def end_waits(self, now: int) -> None:
        """Let the intentions go on, or fail, whose wait is over at a tick of the virtual clock."""

    @abstractmethod
    def interpreted(self) -> Agent:
        """The agent in the form that the interpreter runs; it takes this one's place."""

    @abstractmethod
    def doing(self) -> str:
        """Where the agent is, for error messages."""
