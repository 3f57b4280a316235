"""The text of an error of somebody else's code, in a line: with what it stands for, and whatever its `__str__` does."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice

from pytest_hricdv._base.message import MAX_LINE, MAX_TEXT, cut

MAX_CAUSES = 20
"""Chained errors that are shown, each with its traceback; a longer chain comes from recursion that catches itself."""


def error_text(error: BaseException) -> str:
    """`ExceptionGroup: unhandled errors in a TaskGroup (2 sub-exceptions): ValueError: no dimmer; OSError: no bulb`.

    Up to three causes in all: `RuntimeError: cannot serve, from KeyError: 'rig'`. The traceback has the others.
    """
    texts: list[str] = []
    cause: BaseException | None = error
    while cause is not None and len(texts) < 3:
        texts.append(_alone(cause))
        hidden = cause.__suppress_context__
        cause = cause.__cause__ or (None if hidden else cause.__context__)
    return ", from ".join(texts)


def causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error and what it came of, each once: the code under test may let them come of each other."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__


def _alone(error: BaseException) -> str:
    try:
        message = str(error)
    except Exception as failure:  # of the author's own __str__
        message = f"(its text raised {type(failure).__name__})"
    message = cut(message, MAX_LINE)  # before it is copied, for it may have megabytes
    text = " ".join(f"{type(error).__name__}: {message}".removesuffix(": ").split())
    if not isinstance(error, BaseExceptionGroup):
        return text
    leaves = [*_leaves(error)]
    named = [_alone(leaf) for leaf in leaves[:4]]
    rest = len(leaves) - len(named)
    more = [f"and {rest} more"] if rest else []
    return f"{text}: {'; '.join([*named, *more])}"


def _leaves(group: BaseExceptionGroup[BaseException]) -> Iterator[BaseException]:
    pending: list[BaseException] = [group]
    while pending:  # no recursion: it may be of any depth
        error = pending.pop()
        if isinstance(error, BaseExceptionGroup):
            pending += reversed(error.exceptions)
        else:
            yield error


def shorten(error: BaseException) -> None:
    """Cut the texts of an error, its causes, and its group, before pytest writes them: it would copy them many times.

    The error stays the same object, of the same or a derived class, so that `pytest.raises` and marks still know it.
    """
    for last in islice(causes(error), MAX_CAUSES - 1, None):  # of a recursion that catches itself there are thousands
        last.__cause__ = last.__context__ = None
    pending: list[BaseException | None] = [error]
    seen: set[int] = set()
    while pending:
        part = pending.pop()
        if part is None or id(part) in seen:
            continue
        seen.add(id(part))
        pending += [part.__cause__, part.__context__]
        if isinstance(part, BaseExceptionGroup):
            pending += part.exceptions
        _shorten_one(part)


def _shorten_one(error: BaseException) -> None:
    notes = getattr(error, "__notes__", None)
    if isinstance(notes, list):
        notes[:] = [cut(note) if isinstance(note, str) else note for note in notes]
    text = _text_of(error)
    if text is None or len(text) <= MAX_TEXT:
        return
    short = cut(text)
    del text
    error.args = (short,)
    if _text_of(error) == short:
        return
    kind = type(error)
    names = {"__str__": lambda self: short, "__module__": kind.__module__, "__qualname__": kind.__qualname__}
    try:
        error.__class__ = type(kind.__name__, (kind,), names)
    except TypeError:  # a class of C, whose text is none of its arguments: it stays as it is
        return


def _text_of(error: BaseException) -> str | None:
    try:
        return str(error)
    except Exception:  # of the author's own __str__
        return None
