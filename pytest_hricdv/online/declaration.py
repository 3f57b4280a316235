"""What a testbench declares so that the agent of the person can live in the run."""

from __future__ import annotations

import math
from dataclasses import dataclass

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.run import TestbenchError

PATIENCE_S = 30.0
"""Chosen: longer than what a robot does for somebody takes, and much shorter than a run."""


class InteractiveAgentError(TestbenchError):
    """A declaration of the online agent is wrong, or its run cannot go on; the text says where and what to do."""


@dataclass(frozen=True)
class InteractiveAgent:
    """The agent that decides, during a run, what the person does.

    It perceives between its actions: whatever has happened when the person is free again. When it has nothing to do,
    the person waits as the testbench says (`Run.set_idle_handler`); when there is nothing to do after that, its actions
    are over.

    Args:
        agent: its name in the model; its external actions are commands.
        percepts: what it hears and perceives of the run.
        patience_s: of several people: how long one waits at most, with nothing to do, for something to happen, before
            its actions are over (s). While its agent waits for a time itself, it does not count.

    Raises:
        InteractiveAgentError: no name, `percepts` is no tuple of `PerceptMapping`, or a patience that is no time.
    """

    agent: str
    percepts: tuple[PerceptMapping, ...] = ()
    patience_s: float = PATIENCE_S

    def __post_init__(self) -> None:
        if not (isinstance(self.agent, str) and self.agent):
            raise InteractiveAgentError(
                f"InteractiveAgent: agent is {self.agent!r}; expected the name of an agent of the model"
            )
        if not (isinstance(self.percepts, tuple) and all(isinstance(heard, PerceptMapping) for heard in self.percepts)):
            raise InteractiveAgentError(
                f"InteractiveAgent: percepts is {self.percepts!r}; expected a tuple of PerceptMapping(...)"
            )
        is_number = isinstance(self.patience_s, int | float) and not isinstance(self.patience_s, bool)
        if not (is_number and 0.0 <= self.patience_s < math.inf):
            raise InteractiveAgentError(
                f"InteractiveAgent: patience_s is {self.patience_s!r}; expected a time in seconds, from 0 on"
            )
