"""``.print`` and its kin."""

from __future__ import annotations

import re

from pytest_hricdv.bdi.actions.registry import MANY, Invocation, internal_action
from pytest_hricdv.bdi.agent.agent_state import Outcome
from pytest_hricdv.bdi.language.parser import parse_term
from pytest_hricdv.bdi.language.terms import String, Term, Variable

_EXPRESSION = re.compile(r"#\{([^}]*)\}")


def _text(invocation: Invocation, start: int = 0) -> str:
    """The arguments one after the other; strings without quotes, but only outside of other terms.

    A variable without a value is marked as one, as Jason does.
    """
    return "".join(_shown(invocation.value(index)) for index in range(start, len(invocation)))


def _shown(value: Term) -> str:
    if isinstance(value, String):
        return value.value
    return f"{value}<no-value>" if isinstance(value, Variable) else str(value)


@internal_action("print", 0, MANY)
def _print(invocation: Invocation) -> Outcome:
    invocation.agent.run.print(invocation.agent.name, _text(invocation))
    return True


@internal_action("println", 0, MANY)
def _println(invocation: Invocation) -> Outcome:
    return _print(invocation)


@internal_action("puts", 1, MANY)
def _puts(invocation: Invocation) -> Outcome:
    """As ``.print``, with the values of the expressions in the texts, as in ``"#{X+1} left"``."""
    agent, bindings = invocation.agent, invocation.bindings

    def filled(index: int) -> str:
        value = invocation.value(index)
        text = _shown(value)
        if not isinstance(value, String):
            return text
        return _EXPRESSION.sub(lambda match: _shown(agent.value(invocation.read(match[1], parse_term), bindings)), text)

    agent.run.print(agent.name, "".join(map(filled, range(len(invocation)))))
    return True


@internal_action("log", 2, MANY)
def _log(invocation: Invocation) -> Outcome:
    invocation.agent.run.warn(f"{invocation.agent.name}: {_text(invocation, 1)}")
    return True
