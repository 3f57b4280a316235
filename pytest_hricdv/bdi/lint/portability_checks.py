"""Lint's checks of portability, which `lint` runs: what Jason refuses, and what only Jason supports."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv.bdi.actions import describe_missing, foreign_calls
from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.syntax_tree import parts_of
from pytest_hricdv.bdi.language.terms import Structure
from pytest_hricdv.bdi.lint.model import AgentModel, Problem, System, check
from pytest_hricdv.bdi.lint.model_builder import encoding_fault, files_of, location_of

KEYWORDS = frozenset({"div", "elif", "else", "for", "if", "mod", "not", "while"})
"""Reserved words of Jason, checked with 1.4.2 and 3.3."""


@check("not-portable", "It runs only here: Jason cannot parse this source.")
def find_unportable_names(system: System) -> Iterator[Problem]:
    """Names that Jason's parser refuses: keywords, and names with non-ASCII letters."""
    reported: set[tuple[str, str]] = set()
    for agent in system.agents:
        for name, place in _names(agent):
            reason = _reason(name)
            if reason and (place.file, name) not in reported:
                reported.add((place.file, name))
                yield location_of(name, Location(place.file, 1, 1)), f"{name} is {reason}"


@check("foreign-action", "A run ends where it is called.")
def find_foreign_actions(system: System) -> Iterator[Problem]:
    """Calls of internal actions that are written in Java, or that exist in Jason only."""
    for agent in system.agents:
        for call in foreign_calls((agent.rules, agent.plans)):
            yield call.location, describe_missing(call).removeprefix(f"{call.location}: ")


@check(
    "not-utf8",
    "It is read as Latin-1: what is printed may have other letters than its author wrote, here and in Jason.",
)
def find_other_encodings(system: System) -> Iterator[Problem]:
    """Sources that are not UTF-8."""
    for file in dict.fromkeys(file for agent in system.agents for file in files_of(agent)):
        place, _, message = encoding_fault(file).partition(": ")
        if message:
            line, column = place.rsplit(":", 2)[1:]
            yield Location(file, int(line), int(column)), message


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
        return "a keyword of Jason, which cannot be a name there"
    if not name.isascii() and not name.startswith("'"):
        return "not ASCII, as names have to be in Jason"
    return ""
