"""Real signals in a closing loop: to the session, and to the process that runs its tests. Nothing is lost."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.plugin.project import A_WORKER, change, report

pytestmark = [
    pytest.mark.slow,  # each test is a session or several
    pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="no /proc to see who is who's parent"),
]

SUITES = ("--hri-suite=by-hand", "--hri-close", "--hri-close-runs=16")  # four tests, then two generations
BY_HAND = 4
IN_OTHERS, IN_SECOND_GENERATION = 2, BY_HAND + 11
WITHOUT_XDIST = ("-p", "no:xdist")
PLACES = {"beside the session": (), "on a cluster": ("--hri-cluster=local:1",)}
PATIENCE_S = 500.0
"""Far above the 10 s that such a session takes alone."""

KILLING = """    lamp = Lamp()
    import os, sys
    if (getattr(sys.modules["__main__"], "__spec__", None) or sys).name.endswith("closing.process"):
        with open("runs.log", "a") as log:
            print(os.getppid(), file=log)
        with open("runs.log") as log:
            runs = len(log.readlines())
        if runs in {runs}:
            loop = os.getppid()
            with open(f"/proc/{{loop}}/stat") as stat:
                session = int(stat.read().rpartition(")")[2].split()[1])
            os.kill({whom}, {number})
"""


def kill(project: Path, whom: str, number: int, runs: tuple[int, ...]) -> None:
    """Let these runs of the loop, in the order in which they begin, send a signal to the `session` or the `loop`."""
    change(project, "conftest.py", "    lamp = Lamp()\n", KILLING.format(whom=whom, number=int(number), runs=runs))


def ended(project: Path, *options: str) -> tuple[int, str, dict[str, Any]]:
    """Exit status, output and report of a session."""
    (project / "runs.log").unlink(missing_ok=True)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # what is started in the background ignores it
    try:
        session = subprocess.run(
            [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", *SUITES, *options],
            cwd=project,
            env={name: text for name, text in os.environ.items() if not name.startswith("PYTEST_")},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
            check=False,
        )
    finally:
        signal.signal(signal.SIGINT, before)
    assert "INTERNALERROR" not in session.stdout
    return session.returncode, session.stdout, report(project)


@pytest.mark.parametrize(
    ("number", "run", "options"),
    [
        pytest.param(signal.SIGINT, IN_OTHERS, WITHOUT_XDIST, id="SIGINT in the tests of the others"),
        pytest.param(signal.SIGINT, IN_SECOND_GENERATION, A_WORKER, id="SIGINT in the second generation, on a worker"),
        pytest.param(signal.SIGTERM, IN_OTHERS, A_WORKER, id="SIGTERM in the tests of the others, on a worker"),
        pytest.param(signal.SIGTERM, IN_SECOND_GENERATION, WITHOUT_XDIST, id="SIGTERM in the second generation"),
    ],
)
def test_a_signal_leaves_a_report_with_what_was_reached(
    lamps: pytest.Pytester, number: signal.Signals, run: int, options: tuple[str, ...]
) -> None:
    kill(lamps.path, "session", number, (run,))
    status, output, whole = ended(lamps.path, *options)
    assert status == pytest.ExitCode.INTERRUPTED, output
    assert whole["closing"]["end_reason"] == "interrupted"
    if run > BY_HAND:
        assert whole["closing"]["initial_runs"] == BY_HAND
        assert 8 <= whole["closing"]["runs"] < 16
    assert whole["selected"] >= BY_HAND
    assert whole["reported"] == (whole["selected"] if number == signal.SIGINT else 0)


@pytest.mark.parametrize("options", PLACES.values(), ids=PLACES)
def test_a_loop_whose_process_was_killed_ends_as_one_unharmed(lamps: pytest.Pytester, options: tuple[str, ...]) -> None:
    unharmed = ended(lamps.path)[2]
    kill(lamps.path, "loop", signal.SIGKILL, (BY_HAND - 1, BY_HAND + 13))
    status, output, whole = ended(lamps.path, *options)
    assert status == 0
    assert len(re.findall("the process of the closing loop.* was lost: ended by SIGKILL", output)) == 2
    hashes = [{test["id"]: test["record_sha256"] for test in made["tests"]} for made in (whole, unharmed)]
    assert hashes[0] == hashes[1]
    assert whole["closing"] == unharmed["closing"]


@pytest.mark.parametrize("options", PLACES.values(), ids=PLACES)
def test_after_three_losses_the_loop_ends_with_what_it_has_and_all_else_goes_on(
    lamps: pytest.Pytester, options: tuple[str, ...]
) -> None:
    kill(lamps.path, "loop", signal.SIGKILL, tuple(range(BY_HAND + 10, 400)))
    status, output, whole = ended(lamps.path, *options)
    assert status == 0
    lost = "the loop ended early: the process that runs its tests was lost 3 times, the last time.*: ended by SIGKILL"
    assert re.search(f"hricdv: {lost}", output)
    notes = {suite["name"]: suite["generation"]["notes"] for suite in whole["suites"]}
    assert any(re.fullmatch(lost, note) for note in notes["closure"])
    assert (whole["closing"]["end_reason"], whole["closing"]["initial_runs"]) == ("error", BY_HAND)
    assert 8 <= whole["closing"]["runs"] < 16
    assert whole["reported"] == whole["selected"] > BY_HAND
