"""`InteractiveAgent`: declares, in a testbench, an agent that decides during the run what a person does.

`role.load_role` checks it against the model and the vocabulary.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from pytest_hricdv.coupling.percept_mapping import PerceptMapping
from pytest_hricdv.run import TestbenchError


class InteractiveAgentError(TestbenchError):
    """A declaration of an interactive agent is wrong, or its run cannot continue."""


@dataclass(frozen=True)
class InteractiveAgent:
    """The agent that decides, during a run, what the person does.

    Between its actions, it perceives what has happened meanwhile. When it has nothing to do, the person waits as the
    testbench defines (`Run.set_idle_handler`); if there is still nothing to do afterwards, its actions are over.

    Args:
        agent: its name in the model; its external actions are commands.
        idle_timeout_s: with several people: a person who has had nothing to do for this time (simulated s) performs no
            more actions. Waits of the agent itself (`.wait`) do not count.

    Raises:
        InteractiveAgentError: no name, `percepts` is not a tuple of `PerceptMapping`, or `idle_timeout_s` is not a
            time.
    """

    agent: str
    percepts: tuple[PerceptMapping, ...] = ()
    idle_timeout_s: float = 30.0

    def __post_init__(self) -> None:
        if not (isinstance(self.agent, str) and self.agent):
            raise InteractiveAgentError(
                f"InteractiveAgent: agent is {self.agent!r}; expected the name of an agent of the model"
            )
        if not (
            isinstance(self.percepts, tuple) and all(isinstance(percept, PerceptMapping) for percept in self.percepts)
        ):
            raise InteractiveAgentError(
                f"InteractiveAgent: percepts is {self.percepts!r}; expected a tuple of PerceptMapping(...)"
            )
        is_number = isinstance(self.idle_timeout_s, int | float) and not isinstance(self.idle_timeout_s, bool)
        if not (is_number and 0.0 <= self.idle_timeout_s < math.inf):
            raise InteractiveAgentError(
                f"InteractiveAgent: idle_timeout_s is {self.idle_timeout_s!r}; expected a time in seconds, from 0 on"
            )
