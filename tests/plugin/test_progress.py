"""Progress on a terminal, and none elsewhere. Each run has a pseudo-terminal of its own."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest

from tests.plugin.project import in_each_mode
from tests.plugin.screen import Screen

STATUS = re.compile(
    r"hri: (\d+) of 4(, a few seconds left)?(: (by-hand-(hall|cellar)-\w+-[0-9a-f]{8}(, | and 1 more)?)+)?"
)
RUN = (sys.executable, "-m", "pytest", "--hri-suite=by-hand")


def on_a_terminal(
    project: pytest.Pytester, *options: str, watch: Callable[[str], None] | None = None, **environment: str
) -> tuple[list[str], list[str]]:
    """Every lowest line that was ever shown, once each, in order; and all lines that are left in the end.

    `watch` is called with all that is written, as it comes.
    """
    ours, theirs = pty.openpty()
    environment = dict(os.environ) | {"TERM": "xterm", "COLUMNS": "80", "LINES": "24"} | environment
    with subprocess.Popen(
        [*RUN, *options], cwd=project.path, env=environment, stdin=theirs, stdout=theirs, stderr=theirs
    ) as process:
        os.close(theirs)
        written = b""
        try:
            while part := os.read(ours, 65536):
                written += part
                if watch is not None:
                    watch(written.decode(errors="replace"))
        except OSError:  # the other side is closed: all is read
            pass
        assert process.wait() == 0
    os.close(ours)
    screen, lowest = Screen(), [""]
    for piece in re.split(r"(?<=\x1b8)", written.decode()):
        screen.feed(piece)
        if screen.lines[-1] != lowest[-1]:
            lowest.append(screen.lines[-1])
    return lowest, screen.lines


@pytest.mark.slow
@in_each_mode
def test_a_terminal_shows_how_far_and_what_is_running_and_keeps_nothing_of_it(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    lowest, left = on_a_terminal(lamps, *options)
    statuses = [match for line in lowest if (match := STATUS.fullmatch(line))]
    assert {int(match[1]) for match in statuses} >= {0, 1, 2, 3}
    assert any(match[2] for match in statuses)  # how long it will take
    assert any(match[3] for match in statuses)  # what is running
    (dots,) = [line for line in left if line.endswith("[100%]")]
    assert sorted(dots.partition("py")[2].split("[")[0].strip() or dots.split("[")[0].strip()) == [".", ".", ".", "x"]
    assert [line for line in left if line.startswith("hri: ")] == ["hri: lamps, suite by-hand, seed 0, 4 tests"]
    assert any(line.startswith("PASSED  3 passed, 1 known to fail") for line in left)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "environment"),
    [(("-q",), {}), (("-s",), {}), (("-o", "console_output_style=classic"), {}), ((), {"TERM": "dumb"})],
    ids=["quiet", "with the tests' own output", "with pytest's classic output", "on a terminal that can do nothing"],
)
def test_it_stays_away_where_it_is_not_wanted(
    lamps: pytest.Pytester, options: tuple[str, ...], environment: dict[str, Any]
) -> None:
    lowest, _ = on_a_terminal(lamps, *options, **environment)
    assert not any(STATUS.fullmatch(line) for line in lowest)
