"""Choosers: which alternatives an interactive agent has in a run, and who chooses among them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from random import Random
from typing import NamedTuple, Protocol

from pytest_hricdv.generate.rng import make_rng

GOAL = "goal"
DISTURBANCE = "disturbance"
ACT = "act"
NONE = ""
"""The option to choose none of the beliefs of a group, to post no goal, or not to disturb."""

RARE_WEIGHT = 0.01
"""Weight of a goal or disturbance without experience; that of none is 1. With the 27 disturbances of the case study, an
agent without experience disturbs at one decision in five."""


@dataclass(frozen=True)
class Situation:
    """Where a run stands.

    Args:
        time_s: simulated time.
        state: the state that the code under test has reported last; empty if there is none.
        interaction: its number, from 1; 0 before the first one, and where nothing tells interactions apart.
        taken: the commands so far, disturbances among them.
    """

    time_s: float
    state: str
    interaction: int
    taken: tuple[str, ...]


@dataclass(frozen=True)
class ChoicePoint:
    """Something to decide.

    Args:
        about: "start", the name of a group of beliefs, "goal", "disturbance", or "act".
        options: at least one; NONE where it may be left.
        situation: where the run stands.
    """

    about: str
    options: tuple[str, ...]
    situation: Situation


class Choice(NamedTuple):
    """A choice: after how many commands, in which state of code and interaction, about which subject, and its value."""

    taken: int
    state: str
    interaction: int
    about: str
    option: str


class Chooser(Protocol):
    """Decides what the model leaves open."""

    def choose(self, decision: ChoicePoint) -> str:
        """Choose one of the options."""


ANY_INTERACTION = -1
ANY_STATE = ""

Weight = tuple[str, int, str, str, float]
"""State of the code, interaction, what is decided, option, and how much likelier it is than an option of weight 1."""


class WeightedChooser:
    """Chooses at random by weights.

    Options that have none have weight 1; goals and disturbances have RARE_WEIGHT, and of several acts the agent does
    the one that it was ready for first.

    Args:
        seed: of its random stream.
        weights: of options; those for state and interaction come before those for the interaction, and these before
            those for any.
    """

    def __init__(self, seed: int, weights: Iterable[Weight] = ()) -> None:
        self._rng: Random = make_rng("online", seed)
        self._weights = {tuple(key): weight for *key, weight in weights}

    def choose(self, decision: ChoicePoint) -> str:
        """See `Chooser`."""
        weights = [self._weight(decision, option) for option in decision.options]
        left = self._rng.random() * sum(weights)
        for option, weight in zip(decision.options, weights, strict=True):
            left -= weight
            if left < 0:
                return option
        return decision.options[0]  # all weights are 0, or rounding left a little over

    def _weight(self, decision: ChoicePoint, option: str) -> float:
        situation = decision.situation
        number = situation.interaction
        for place in ((situation.state, number), (ANY_STATE, number), (ANY_STATE, ANY_INTERACTION)):
            if (weight := self._weights.get((*place, decision.about, option))) is not None:
                return weight
        if decision.about == ACT:
            return float(option == decision.options[0])
        return RARE_WEIGHT if decision.about in (GOAL, DISTURBANCE) and option != NONE else 1.0
