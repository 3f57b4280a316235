"""What is said of code that waits in real time, of which a simulated run has none."""

from __future__ import annotations

from collections.abc import Collection
from types import FrameType

from pytest_hricdv.runtime.place import UNKNOWN, authors_frame

TIME, THREADING, ASYNCIO = "time", "threading", "asyncio"

KINDS = {
    TIME: "time and datetime",
    THREADING: "threading, queue and the thread pool of concurrent.futures",
    ASYNCIO: "asyncio",
}
"""What a testbench may name as virtual -> the modules that it is for."""


_KIND_OF = {
    "time": TIME,
    "threading": THREADING,
    "queue": THREADING,
    "concurrent": THREADING,
    "asyncio": ASYNCIO,
    "selectors": ASYNCIO,
}
"""Module of Python's library, its package -> the kind of waiting that it is."""

_OUTSIDE = ("subprocess", "socket", "ssl", "http", "urllib", "multiprocessing")
"""Modules of the library that wait for other processes or machines: no kind of virtual time is for these."""


def real_wait(
    frame: FrameType | None, who: str, code: Collection[str], virtual: Collection[str], waits_in: str = ""
) -> str:
    """A sentence: where and in what code waits in real time, and what to do.

    Args:
        frame: the innermost one of the code that waits.
        who: waits: a node, the world, or the testbench's `run`.
        code: the packages that wait in virtual time.
        virtual: the kinds of waiting that are virtual there.
        waits_in: what it waits in, as its author calls it; empty: the function of the library that its author called.
    """
    own, inner = authors_frame(frame), frame
    while inner is not None and inner.f_back is not own:
        inner = inner.f_back
    if not waits_in and inner is not None and frame is not own:
        waits_in = f"{inner.f_globals.get('__name__', '?')}.{inner.f_code.co_qualname}"
    place = UNKNOWN if own is None else f"{own.f_code.co_filename}:{own.f_lineno}"
    module = "" if own is None else str(own.f_globals.get("__name__", ""))
    advice = _remedy(module, who, waits_in, code, virtual)
    where = f", in {waits_in}" if waits_in else ""
    return f"{place}: {who} waits in real time{where}, of which a simulated run has none: {advice}"


def _remedy(module: str, who: str, waits_in: str, code: Collection[str], virtual: Collection[str]) -> str:
    """What to do about code of a module that waits in real time."""
    root = waits_in.partition(".")[0].rpartition(" ")[2]
    if who == "run":
        return (
            "spawn what waits as a node, run.kernel.spawn(name, body), and let run.go simulate it; what is not "
            "simulated is started before the tests"
        )
    if who == "the world":
        return "let it compute instead, or ask for an answer that it gets at once"
    if root in _OUTSIDE or any(module == package or module.startswith(f"{package}.") for package in code):
        return "nothing outside of a run can be waited for: let a port give the code what it needs, in virtual time"
    kinds = [kind for kind in KINDS if kind in virtual or kind == _KIND_OF.get(root, kind)]
    wanted = ", ".join(f'"{kind}"' for kind in kinds)
    return (
        f"list module {module} in the testbench's code, with virtual=({wanted}{',' if ', ' not in wanted else ''}), so "
        "that it waits in virtual time; or let it use the clock of its port. A socket or a process cannot be waited for"
    )
