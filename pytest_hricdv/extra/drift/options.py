"""How drift between code and testbench is looked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field


@dataclass(frozen=True)
class DriftOptions:
    """How drift is looked for.

    Args:
        fails: a session looks for it, and fails where there is some that is not known.
        known: what it is called -> the reason why it may be there.
    """

    fails: bool = False
    known: Mapping[str, str] = field(default_factory=dict)
