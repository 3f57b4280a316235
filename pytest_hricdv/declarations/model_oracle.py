"""`ModelOracle` declares the model of a testbench as an oracle, with an `ActionMapping` for each act of an agent.

A mapping says by which event of a run an act is observed. The feature `oracle` compares runs with the agent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from pytest_hricdv._base.message import InputError
from pytest_hricdv.coupling.percept_mapping import PerceptMapping

MODEL = "MODEL"
"""The id of the oracle's verdict, among those of requirements."""


class ModelOracleError(InputError):
    """A declaration of conformance is wrong; the message says which part, what was expected, and what to do."""


@dataclass(frozen=True)
class ActionMapping:
    """An act of the agent, and the event by which the code under test is observed to do it.

    Args:
        act: the label of a plan, which the agent begins (`@p3`); the content of a message that it sends; or an external
            action. Variables as in `PerceptMapping`: the argument has to be the event's value.
        when: the event, in the language of requirements: `on(state) & state == "Move_hand"`.
        within_s: the earliest and the latest time (s) after the agent is ready for the act.
        fails: for an external action, the event by which it fails; the agent's plan fails then, too.

    Raises:
        ModelOracleError: `within_s` is not a pair of ascending times.
    """

    act: str
    when: str
    within_s: tuple[float, float] = (0.0, 1.0)
    fails: str = ""

    def __post_init__(self) -> None:
        window = self.within_s
        if not (isinstance(window, tuple) and len(window) == 2 and 0 <= window[0] <= window[1] < math.inf):
            raise ModelOracleError(
                f"{self.owner}: within_s is {window!r}; expected the earliest and the latest time in s, (0, 10)"
            )

    @property
    def owner(self) -> str:
        """Its name in error messages."""
        return f"ActionMapping({self.act!r})"


@dataclass(frozen=True)
class ModelOracle:
    """The agent that says what the code under test should do, and what corresponds to what.

    Each act of the agent that corresponds to an event has to be observed within its window. An event that corresponds
    to some act, and is not due now, is a deviation. All else is left open.

    Args:
        percepts: what it hears and perceives of the run.
        actions: what it does, and how that is observed.
        limits: durations that it believes in a run instead of those in its source: belief -> seconds, or the name of
            a parameter of the run: `{"patience": 15, "patience_for_sensors": "timeout_s"}`. The agent believes them in
            whole milliseconds, for its clock (`.wait`) goes with the run: a millisecond is one of simulated time.
        tolerance_s: how much later (s) than observed the agent may become ready for an act, or perceive something.
        until: an event by which a run leaves what the model knows, such as somebody who holds the robot's arm; the run
            is followed up to there. Empty if there is none.

    Raises:
        ModelOracleError: nothing that it does, or a number that makes no sense.
    """

    agent: str
    actions: tuple[ActionMapping, ...]
    percepts: tuple[PerceptMapping, ...] = ()
    limits: Mapping[str, float | str] = field(default_factory=dict, hash=False)
    tolerance_s: float = 0.5
    until: str = ""

    def __post_init__(self) -> None:
        for name, kind in (("actions", ActionMapping), ("percepts", PerceptMapping)):
            declared = getattr(self, name)
            if not (isinstance(declared, tuple) and all(isinstance(member, kind) for member in declared)):
                raise ModelOracleError(f"ModelOracle: {name} is {declared!r}; expected a tuple of {kind.__name__}(...)")
        if not self.actions:
            raise ModelOracleError("ModelOracle: actions is empty; expected at least one act that can be observed")
        if not (isinstance(self.tolerance_s, int | float) and 0 <= self.tolerance_s < math.inf):
            raise ModelOracleError(f"ModelOracle: tolerance_s is {self.tolerance_s!r}; expected a time in seconds")
