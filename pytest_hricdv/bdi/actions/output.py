"""``.print`` and its kin."""

from __future__ import annotations

from ..terms import String
from .registry import MANY, Invocation, Outcome, internal_action


def _text(invocation: Invocation, start: int = 0) -> str:
    """The arguments one after the other; strings without quotes, but only outside of other terms."""
    values = [invocation.value(index) for index in range(start, len(invocation))]
    return "".join(value.value if isinstance(value, String) else str(value) for value in values)


@internal_action("print", 0, MANY)
def _print(invocation: Invocation) -> Outcome:
    invocation.agent.run.print(invocation.agent.name, _text(invocation))
    return True


@internal_action("println", 0, MANY)
def _println(invocation: Invocation) -> Outcome:
    return _print(invocation)


@internal_action("log", 2, MANY)
def _log(invocation: Invocation) -> Outcome:
    invocation.agent.run.warn(f"{invocation.agent.name}: {_text(invocation, 1)}")
    return True
