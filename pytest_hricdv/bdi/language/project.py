"""A multi-agent system as its project file describes it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from pytest_hricdv.bdi.language.errors import Location
from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.syntax import Program, Rule
from pytest_hricdv.bdi.language.terms import Structure


@dataclass(frozen=True, slots=True)
class AgentEntry:
    """An agent of a project.

    Args:
        name: its name, unique in the project.
        source: its AgentSpeak file.
        location: where the project names it.
        beliefs: beliefs from the option ``beliefs``, as AgentSpeak text.
        goals: goals from the option ``goals``, as AgentSpeak text.
    """

    name: str
    source: Path
    location: Location
    beliefs: str = ""
    goals: str = ""


@dataclass(frozen=True, slots=True)
class Project:
    """A multi-agent system.

    Args:
        name: its name.
        agents: its agents, in the order of their cycles.
        text: the text of the project file.
        warnings: what in it has no effect here, each once, with its place.
        environment: the Java class that it names as its environment, or empty.
    """

    name: str
    agents: tuple[AgentEntry, ...]
    text: str
    warnings: tuple[str, ...] = ()
    environment: str = ""


def option_beliefs(entry: AgentEntry) -> tuple[Structure | Rule, ...]:
    """The beliefs of the option ``beliefs``, in the order written.

    Raises:
        BdiSyntaxError: the text is not a list of beliefs.
    """
    return _read(entry, entry.beliefs, "beliefs", "").beliefs


def option_goals(entry: AgentEntry) -> tuple[Structure, ...]:
    """The goals of the option ``goals``, in the order written.

    Raises:
        BdiSyntaxError: the text is not a list of goals.
    """
    return _read(entry, entry.goals, "goals", "!").goals


def _read(entry: AgentEntry, text: str, what: str, sign: str) -> Program:
    source = " ".join(f"{sign}{part}." for part in _parts(text.strip().removesuffix(".")))
    return parse_program(source, f"{entry.location}: option {what} of agent {entry.name}")


def _parts(text: str) -> list[str]:
    """The parts between the commas that are outside brackets and strings."""
    parts, depth, quoted = [""], 0, False
    for character in text:
        quoted ^= character == '"'
        depth += 0 if quoted else (character in "([") - (character in ")]")
        if character == "," and not depth and not quoted:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]
