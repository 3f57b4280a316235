"""What a check finds, and what a check is."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from pytest_hricdv.bdi.language.errors import BdiSyntaxError, Location

from .model import System


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing that looks wrong.

    Args:
        check: the name of the check that found it.
        location: where.
        message: what.
        why: one sentence on why it matters.
        source: the text of the file, which supplies the line to show.
    """

    check: str
    location: Location
    message: str
    why: str
    source: str

    def __str__(self) -> str:
        shown = BdiSyntaxError.at(f"{self.check}: {self.message}", self.location, self.source)
        return f"{shown}\n    {self.why}"


class Check(Protocol):
    """One kind of thing to look for.

    ``name`` is what findings are called and ignored by, ``why`` says in one sentence why they matter.
    """

    @property
    def name(self) -> str:
        """What findings are called and ignored by."""

    @property
    def why(self) -> str:
        """One sentence on why a finding matters."""

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """Where something looks wrong, and what."""
