"""Finds out whether somebody is debugging: measuring then steps aside, or his breakpoints would no longer stop.

Python has one trace function a thread. A tracer that sets its own takes the debugger's away, and the other way round.
"""

from __future__ import annotations

import sys


def debugger() -> str:
    """Which debugger looks at this process now, in words for people; empty where there is none.

    A trace function counts as a debugger's unless coverage is running, whose own it then may be.
    """
    if _pydevd():
        return "the IDE's debugger (pydevd) is attached"
    tool = _monitoring()
    if tool:
        return f"a debugger is attached ({tool})"
    control = sys.modules.get("coverage")
    measuring = control is not None and control.Coverage.current() is not None
    return "a debugger holds the trace function" if sys.gettrace() is not None and not measuring else ""


def _pydevd() -> bool:
    """PyCharm's and VS Code's debugger; its fast mode hooks into the interpreter and sets no trace function at all."""
    if "pydevd" not in sys.modules:
        return False
    constants = sys.modules.get("_pydevd_bundle.pydevd_constants")
    found = getattr(constants, "get_global_debugger", None)
    return found is not None and found() is not None


def _monitoring() -> str:
    """The tool that is registered as a debugger with `sys.monitoring` (Python 3.12, PEP 669)."""
    monitoring = getattr(sys, "monitoring", None)
    return str(monitoring.get_tool(monitoring.DEBUGGER_ID) or "") if monitoring is not None else ""
