"""The beliefs and goals that a project gives an agent in brackets after its name."""

from __future__ import annotations

from pytest_hricdv.bdi.language.parser import parse_program
from pytest_hricdv.bdi.language.project import AgentEntry
from pytest_hricdv.bdi.language.syntax import Program, Rule
from pytest_hricdv.bdi.language.terms import Structure


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
    """The parts between commas that are in no brackets and no string."""
    parts, depth, quoted = [""], 0, False
    for character in text:
        quoted ^= character == '"'
        depth += 0 if quoted else (character in "([") - (character in ")]")
        if character == "," and not depth and not quoted:
            parts.append("")
        else:
            parts[-1] += character
    return [part.strip() for part in parts if part.strip()]
