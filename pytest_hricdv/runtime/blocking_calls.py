"""`real_wait`: the error message for code that waits in real time: its line, the call, how to wait in virtual time."""

from __future__ import annotations

import ast
import builtins
import linecache
import sys
from collections.abc import Collection, Mapping
from contextlib import suppress
from importlib.util import find_spec
from itertools import islice
from types import FrameType

from pytest_hricdv.runtime.source_location import authors_frame, place_of

TIME, THREADING, ASYNCIO = "time", "threading", "asyncio"

KINDS = {
    TIME: "time and datetime",
    THREADING: "threading, queue and the thread pool of concurrent.futures",
    ASYNCIO: "asyncio",
}
"""Value of a testbench's `VirtualTime.apis` -> the modules of Python's library that it makes virtual, in words."""


HAS_TERMINALS = all(find_spec(name) is not None for name in ("fcntl", "termios"))
"""Whether this system has POSIX terminals, which a run can give to nodes; Windows has none."""


def virtual_time(needed: Collection[str], virtual: Collection[str]) -> str:
    """The argument of a testbench that makes these types of waiting virtual, with those that are already."""
    kinds = [kind for kind in KINDS if kind in virtual or kind in needed]
    apis = ", ".join(f'"{kind}"' for kind in kinds) + ("," if len(kinds) == 1 else "")
    return f"time=VirtualTime(apis=({apis}))"


_KIND_OF = {
    "time": TIME,
    "threading": THREADING,
    "_thread": THREADING,
    "queue": THREADING,
    "_queue": THREADING,
    "concurrent": THREADING,
    "asyncio": ASYNCIO,
}
"""Module or package of Python's library -> the kind of waiting that its functions do. All other modules wait for
processes, machines, signals or people, which `VirtualTime.apis` does not cover."""

_UNKNOWN = object()


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
    library = waits_in
    if not waits_in and inner is not None and frame is not own and not _is_substitute(inner):
        library = waits_in = f"{inner.f_globals.get('__name__', '?')}.{inner.f_code.co_qualname}"
    elif not waits_in and own is not None:
        waits_in, library = _call_of(own)
    module = "" if own is None else str(own.f_globals.get("__name__", ""))
    advice = _remedy(module, who, library, code, virtual)
    where = f", in {waits_in}" if waits_in else ""
    return f"{place_of(frame)}: {who} waits in real time{where}, which a simulated run does not have: {advice}"


def _is_substitute(frame: FrameType) -> bool:
    """Whether a frame is of the plugin, which took the place of a function in C, such as `select.select`."""
    return str(frame.f_globals.get("__name__", "")).startswith("pytest_hricdv.")


def _call_of(frame: FrameType) -> tuple[str, str]:
    """The function in C that a frame calls now, as its author wrote it, and its module; empty if not known."""
    nowhere = (None, None, None, None)  # with -X no_debug_ranges
    line, last_line, start, end = next(islice(frame.f_code.co_positions(), frame.f_lasti // 2, None), nowhere)
    if line is None or line != last_line:
        return "", ""
    text = linecache.getline(frame.f_code.co_filename, line).encode()[start:end].decode(errors="replace")
    try:
        call = ast.parse(text, mode="eval").body
    except SyntaxError:
        return "", ""
    if not isinstance(call, ast.Call):
        return "", ""
    return ast.unparse(call.func), _module_of(call.func, frame)


def _module_of(function: ast.expr, frame: FrameType) -> str:
    """The module of what an expression calls, without evaluating it; empty if that is not known."""
    names = {**vars(builtins), **frame.f_globals, **frame.f_locals}
    value = _value_of(function, names)
    if value is not _UNKNOWN:
        return str(getattr(value, "__module__", None) or type(getattr(value, "__self__", None)).__module__)
    owner = _value_of(function.value, names) if isinstance(function, ast.Attribute) else _UNKNOWN
    return "" if owner is _UNKNOWN else type(owner).__module__  # a method: its class says what it waits for


def _value_of(expression: ast.expr, names: Mapping[str, object]) -> object:
    """The value of names, attributes of objects, and items of lists and dictionaries; `_UNKNOWN` for all else."""
    match expression:
        case ast.Name(name):
            return names.get(name, _UNKNOWN)
        case ast.Attribute(owner, name):
            return getattr(_value_of(owner, names), "__dict__", {}).get(name, _UNKNOWN)
        case ast.Subscript(owner, ast.Constant(key)):
            items = _value_of(owner, names)
            with suppress(LookupError, TypeError):
                return items[key] if type(items) in (list, tuple, dict) else _UNKNOWN  # type: ignore[index]
    return _UNKNOWN


def _remedy(module: str, who: str, library: str, code: Collection[str], virtual: Collection[str]) -> str:
    """Advice on code of one module that waits in real time in another one."""
    root = library.partition(".")[0].rpartition(" ")[2]
    if who == "run":
        return (
            "spawn what waits as a node, run.kernel.spawn(name, body), and let run.go simulate it; what is not "
            "simulated is started before the tests"
        )
    if who == "the world":
        return "let it compute instead, or ask for an answer that it gets at once"
    is_outside = root not in _KIND_OF and (root in sys.stdlib_module_names or not KINDS.keys() - virtual)
    if is_outside or any(module == package or module.startswith(f"{package}.") for package in code):
        return "nothing outside of a run can be waited for: let a port give the code what it needs, in virtual time"
    needed = [_KIND_OF[root]] if root in _KIND_OF else list(KINDS)
    return (
        f"list module {module} in the testbench's code, with {virtual_time(needed, virtual)}, so "
        "that it waits in virtual time; or let it use the clock of its port. A socket or a process cannot be waited for"
    )
