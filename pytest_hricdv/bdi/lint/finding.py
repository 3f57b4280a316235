"""The protocol of a check, and its findings."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from pytest_hricdv.bdi.language.errors import BdiSyntaxError, Location
from pytest_hricdv.bdi.lint.model import System


@dataclass(frozen=True, slots=True)
class Finding:
    """A probable mistake in a model.

    Args:
        check: the name of the check that found it.
        location: its place in the source.
        message: what is wrong.
        why: its consequence, in one sentence.
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
    """Searches models for one kind of mistake."""

    @property
    def name(self) -> str:
        """The name that findings show, and that remarks ignore them by."""

    @property
    def why(self) -> str:
        """The consequence of such a mistake, in one sentence."""

    def findings(self, system: System) -> Iterator[tuple[Location, str]]:
        """The place and the message of each mistake."""
