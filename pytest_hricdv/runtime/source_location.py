"""`place_of`: the line of a stack that is in the project's own code, as `file:line`, for error messages about runs."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import FrameType
from typing import Any

UNKNOWN = "an unknown place"


def place_of(frame: FrameType | None) -> str:
    """`file:line` of the innermost function that is in neither a library nor this plugin (see `authors_frame`).

    In an event loop between two tasks, it is that of a task that is ready to run, and not where the loop was started.
    In a thread that runs a function of a library, it is that which started the thread, or gave the call to its pool.
    """
    found = authors_frame(frame)
    if found is not None and _is_authors(found) and not _is_between_tasks(frame):
        return _place(found)
    between = min(_places_of_ready_tasks(), default="") if _is_between_tasks(frame) else ""
    return between or _begin_of(frame) or (UNKNOWN if found is None else _place(found))


def _begin_of(frame: FrameType | None) -> str:
    """Where what a thread of a run does was asked for: threads of this plugin know. Empty in other threads."""
    while frame is not None:
        place = getattr(frame.f_locals.get("self"), "begun_at", "") if _is_ours(frame) else ""
        if place and isinstance(place, str):
            return place
        frame = frame.f_back
    return ""


def _is_between_tasks(frame: FrameType | None) -> bool:
    """Whether an event loop runs, and nothing of an author's within it."""
    while frame is not None and not _is_authors(frame):
        if frame.f_code.co_name == "_run_once" and frame.f_globals.get("__name__") == "asyncio.base_events":
            return True
        frame = frame.f_back
    return False


def _place(frame: FrameType) -> str:
    return f"{frame.f_code.co_filename}:{frame.f_lineno}"


def _places_of_ready_tasks() -> Iterator[str]:
    """Where the tasks of the running event loop are that wait for nothing."""
    asyncio: Any = sys.modules.get("asyncio")
    loop = asyncio._get_running_loop() if asyncio is not None else None
    for task in asyncio.all_tasks(loop) if loop is not None else ():
        frames, coroutine = [], task.get_coro() if getattr(task, "_fut_waiter", None) is None else None
        while coroutine is not None:
            frames.append(getattr(coroutine, "cr_frame", None))
            coroutine = getattr(coroutine, "cr_await", None)
        yield from [_place(frame) for frame in frames if frame is not None and _is_authors(frame)][-1:]


def authors_frame(frame: FrameType | None) -> FrameType | None:
    """The innermost frame that is its author's; of a library if none is, as where a thread runs a function of one.

    Neither of this plugin nor of Python's library, nor of a module whose frames pytest does not show, as `rclpy` in a
    simulated run.
    """
    library: FrameType | None = None
    while frame is not None:
        if _is_authors(frame):
            return frame
        if library is None and not _is_ours(frame):
            library = frame
        frame = frame.f_back
    return library


def _root(frame: FrameType) -> str:
    return str(frame.f_globals.get("__name__", "")).partition(".")[0]


def _is_ours(frame: FrameType) -> bool:
    return _root(frame) in ("pytest_hricdv", "_pytest")


def _is_authors(frame: FrameType) -> bool:
    is_library = _is_ours(frame) or _root(frame) in sys.stdlib_module_names
    return not is_library and not frame.f_globals.get("__tracebackhide__", False)


def module_place_of(frame: FrameType | None) -> str:
    """The location as `controller/robot.py:41`, by the module's name, so that the project's folder does not matter.

    Empty if no frame is its author's, as in an idle worker of a pool.
    """
    frame = authors_frame(frame)
    if frame is None or not _is_authors(frame):
        return ""
    path = str(frame.f_globals.get("__name__", "")).replace(".", "/")
    is_package = frame.f_code.co_filename.endswith("__init__.py")
    return f"{path}{'/__init__' if is_package else ''}.py:{frame.f_lineno}"


def error_line(error: BaseException) -> str:
    """Line of the innermost function that is its author's, of those that an exception left (see `authors_frame`)."""
    trace, place = error.__traceback__, UNKNOWN
    while trace is not None:
        if authors_frame(trace.tb_frame) is trace.tb_frame:
            place = f"{trace.tb_frame.f_code.co_filename}:{trace.tb_lineno}"
        trace = trace.tb_next
    return place
