"""Options of the closing loop."""

from __future__ import annotations

from dataclasses import dataclass

NAME = "closure"
"""The method, and its suite."""


@dataclass(frozen=True)
class ClosingOptions:
    """Whether there is a closing loop, and its budget.

    Args:
        asked: there is one.
        given: it closes what these leave open, instead of everything.
        runs: it ends after so many runs. At ten seeds all loops of the table closed after 240 to 376 (docs/closure.md).
        search: so many runs search for violations after it, of those that are left; None: a tenth of the runs that the
            loop made, and at least a generation. Chosen: a loop that closes costs little more, and a fault that one run
            in twenty shows near to what is known is met with five times out of six in thirty.
        seconds: it ends after this time (s), so that a session is not endless: its result then depends on the machine.
            The same loops took up to 3.1 minutes on two cores; chosen: three times this.
        without: the names of ways that are left out.
    """

    asked: bool = False
    given: bool = False
    runs: int = 400
    search: int | None = None
    seconds: int = 600
    without: tuple[str, ...] = ()
