"""One-line texts of errors raised by code under test, with their causes, even if their `__str__` raises or hangs.

`error_text` gives the text of an error, `text_of` that of any object; `Kernel` and the features use them in reports.
"""

from __future__ import annotations

import _thread
import ctypes
import signal
import threading
import traceback
from collections.abc import Callable, Iterator
from itertools import compress, islice
from types import FrameType, TracebackType
from typing import TypeVar, cast

from greenlet import getcurrent, greenlet

from pytest_hricdv._base.message import MAX_LINE, MAX_TEXT, cut

MAX_CAUSES = 20
"""Maximum number of chained errors to show, each with its traceback; a longer chain comes from endless recursion."""

MAX_FRAMES = 1000
"""Maximum number of frames of a traceback to show: Python's default limit of recursion, which code may increase."""

MAX_NESTED = 50
"""Maximum depth of exception groups in each other: pytest shows them by recursion, with four calls for each."""

TEXT_WITHIN_S = 1.0
"""Time limit (s of real time) for the `repr` of foreign values; a list of six million numbers exceeds it."""

T = TypeVar("T")

_OURS = __name__.partition(".")[0]

# As they are now: the code under test may replace them, and in runs some are refused.
_HANDLE, _START, _LOCK = signal.signal, _thread.start_new_thread, _thread.allocate_lock
_KILL, _STRIKE = getattr(signal, "pthread_kill", None), getattr(signal, "SIGVTALRM", None)
_PLAIN = frozenset({str, int, float, bool, type(None)})


class OvertimeError(Exception):
    """A call of foreign code, such as `__str__`, did not return in time."""


def call_within(limit_s: float, function: Callable[[], T]) -> T:
    """Call a function and return its result. One that does not return in time (s of real time) is left where it is, for
    ever.

    Without a limit in other threads than the main one, and on Windows: no signal reaches it there.

    Raises:
        OvertimeError: it does not return in time.
    """
    if _KILL is None or _STRIKE is None or threading.current_thread() is not threading.main_thread():
        return function()
    here, main = getcurrent(), _thread.get_ident()
    calling = greenlet(function, here)
    over, ended = _LOCK(), _LOCK()
    over.acquire()
    ended.acquire()
    is_due = False

    def strike() -> None:
        nonlocal is_due
        while not over.acquire(timeout=limit_s):
            is_due = True
            _KILL(main, _STRIKE)
        ended.release()

    def leave(number: int, frame: FrameType | None) -> None:
        if is_due and getcurrent() is calling:  # the watchdog's own timer says nothing of this call
            # Never freed, not even when the interpreter ends: greenlet would raise in it, and it would continue.
            ctypes.pythonapi.Py_IncRef(ctypes.py_object(calling))
            here.throw(OvertimeError())

    previous = _HANDLE(_STRIKE, leave)
    _START(strike, ())
    try:
        returned: T = calling.switch()
        return returned
    finally:
        over.release()
        ended.acquire()
        _HANDLE(_STRIKE, previous)


def text_of(value: object, to_text: Callable[[object], str] = str) -> str:
    """The text of a foreign value, at most a line; if its `__str__` or `__repr__` gives none, the reason."""
    return _text_or_problem(value, to_text)[0]


def _text_or_problem(value: object, to_text: Callable[[object], str] = str, most: int = MAX_LINE) -> tuple[str, bool]:
    """The text, shortened before it is copied, as it may have megabytes; and whether it is the value's own text."""
    kind = type(value)
    is_plain = kind in _PLAIN or (
        isinstance(value, BaseException)
        and kind.__str__ is BaseException.__str__
        and all(type(argument) in _PLAIN for argument in value.args)
    )
    try:
        text = to_text(value) if is_plain else call_within(TEXT_WITHIN_S, lambda: to_text(value))
        return cut(text, most), True
    except KeyboardInterrupt:
        raise
    except OvertimeError:
        return f"(its text takes more than {TEXT_WITHIN_S:g} s)", False
    except BaseException as failure:  # of the author's own method
        return f"(its text raised {type(failure).__name__})", False


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
    """An error and its causes, each once: code under test may create cycles."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        yield error
        error = error.__cause__ or error.__context__


def _alone(error: BaseException) -> str:
    text = " ".join(f"{type(error).__name__}: {text_of(error)}".removesuffix(": ").split())
    if not _members(error):
        return text
    leaves = [*_leaves(error)]
    named = [_alone(leaf) for leaf in leaves[:4]]
    rest = len(leaves) - len(named)
    more = [f"and {rest} more"] if rest else []
    return f"{text}: {'; '.join([*named, *more])}"


def _members(error: BaseException) -> tuple[BaseException, ...]:
    """The errors of a group; none for other errors, even if their class or a patched `isinstance` says otherwise."""
    is_group = BaseExceptionGroup in type(error).__mro__
    return cast("BaseExceptionGroup[BaseException]", error).exceptions if is_group else ()


def _leaves(group: BaseException) -> Iterator[BaseException]:
    """The leaf errors of a group, each once."""
    pending: list[BaseException] = [group]
    seen: set[int] = set()
    while pending:  # no recursion: it may be of any depth
        error = pending.pop()
        if id(error) in seen:
            continue
        seen.add(id(error))
        members = _members(error)
        if members:
            pending += reversed(members)
        else:
            yield error


def _is_tangled(group: BaseException) -> bool:
    """Whether groups are nested too deeply, or one is in several, so that recursion would not end."""
    level = [group]
    seen: set[int] = set()
    for _ in range(MAX_NESTED):
        inner = [part for outer in level for part in _members(outer) if _members(part)]
        numbers = {id(part) for part in inner}
        if len(numbers) < len(inner) or not numbers.isdisjoint(seen):
            return True
        seen |= numbers
        level = inner
    return bool(level)


def _untangle(error: BaseException) -> BaseException:
    """The error; a group that cannot be printed becomes one with the same errors and no inner group."""
    if not _is_tangled(error):
        return error
    flat = BaseExceptionGroup(f"{text_of(error)}, of groups within groups", [*_leaves(error)])
    flat.__cause__, flat.__context__ = error.__cause__, error.__context__
    flat.__suppress_context__ = error.__suppress_context__
    return flat.with_traceback(error.__traceback__)


def shorten(error: BaseException) -> BaseException:
    """An error that pytest can print: the texts of its causes and its group are cut, as it is printed many times.

    It stays the same object, of the same or a derived class, so that `pytest.raises` and marks still know it; only
    groups that are too deep become others.
    """
    error = _untangle(error)
    for last in islice(causes(error), MAX_CAUSES - 1, None):  # of a recursion that catches itself there are thousands
        last.__cause__ = last.__context__ = None
    pending: list[BaseException | None] = [error]
    seen: set[int] = set()
    while pending:
        part = pending.pop()
        if part is None or id(part) in seen:
            continue
        seen.add(id(part))
        _cut_frames(part)
        hidden = part.__suppress_context__
        part.__cause__, part.__context__ = (
            linked and _untangle(linked) for linked in (part.__cause__, part.__context__)
        )
        part.__suppress_context__ = hidden
        pending += [part.__cause__, part.__context__]
        pending += _members(part)
        _hide_between(part)
        _shorten_one(part)
    return error


def _cut_frames(error: BaseException) -> None:
    """Cut the middle of a recursion: pytest would compare all pairs of its frames, for minutes."""
    trace, entries = error.__traceback__, list[TracebackType]()
    while trace is not None:
        entries.append(trace)
        trace = trace.tb_next
    if len(entries) > MAX_FRAMES:
        entries[MAX_FRAMES // 2 - 1].tb_next = entries[-(MAX_FRAMES // 2)]


def _hide_between(error: BaseException) -> None:
    """Hide frames of this package that called foreign code: they are not the reason.

    Frames that raise an error of this package on purpose are hidden, too: its message says what is wrong, and where.
    """
    frames = [frame for frame, _ in traceback.walk_tb(error.__traceback__)]
    is_ours = [str(frame.f_globals.get("__name__")).partition(".")[0] == _OURS for frame in frames]
    is_on_purpose = str(type(error).__module__).partition(".")[0] == _OURS and not all(is_ours)
    while is_ours and is_ours[-1] and not is_on_purpose:
        is_ours.pop()
    for frame in compress(frames, is_ours):
        frame.f_locals["__tracebackhide__"] = True


def _shorten_one(error: BaseException) -> None:
    notes = getattr(error, "__notes__", None)
    if isinstance(notes, list):
        notes[:] = [cut(note) if isinstance(note, str) else note for note in notes]
    short, is_own = _text_or_problem(error, most=MAX_TEXT)
    if is_own and len(short) <= MAX_TEXT:
        return
    error.args = (short,)
    if _text_or_problem(error, most=len(short)) == (short, True):
        return
    kind = type(error)

    def say(self: object) -> str:
        return short

    names = {"__str__": say, "__repr__": say, "__module__": kind.__module__, "__qualname__": kind.__qualname__}
    try:
        error.__class__ = type(kind.__name__, (kind,), {**names, "__slots__": ()})
    except Exception:  # a class of C, whose text is none of its arguments, or a metaclass that refuses: so it stays
        return
