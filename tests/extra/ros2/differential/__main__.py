"""One process of a system on the real middleware: `python -m tests.extra.ros2.differential SYSTEM PROCESS LOG`."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from tests.extra.ros2.differential.systems import SYSTEMS


def main() -> None:
    """Run it; each line of the log is a topic and what was logged about it."""
    system, process, file = SYSTEMS[sys.argv[1]], sys.argv[2], Path(sys.argv[3])
    del sys.argv[1:]
    with file.open("w", encoding="utf-8", buffering=1) as log:
        body = {**system.ending, **system.servers}[process]
        body(lambda about, what: print(json.dumps([about, what]), file=log))


if __name__ == "__main__":
    main()
