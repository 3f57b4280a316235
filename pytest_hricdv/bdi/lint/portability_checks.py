"""The check of names that are read here and by no Jason."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.lint.model import AgentModel, System
from pytest_hricdv.bdi.lint.model_builder import location_of

KEYWORDS = frozenset({"div", "elif", "else", "for", "if", "mod", "not", "while"})
"""Words that Jason reads as such wherever they stand: tried on its 1.4.2 and 3.3."""


class NotPortable:
    """Names that Jason's parser refuses: keywords, and names with letters beyond those of ASCII."""

    name = "not-portable"
    why = "It runs here only: no Jason reads this source."

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """One finding for each such name of a source."""
        reported: set[tuple[str, str]] = set()
        for agent in system.agents:
            for name, place in _names(agent):
                reason = _reason(name)
                if reason and (place.file, name) not in reported:
                    reported.add((place.file, name))
                    yield location_of(name, Location(place.file, 1, 1)), f"{name} is {reason}"


def _names(agent: AgentModel) -> Iterator[tuple[str, Location]]:
    """The names of beliefs, goals, actions and terms, and of variables, each with a place in their file."""
    start = Location(agent.file, 1, 1)
    literals = [*(mention.literal for mention in agent.goals), *(a.key[1] for a in agent.additions if a.key)]
    trees: list[tuple[object, Location]] = [(rule, rule.location) for rule in agent.rules]
    trees += [(plan, plan.location) for plan in agent.plans]
    for literal in literals:
        if isinstance(literal, str):
            yield literal, start
        else:
            trees.append((literal, start))
    for tree, place in trees:
        for part in parts_of(tree):
            if isinstance(part, Structure):
                yield part.functor, place
            elif isinstance(part, str):
                yield str(part), place


def _reason(name: str) -> str:
    if name in KEYWORDS:
        return "a keyword of Jason, and no name there"
    if not name.isascii() and not name.startswith("'"):
        return "not of ASCII letters only, as names are in Jason"
    return ""
