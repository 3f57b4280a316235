"""A plugin of pytest for the first runs of a draft: what the code would do outside is refused, and noted.

    python -m pytest -p pytest_hricdv.extra.draft.guard

The environment variable `HRICDV_DRAFT_ROOT` names the folder of the code, `HRICDV_DRAFT_NOTES` the file of the notes.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path
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


_IS_NOTING = [False]
"""To write a note is to open a file, which is looked at as well."""


class RefusedError(PermissionError):
    """The code would have an effect outside of its process."""


def _place() -> str:
    """The line of the code that is the cause; empty where it is somebody else's doing."""
    root = os.environ[ROOT] + os.sep
    frame: Any = sys._getframe(2)
    while frame is not None:
        file = frame.f_code.co_filename
        if file.startswith(root) and f"{os.sep}site-packages{os.sep}" not in file:
            return f"{file.removeprefix(root)}:{frame.f_lineno}"
        frame = frame.f_back
    return ""


def _look(event: str, arguments: tuple[Any, ...]) -> None:
    told = REFUSED.get(event, "")
    if event == "open" and isinstance(arguments[1], str) and any(letter in arguments[1] for letter in "wax+"):
        told = "writes a file"
    if not told or _IS_NOTING[0]:
        return
    place = _place()
    if place and "__pycache__" not in str(arguments[0]):
        _IS_NOTING[0] = True
        with Path(os.environ[NOTES]).open("a", encoding="utf-8") as notes:
            notes.write(f"{place}\t{told}\n")
        _IS_NOTING[0] = False
        raise RefusedError(f"{place}: the code {told}; refused in the first runs of a draft")


if ROOT in os.environ:
    sys.addaudithook(_look)
