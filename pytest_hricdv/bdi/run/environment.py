"""`Environment`: the surroundings of agents, which hold their percepts and execute their actions.

`MultiAgentSystem` passes it to its runs; a subclass gives actions an effect. In `NoEnvironment` every action fails.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from functools import lru_cache
from typing import Self

from pytest_hricdv.bdi.language.errors import BdiError
from pytest_hricdv.bdi.language.parser import parse_literal
from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

PerceptSnapshot = tuple[str | int | Structure, ...]
"""The percepts of all agents, flat and hashable: each agent's name, the number of its percepts, and these, unparsed."""


class Percepts:
    """The percepts of an agent."""

    __slots__ = ("_literals", "_unparsed", "version")

    def __init__(self) -> None:
        self.version = 0
        """Grows with every change."""
        self._literals: dict[Structure, None] = {}
        self._unparsed: tuple[str | Structure, ...] | None = None
        """The unparsed percepts; None once they are parsed, which the memo does not need."""

    def sources(self) -> Collection[str | Structure]:
        """The percepts, unparsed unless they had to be parsed."""
        return self._literals if self._unparsed is None else self._unparsed

    def literals(self) -> dict[Structure, None]:
        """The parsed percepts with ``source(percept)``, in the order in which they were added."""
        if self._unparsed is not None:
            self._literals, self._unparsed = dict.fromkeys(map(percept_of, self._unparsed)), None
        return self._literals

    def show(self, literals: tuple[str | Structure, ...]) -> None:
        """Replace all percepts."""
        self._unparsed = literals
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
            Whether the action succeeded; if not, its goal fails. This class returns True.
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

    def percepts_of(self, agent: str) -> Percepts:
        """The percepts of an agent, as an object that follows their changes."""
        percepts = self._percepts.get(agent)
        if percepts is None:
            percepts = self._percepts[agent] = Percepts()
        return percepts

    @property
    def percept_snapshot(self) -> PerceptSnapshot:
        """A snapshot of all percepts, for agents that have any."""
        flat: list[str | int | Structure] = []
        for agent, percepts in self._percepts.items():
            literals = percepts.sources()
            if literals:
                flat += (agent, len(literals), *literals)
        return tuple(flat)


class NoEnvironment(Environment):
    """An environment without actions: each fails, as in Jason."""

    def execute(self, agent: str, action: Structure) -> bool:
        """Fail an external action."""
        return False


@lru_cache(maxsize=4096)  # far more than a model has percepts; each of thousands of runs shows the same ones
def percept_of(literal: str | Structure) -> Structure:
    """Make a percept of a literal: parse it and add ``source(percept)``.

    Raises:
        BdiError: it is not a literal without variables.
    """
    if isinstance(literal, str):
        literal = parse_literal(literal)
    if not isinstance(literal, Structure):
        raise BdiError(f"a percept is a string or a structure, not {literal!r} ({type(literal).__name__})")
    if not literal.ground:
        raise BdiError(f"a percept has no variables: {literal}")
    return literal.with_annotations((*literal.annots, SOURCE_PERCEPT))
