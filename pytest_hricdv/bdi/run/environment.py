"""The environment of the agents: their percepts, and the effects of their actions."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import lru_cache
from typing import Self

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

Perceived = tuple[str | int | Structure, ...]
"""Agents, each followed by the number of its percepts, and by these, as they were given."""


class Percepts:
    """The percepts of an agent."""

    __slots__ = ("_literals", "_shown", "version")

    def __init__(self) -> None:
        self.version = 0
        """Grows with every change."""
        self._literals: dict[Structure, None] = {}
        self._shown: tuple[str | Structure, ...] | None = None
        """The percepts as they were given, until they are parsed: the memo does not need the parsed form."""

    def as_given(self) -> Collection[str | Structure]:
        """The percepts as they were given."""
        return self._literals if self._shown is None else self._shown

    def literals(self) -> dict[Structure, None]:
        """The percepts in the order added, with ``source(percept)``."""
        if self._shown is not None:
            self._literals, self._shown = dict.fromkeys(map(percept_of, self._shown)), None
        return self._literals

    def show(self, literals: tuple[str | Structure, ...]) -> None:
        """Replace all."""
        self._shown = literals
        self.version += 1


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

    changes: int
    """Grows whenever what any agent perceives changes."""
    _percepts: dict[str, Percepts]

    def __new__(cls, *args: object, **options: object) -> Self:
        # Not in __init__: the __init__ of a subclass need not call this one.
        self = super().__new__(cls)
        self.changes = 0
        self._percepts = {}
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
        percepts = self.percepts_of(agent)
        if percept not in percepts.literals():
            percepts.literals()[percept] = None
            percepts.version += 1
            self.changes += 1

    def remove_percept(self, agent: str, literal: str | Structure) -> bool:
        """Let an agent no longer perceive a literal.

        Returns:
            Whether it was perceived.

        Raises:
            BdiError: the text is not a literal without variables.
        """
        percept = percept_of(literal)
        percepts = self.percepts_of(agent)
        if percept not in percepts.literals():
            return False
        del percepts.literals()[percept]
        percepts.version += 1
        self.changes += 1
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
        self.percepts_of(agent).show(shown)
        self.changes += 1

    def clear_percepts(self, agent: str) -> None:
        """Let an agent perceive nothing."""
        if self.percepts_of(agent).as_given():
            self.show(agent, ())

    def percepts_of(self, agent: str) -> Percepts:
        """The percepts of an agent, now and later."""
        percepts = self._percepts.get(agent)
        if percepts is None:
            percepts = self._percepts[agent] = Percepts()
        return percepts

    @property
    def percepts_now(self) -> Perceived:
        """The present percepts of all agents that have any."""
        perceived: list[str | int | Structure] = []
        for agent, percepts in self._percepts.items():
            literals = percepts.as_given()
            if literals:
                perceived += (agent, len(literals), *literals)
        return tuple(perceived)


class NoEnvironment(Environment):
    """Nobody implements the actions: each fails, as in Jason."""

    def execute(self, agent: str, action: Structure) -> bool:
        """Fail an external action."""
        return False


@lru_cache(maxsize=4096)  # far more than the percepts of a model, which are shown again in each of thousands of runs
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
