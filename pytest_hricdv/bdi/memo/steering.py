"""An agent that steers others: what it forwards to them, and where runs begin."""

from __future__ import annotations

from pytest_hricdv.bdi.language.terms import SOURCE_PERCEPT, Structure

from ..environment import percept_of
from .diagram import Node
from .forwarding import Forwarding


class Atoms(dict[str | Structure, str]):
    """The atoms that percepts ``f(b)``, as they were given, are about; empty for what is not forwarded like the others.

    Args:
        forwarding: how they are forwarded.
    """

    def __init__(self, forwarding: Forwarding) -> None:
        super().__init__()
        self._forwarding = forwarding

    def __missing__(self, given: str | Structure) -> str:
        self[given] = atom = self._atom(percept_of(given))
        return atom

    def _atom(self, percept: Structure) -> str:
        if percept.key != self._forwarding.key:
            return ""
        (about,) = percept.args
        if percept.annots != (SOURCE_PERCEPT,) or not isinstance(about, Structure):
            return ""
        plain = not (about.args or about.annots or about.negated)
        return about.functor if plain and about.functor not in self._forwarding.special else ""


class Steering:
    """An agent that forwards atoms.

    Args:
        forwarding: how it does.
    """

    def __init__(self, forwarding: Forwarding) -> None:
        self.forwarding = forwarding
        self.atoms = Atoms(forwarding)
        self.starts: dict[tuple[int, int], Node] = {}
        """Where runs begin, by the number of their atoms and their seed."""

    def start(self, atoms: int, seed: int) -> Node:
        """Where a run with so many atoms begins."""
        start = self.starts.get((atoms, seed))
        if start is None:
            start = self.starts[atoms, seed] = Node()
        return start
