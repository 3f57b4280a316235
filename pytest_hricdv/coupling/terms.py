"""Converts values of a run to AgentSpeak terms, so that both can be compared."""

from __future__ import annotations

import re

from pytest_hricdv.bdi import Number, String, Structure, Term
from pytest_hricdv.monitor import Value

_ATOM = re.compile(r"[a-z][A-Za-z0-9_]*")


def term_of(value: Value) -> Term:
    """A value of a run as a term: True is 1; a text is an atom if it can be one, else a string."""
    return _text_term(value) if isinstance(value, str) else Number(value)


def _text_term(text: str) -> Term:
    return Structure(text) if _ATOM.fullmatch(text) else String(text)


def comparable(literal: Structure) -> Structure:
    """The literal with texts as `term_of` gives them, without annotations: `turn("released")` is `turn(released)`."""
    args = (_text_term(arg.value) if isinstance(arg, String) else arg for arg in literal.args)
    return Structure(literal.functor, tuple(args), (), literal.negated)
