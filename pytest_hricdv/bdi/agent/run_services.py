"""What agents need from the run that they take part in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

from pytest_hricdv.bdi.agent.intentions import Message
from pytest_hricdv.bdi.language.syntax import ExternalAction, Plan
from pytest_hricdv.bdi.language.terms import Structure, Variable


class RunServices(Protocol):
    """What a run offers to its agents."""

    progress: int
    """Grows with everything that another agent, or the user, could notice, or that the agent could remember."""

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

    def percept_versions(self, agent: str) -> Mapping[str, int]:
        """Where an agent finds under its name a number that grows with every change of its percepts."""

    def percepts(self, agent: str) -> tuple[Structure, ...]:
        """What an agent perceives now."""

    def deliver(self, receiver: str, message: Message) -> None:
        """Put a message into its receiver's mailbox."""

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

    def next_message_number(self) -> str:
        """A number for a message."""

    def note_achieved(self, agent: str, goal: Structure) -> None:
        """A plan for a goal has finished."""

    def stop(self) -> None:
        """End the run after this round."""
