"""A plugin of pytest for the first runs of a draft: what the code would do outside is refused, and noted.

    python -m pytest -p pytest_hricdv.extra.draft.first_runs.guard

The environment variable `HRICDV_DRAFT_ROOT` names the folder of the code, `HRICDV_DRAFT_NOTES` the file of the notes.
"""

from __future__ import annotations

import os
import sys
from typing import Any

ROOT, NOTES = "HRICDV_DRAFT_ROOT", "HRICDV_DRAFT_NOTES"

REFUSED = {
    "socket.connect": "connects to a network",
    "socket.bind": "opens a port of the network",
    "subprocess.Popen": "starts a process",
    "os.system": "runs a command",
    "os.exec": "becomes another program",
    "os.posix_spawn": "starts a process",
    "os.kill": "sends a signal to a process",
    "os.remove": "removes a file",
    "os.rename": "renames a file",
    "os.rmdir": "removes a folder",
    "os.mkdir": "makes a folder",
    "shutil.rmtree": "removes a folder",
}
"""Events of Python's audit -> what the code does."""


class RefusedError(PermissionError):
    """The code would have an effect outside of its process."""


def _place() -> str:
    """The line of the code that is the cause; empty where it is somebody else's doing."""
    root = os.environ[ROOT] + os.sep
    frame: Any = sys._getframe(2)
    while frame is not None:
        file = os.path.realpath(frame.f_code.co_filename)  # pytest's pythonpath may have `..`
        if file.startswith(root) and f"{os.sep}site-packages{os.sep}" not in file:
            return f"{file.removeprefix(root)}:{frame.f_lineno}"
        frame = frame.f_back
    return ""


def _look(event: str, arguments: tuple[Any, ...]) -> None:
    deed = REFUSED.get(event, "")
    if event == "open" and isinstance(arguments[1], str) and any(letter in arguments[1] for letter in "wax+"):
        deed = "writes a file"
    if not deed:
        return
    place = _place()
    if place and "__pycache__" not in str(arguments[0]):
        os.write(_NOTES, f"{place}\t{deed}\n".encode())
        raise RefusedError(f"{place}: the code {deed}; refused in the first runs of a draft")


if ROOT in os.environ:
    # Opened once: to open a file is looked at as well, and nodes of a run may not open any.
    _NOTES = os.open(os.environ[NOTES], os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    sys.addaudithook(_look)
