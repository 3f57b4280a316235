"""Runs a function with a deep stack: code may be nested more deeply than Python's own limit allows to walk it."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from typing import TypeVar

T = TypeVar("T")

DEPTH, BYTES = 30_000, 512 * 1024 * 1024
"""Calls in each other, and the stack that they may take; memory is only taken where it is used."""


def with_deep_stack(function: Callable[[], T]) -> T:
    """The result of a function, called in a thread of its own; raises what it raises."""
    results: list[T] = []
    errors: list[BaseException] = []

    def call() -> None:
        try:
            results.append(function())
        except BaseException as error:
            errors.append(error)

    depth, size = sys.getrecursionlimit(), threading.stack_size(BYTES)
    sys.setrecursionlimit(DEPTH)
    try:
        thread = threading.Thread(target=call, name="draft")
        thread.start()
        thread.join()
    finally:
        threading.stack_size(size)
        sys.setrecursionlimit(depth)
    if errors:
        raise errors[0]
    return results[0]
