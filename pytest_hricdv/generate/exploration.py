"""Exploration: what one run of the BDI agents with one belief subset shows."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

from .abstract import Plans


@dataclass(frozen=True)
class Exploration:
    """One run of the model.

    Args:
        beliefs: the subset, in the space's order.
        lines: the actor's external actions in the text format: the abstract test.
        plans: the coverage plans executed, by covered agent.
        sequence: every covered plan executed, in order, by covered agent.
        rounds: reasoning rounds of the run.
        ended: how it ended, in the words of the BDI engine.
    """

    beliefs: tuple[str, ...]
    lines: tuple[str, ...]
    plans: Mapping[str, frozenset[str]] = field(hash=False)
    sequence: Plans = field(default_factory=dict, hash=False)
    rounds: int = 0
    ended: str = ""


class Explores(Protocol):
    """Whatever runs belief subsets."""

    def explore(self, beliefs: Iterable[str]) -> Exploration:
        """Run one subset."""
