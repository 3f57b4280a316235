"""What there is to decide in a run with an online agent, and who decides it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random
from typing import Protocol

from pytest_hricdv.generate.beliefs import START
from pytest_hricdv.generate.rng import make_rng

GOAL = "goal"
ACT = "act"
NONE = ""
"""The option to choose none of the beliefs of a group, or to post no goal."""

GOAL_WEIGHT = 0.02
"""The weight of a goal that nothing is known about; that of none is 1. So about one person in two follows the model."""


@dataclass(frozen=True)
class Situation:
    """Where a run stands.

    Args:
        time_s: simulated time.
        state: the state that the code under test has reported last; empty where there is none.
        taken: the commands so far.
    """

    time_s: float
    state: str
    taken: tuple[str, ...]


@dataclass(frozen=True)
class Decision:
    """Something to decide.

    Args:
        about: "start", the name of a group of beliefs, "goal", or "act".
        options: at least one; NONE where it may be left.
        situation: where the run stands.
    """

    about: str
    options: tuple[str, ...]
    situation: Situation


class Chooser(Protocol):
    """Decides what the model leaves open."""

    def choose(self, decision: Decision) -> str:
        """One of the options."""


Weights = Mapping[tuple[str, str, str], float]
"""(state, what is decided, option) -> how much more probable than an option of weight 1. The state "" is any."""


class WeightedChooser:
    """Chooses at random by weights.

    Options that have none have weight 1; goals have GOAL_WEIGHT, and of several acts the agent does the one that it
    was ready for first.

    Args:
        seed: of its random stream.
        weights: of options; those for the state of the code come before those for any state.
    """

    def __init__(self, seed: int, weights: Weights | None = None) -> None:
        self._rng: Random = make_rng("online", seed)
        self._weights = dict(weights or {})

    def choose(self, decision: Decision) -> str:
        """See `Chooser`."""
        weights = [self._weight(decision, option) for option in decision.options]
        left = self._rng.random() * sum(weights)
        for option, weight in zip(decision.options, weights, strict=True):
            left -= weight
            if left < 0:
                return option
        return decision.options[0]

    def _weight(self, decision: Decision, option: str) -> float:
        for state in (decision.situation.state, ""):
            if (weight := self._weights.get((state, decision.about, option))) is not None:
                return weight
        if decision.about == ACT:
            return float(option == decision.options[0])
        return GOAL_WEIGHT if decision.about == GOAL and option != NONE else 1.0


__all__ = ["ACT", "GOAL", "NONE", "START", "Chooser", "Decision", "Situation", "WeightedChooser", "Weights"]
