"""What a test may do from a decision point on, instead of what it did: other actions, a disturbance, other values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from random import Random

from pytest_hricdv.disturbance import PREFIX
from pytest_hricdv.generate.concrete import ConcreteAction, ConcreteTest
from pytest_hricdv.generate.rng import pick
from pytest_hricdv.generate.sampler import Sampler

Actions = tuple[ConcreteAction, ...]
Ranges = Mapping[str, Mapping[str, Sampler]]
"""Command line -> the ranges of its parameters."""


@dataclass(frozen=True)
class Continuation:
    """The rest of a test.

    Args:
        actions: from the decision point on.
        what: it is, in a few words that complete "up to command 3, then ...".
        commanded: it has the same commands as the rest that it replaces, but for disturbances.
    """

    actions: Actions
    what: str
    commanded: bool = True


def disturbed(rest: Actions, ranges: Ranges, rng: Random) -> Continuation | None:
    """The same with a disturbance now; None where the testbench has none."""
    names = [command for command in ranges if command.startswith(PREFIX)]
    if not names:
        return None
    name = pick(rng, names)
    return Continuation((ConcreteAction(name, _sampled(ranges[name], rng)), *rest), name)


def redrawn(rest: Actions, ranges: Ranges, rng: Random) -> Continuation | None:
    """The same with all parameters drawn anew; None where there are none."""
    if not any(action.parameters for action in rest):
        return None
    drawn = (ConcreteAction(action.command, _sampled(ranges[action.command], rng)) for action in rest)
    return Continuation(tuple(drawn), "other values")


def exchanged(other: ConcreteTest, taken: int) -> Continuation:
    """The rest of another test, after so many actions of it."""
    return Continuation(other.actions[taken:], f"the rest of {other.id}", commanded=False)


def _sampled(samplers: Mapping[str, Sampler], rng: Random) -> dict[str, float]:
    return {name: sampler.sample(rng) for name, sampler in samplers.items()}
