"""Errors of a run in virtual time: `KernelError` and `NodeError`, which the kernel and `runtime.virtual` raise.

`pytest.skip`, `pytest.xfail`, `pytest.exit` and `unittest.SkipTest` are exceptions, too. If the code under test, its
world or a handler raised them, they would end a test as if its author had asked for it: without verdict or failure. So
`word_of` recognizes them, by name: nothing here may depend on pytest, parts of which the code may replace.
"""

from __future__ import annotations

from types import AsyncGeneratorType, CoroutineType, GeneratorType, TracebackType

from pytest_hricdv._base.error_text import text_of
from pytest_hricdv._base.message import quote
from pytest_hricdv.runtime.source_location import authors_frame


class KernelError(Exception):
    """A node failed or misused the kernel; the message names the node and the simulated time."""


class TerminalInterrupt(KeyboardInterrupt):
    """Raised in the code that has a simulated terminal when ctrl-c is pressed in it; ends at most that code."""


class NodeError(KernelError):
    """A node failed: it raised the exception that is the cause, or, without a cause, keeps time from passing.

    Args:
        node: its name.
        time_s: when it failed (s of simulated time).
        failure: what happened.
    """

    def __init__(self, node: str, time_s: float, failure: str) -> None:
        super().__init__(f"{node} {failure}")
        self.node = node
        self.time_s = time_s


_DEFERRED = {
    CoroutineType: ("cr", "coroutine"),
    GeneratorType: ("gi", "generator"),
    AsyncGeneratorType: ("ag", "generator"),
}
"""What a function with `async` or `yield` returns -> the prefix of its attributes, and the word for it."""


def what_never_began(made: object) -> str:
    """The error if a function returned a coroutine or generator, of which nothing has run; empty for anything else.

    Python warns of coroutines only, and long after the verdict.
    """
    prefix, noun = _DEFERRED.get(type(made), ("", ""))
    has_begun = prefix and (getattr(made, f"{prefix}_running") or getattr(made, f"{prefix}_suspended", False))
    if not prefix or has_begun or getattr(made, f"{prefix}_frame") is None:
        return ""
    if isinstance(made, CoroutineType):
        made.close()  # otherwise Python warns, too
    code = getattr(made, f"{prefix}_code")
    place = f"{code.co_filename}:{code.co_firstlineno}: {code.co_qualname}"
    return f"{place} returned a {noun}, of which nothing has run; expected a function without async and yield"


_WORDS = {
    ("builtins", "Skipped"): "pytest.skip",  # pytest says that it lives there
    ("_pytest.outcomes", "Skipped"): "pytest.skip",
    ("_pytest.outcomes", "XFailed"): "pytest.xfail",
    ("_pytest.outcomes", "Exit"): "pytest.exit",
    ("unittest.case", "SkipTest"): "unittest.SkipTest",
}


def word_of(error: BaseException | None) -> str:
    """`pytest.skip`: by what an error ends a test that has not failed; empty for any other error."""
    for kind in type(error).__mro__:
        word = _WORDS.get((kind.__module__, kind.__name__))
        if word is not None:
            return word
    return ""


def refusal(error: BaseException) -> str:
    """The reason why such an end is refused, with the line that asked for it."""
    message = getattr(error, "msg", None) or text_of(error)
    return (
        f"{_place(error.__traceback__)}: {word_of(error)}({quote(message)}) in a run: only a test function or a "
        "fixture may end a test so, not the code under test, its world or the testbench's run: let them raise an "
        "error, or decide in the test function"
    )


def _place(traceback: TracebackType | None) -> str:
    frame = None
    while traceback is not None:
        if not traceback.tb_frame.f_globals.get("__name__", "").startswith("_pytest."):
            frame, line = traceback.tb_frame, traceback.tb_lineno
        traceback = traceback.tb_next
    if frame is None:
        return "an unknown place"
    authors = authors_frame(frame)
    if authors is None or authors is frame:
        return f"{frame.f_code.co_filename}:{line}"
    return f"{authors.f_code.co_filename}:{authors.f_lineno}"
