"""The world of the agents: what they perceive, and what their actions do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Self

from .errors import BdiError
from .parser import parse_literal
from .terms import SOURCE_PERCEPT, Structure

Perceived = tuple[tuple[str, tuple[Structure, ...]], ...]
"""Agents, and what they perceive, in the order added, with ``source(percept)``."""


class Environment:
    """The environment of a multi-agent system; override :meth:`execute` to give actions an effect.

    Example::

        class Lamp(Environment):
            def execute(self, agent: str, action: Structure) -> bool:
                if action.functor == "press":
                    self.add_percept(agent, "light(on)")
                    return True
                return False
    """

    _percepts: dict[str, dict[Structure, None]]
    _versions: dict[str, int]
    _changes: int

    def __new__(cls, *args: object, **options: object) -> Self:
        # Not in __init__: a user's subclass with an __init__ of its own need not call this one.
        self = super().__new__(cls)
        self._percepts = {}
        self._versions = {}
        self._changes = 0
        return self

    def execute(self, agent: str, action: Structure) -> bool:
        """Execute an external action.

        Args:
            agent: the name of the agent that acts.
            action: the action, a ground structure unless the agent left a variable free.

        Returns:
            Whether the action succeeded; if not, the goal it was done for fails. Here: always.
        """
        return True

    def add_percept(self, agent: str, literal: str | Structure) -> None:
        """Let an agent perceive a literal from its next reasoning cycle on.

        Raises:
            BdiError: the text is not a literal without variables.
        """
        percept = _percept(literal)
        percepts = self._percepts.setdefault(agent, {})
        if percept not in percepts:
            percepts[percept] = None
            self._note_change(agent)

    def remove_percept(self, agent: str, literal: str | Structure) -> bool:
        """Let an agent no longer perceive a literal.

        Returns:
            Whether it was perceived.

        Raises:
            BdiError: the text is not a literal without variables.
        """
        percepts = self._percepts.get(agent, {})
        percept = _percept(literal)
        if percept not in percepts:
            return False
        del percepts[percept]
        self._note_change(agent)
        return True

    def show(self, agent: str, literals: Iterable[str | Structure]) -> None:
        """Let an agent perceive exactly these literals.

        Raises:
            BdiError: a text is not a literal without variables.
        """
        self._percepts[agent] = dict.fromkeys(
            [_parsed_percept(literal) if type(literal) is str else _percept(literal) for literal in literals]
        )
        self._note_change(agent)

    def clear_percepts(self, agent: str) -> None:
        """Let an agent perceive nothing."""
        if self._percepts.get(agent):
            self._percepts[agent] = {}
            self._note_change(agent)

    def percepts(self, agent: str) -> tuple[Structure, ...]:
        """What an agent perceives now, in the order added, with ``source(percept)``."""
        return tuple(self._percepts.get(agent, ()))

    @property
    def perceived(self) -> Perceived:
        """What those agents perceive now that perceive anything."""
        return tuple([(agent, tuple(percepts)) for agent, percepts in self._percepts.items() if percepts])

    def _note_change(self, agent: str) -> None:
        self._versions[agent] = self._versions.get(agent, 0) + 1
        self._changes += 1

    @property
    def changes(self) -> int:
        """Grows whenever what any agent perceives changes."""
        return self._changes

    def version(self, agent: str) -> int:
        """Grows whenever what the agent perceives changes; 0 as long as it never has."""
        return self._versions.get(agent, 0)

    @property
    def versions(self) -> Mapping[str, int]:
        """:meth:`version` of every agent that has perceived anything."""
        return self._versions


def _percept(literal: str | Structure) -> Structure:
    if isinstance(literal, str):
        return _parsed_percept(literal)
    if not literal.ground:
        raise BdiError(f"a percept has no variables: {literal}")
    return literal.annotated((*literal.annots, SOURCE_PERCEPT))


@lru_cache(maxsize=4096)
def _parsed_percept(text: str) -> Structure:
    return _percept(parse_literal(text))
