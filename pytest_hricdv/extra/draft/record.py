"""`hricdv record --package PKG -- COMMAND`: records the calls between a package and the rest of a program."""

from __future__ import annotations

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

from pytest_hricdv._base.message import InputError, visible
from pytest_hricdv.extra.draft.code.loading import locate
from pytest_hricdv.extra.draft.observe.observations import (
    Observations,
    merge_observations,
    read_observations,
    write_atomically,
)
from pytest_hricdv.extra.draft.observe.tracer import VARIABLE

OUTSIDE = ("tests", "test", "conftest", "demo", "demos", "example", "examples", "__main__", "main")
"""Modules of a package that use its code, and are not part of it."""

_STOP_S = 10.0
"""Time (s) for a program to end after it was asked to (chosen)."""

_SITE = """\
import os, sys
_here = {here!r}
sys.path[:] = [each for each in sys.path if each != _here]
_this = sys.modules.pop("sitecustomize")
try:
    import sitecustomize  # of the installation
except ImportError:
    pass
sys.modules.setdefault("sitecustomize", _this)
sys.path.append({root!r})
try:
    from pytest_hricdv.extra.draft.observe.tracer import start_by_environment
finally:
    sys.path.remove({root!r})
start_by_environment()
"""

EPILOG = """\
The command runs as it is, with all its processes of Python: a demo, unit tests, a launch file. Calls across the border
of the package are kept in one file: how often, ranges, texts, keys and states. Values whose names say that they
are secrets are masked. Then: hricdv init --from PKG --recording FILE
"""


def add_command(commands: Any) -> None:
    """Add `record` to the commands of `hricdv`."""
    parser = commands.add_parser(
        "record",
        epilog=EPILOG,
        help="record how a program uses a package, for a draft of its testbench",
        description="Record what crosses the border of a package while a program runs.",
    )
    parser.add_argument("--package", required=True, metavar="PKG", help="the package: its name, folder or file")
    parser.add_argument("-o", "--output", type=Path, default=Path("hricdv-recording.json"), metavar="FILE",
                        help="where the recording goes (default: %(default)s)")  # fmt: skip
    parser.add_argument("--timeout", type=float, default=600.0, metavar="S",
                        help="end the program after S seconds (default: %(default)g)")  # fmt: skip
    parser.add_argument("program", nargs=argparse.REMAINDER, metavar="-- COMMAND", help="the program, as in a shell")
    parser.set_defaults(do=_do)


def _do(options: argparse.Namespace) -> int:
    program = options.program[1:] if options.program[:1] == ["--"] else options.program
    lines = record(options.package, program, options.output, options.timeout)
    try:
        while True:
            print(visible(next(lines)), flush=True)
    except StopIteration as end:
        return int(end.value != 0)
    except InputError as error:
        print(visible(f"error: record: {error}"), file=sys.stderr)
        return 2


def record(package: str, program: Sequence[str], output: Path, timeout_s: float) -> Generator[str, None, int]:
    """Run a program and record the border of a package; yields lines for the terminal.

    Returns:
        The exit status of the program; 0 if it was stopped, by the time limit or Ctrl-C.

    Raises:
        InputError: there is no such package or program, or nothing was recorded.
    """
    if not program:
        raise InputError(f"expected a program: record --package {package} -- python -m {package}.demo")
    _, _, file = locate(package, Path.cwd().resolve())
    folder = file.parent if file.name == "__init__.py" else file
    with tempfile.TemporaryDirectory(prefix="hricdv-record-") as name:
        status, is_stopped = _run(list(program), [str(folder)], Path(name), timeout_s)
        seen = merge_observations(map(read_observations, sorted(Path(name).glob("recording.*"))))
    if seen.is_empty and is_stopped:
        raise InputError(
            f"{' '.join(program)} was stopped, and left no recording: let it end by itself, or when it gets SIGINT"
        )
    if seen.is_empty:
        raise InputError(
            f"{' '.join(program)} (exit status {status}) made no call from outside into {package}: is it the program "
            "that uses the package? Its modules demo, tests and __main__ count as outside"
        )
    write_atomically(output, seen.to_json())
    yield from _summary(seen)
    ended = "was stopped" if is_stopped else f"ended with status {status}"
    until_then = ": the recording has what it did until then" if is_stopped or status else ""
    yield f"{output}: {output.stat().st_size:,} bytes; the program {ended}{until_then}"
    yield f"then: hricdv init hri --from {package} --recording {output}"
    return 0 if is_stopped else status


def _run(program: list[str], folders: list[str], where: Path, timeout_s: float) -> tuple[int, bool]:
    """Run it; its exit status, and whether it was stopped from here."""
    (where / "sitecustomize.py").write_text(_SITE.format(here=str(where), root=_root()), encoding="utf-8")
    asked = {"folders": folders, "outside": OUTSIDE, "file": str(where / "recording")}
    path = os.pathsep.join(filter(None, (str(where), os.environ.get("PYTHONPATH", ""))))
    environment = {**os.environ, VARIABLE: json.dumps(asked), "PYTHONPATH": path}
    if program[0] in ("python", "python3", "pytest"):  # of this environment
        program = [sys.executable, *(["-m", "pytest"] if program[0] == "pytest" else []), *program[1:]]
    try:
        process = subprocess.Popen(program, env=environment)
    except OSError as error:
        raise InputError(f"{program[0]}: cannot be started: {error.strerror}") from None
    # SIGINT first, as at a terminal: a program that SIGTERM ends writes no recording.
    stops: list[Callable[[], None]] = [partial(process.send_signal, signal.SIGINT), process.terminate, process.kill]
    try:
        return process.wait(timeout_s), False
    except KeyboardInterrupt:  # it has got SIGINT, too
        stops[0] = lambda: None
    except subprocess.TimeoutExpired:
        if os.name == "nt":
            del stops[0]
    for stop in stops:
        stop()
        with suppress(subprocess.TimeoutExpired):
            return process.wait(_STOP_S), True
    return process.wait(), True


def _root() -> str:
    return str(Path(__file__).parents[3])


def _summary(seen: Observations) -> Iterator[str]:
    yield (
        f"recorded: {len(seen.made)} classes made from outside, {len(seen.methods)} functions called from outside, "
        f"{len(seen.calls)} calls at ports, {sum(1 for pairs in seen.states.values() if len(pairs) > 1)} attributes "
        "that change"
    )
