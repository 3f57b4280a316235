"""The environment of the agents: what they perceive, and what their actions do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from typing import Self

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

Perceived = tuple[str | int | Structure, ...]
"""Agents, each followed by the number of its percepts, and by these, as they were given."""


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

    _shown: dict[str, tuple[str | Structure, ...]]
    _percepts: dict[str, dict[Structure, None]]
    _versions: dict[str, int]
    _changes: int

    def __new__(cls, *args: object, **options: object) -> Self:
        # Not in __init__: the __init__ of a subclass need not call this one.
        self = super().__new__(cls)
        self._shown = {}
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
        percept = percept_of(literal)
        percepts = self._percepts_of(agent)
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
        percepts = self._percepts_of(agent)
        percept = percept_of(literal)
        if percept not in percepts:
            return False
        del percepts[percept]
        self._note_change(agent)
        return True

    def show(self, agent: str, literals: Iterable[str | Structure]) -> None:
        """Let an agent perceive exactly these literals.

        Raises:
            BdiError: a text is not a literal without variables, or a single literal is given instead of a list.
        """
        if isinstance(literals, (str, Structure)):
            raise BdiError(f"the percepts of {agent} must be a list, even if there is only one: [{str(literals)!r}]")
        shown = tuple(literals)
        for literal in shown:
            percept_of(literal)  # For its errors; the parsed literals are cached.
        self._shown[agent] = shown
        self._note_change(agent)

    def clear_percepts(self, agent: str) -> None:
        """Let an agent perceive nothing."""
        if self._percepts_of(agent):
            self.show(agent, ())

    def percepts(self, agent: str) -> tuple[Structure, ...]:
        """What an agent perceives now, in the order added, with ``source(percept)``."""
        return tuple(self._percepts_of(agent))

    @property
    def perceived(self) -> Perceived:
        """What agents perceive now, for those that perceive anything."""
        found: list[str | int | Structure] = []
        for agent in self._versions:
            shown = self._shown.get(agent)
            percepts = self._percepts.get(agent) if shown is None else shown
            if percepts:
                found += (agent, len(percepts), *percepts)
        return tuple(found)

    def _percepts_of(self, agent: str) -> dict[Structure, None]:
        # The percepts shown are parsed only when they are needed: the memo does not need them.
        shown = self._shown.pop(agent, None)
        if shown is not None:
            self._percepts[agent] = dict.fromkeys(map(percept_of, shown))
        return self._percepts.setdefault(agent, {})

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


@lru_cache(maxsize=4096)
def percept_of(literal: str | Structure) -> Structure:
    """A literal as it is perceived, with ``source(percept)``.

    Raises:
        BdiError: it is not a literal without variables.
    """
    if isinstance(literal, str):
        literal = parse_literal(literal)
    if not isinstance(literal, Structure):
        raise BdiError(f"a percept is a text or a structure, not {literal!r} ({type(literal).__name__})")
    if not literal.ground:
        raise BdiError(f"a percept has no variables: {literal}")
    return literal.with_annotations((*literal.annots, SOURCE_PERCEPT))
