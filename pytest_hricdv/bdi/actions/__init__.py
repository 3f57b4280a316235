"""The standard internal actions, and the functions of expressions."""

from __future__ import annotations

from . import beliefs, goals, lists, messages, output, plans, strings, terms, time
from .functions import function_value
from .registry import PREPARED, Invocation, call_action, check_calls

__all__ = [
    "PREPARED",
    "Invocation",
    "beliefs",
    "call_action",
    "check_calls",
    "function_value",
    "goals",
    "lists",
    "messages",
    "output",
    "plans",
    "strings",
    "terms",
    "time",
]
