"""Warm starts: what learning begins with instead of nothing (the paper's future work)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

#: State -> belief added next -> value.
QTable = dict[str, dict[str, float]]


@dataclass(frozen=True)
class WarmStart:
    """A table, or belief sets, to begin with.

    Args:
        name: what people call it.
        digest: of all that is in it; learning is a function of this, too.
        q: a table learned before; empty for none.
        maxima: the most plans covered in one run so far, by agent.
        subsets: belief sets to go through first, each with its start belief in front and at least one other.
    """

    name: str = ""
    digest: str = ""
    q: QTable = field(default_factory=dict, hash=False)
    maxima: Mapping[str, int] = field(default_factory=dict, hash=False)
    subsets: tuple[tuple[str, ...], ...] = ()


COLD = WarmStart()
