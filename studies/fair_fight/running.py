"""Run a tool on a code base up to the budget, and sum up its journal."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from studies import session
from studies.fair_fight import FOLDER, ROOT, CodeBase, meter
from studies.fair_fight.tools import Tool
from studies.fair_fight.world import KNOWN

LEAST_S = 3.0
"""With less of the budget left no further session is started: it could not run a test."""
PATIENCE = 8
"""Wall time of a session for the processor time it may take: on a shared machine it gets a part of a core."""


@dataclass
class Bout:
    """A tool on a code base.

    Args:
        tool: the tool.
        base: the code base.
        folder: of the code base, filled.
        journal: the file that its runs are noted in.
        python: the interpreter that it is installed for; empty: this one.
    """

    tool: Tool
    base: CodeBase
    folder: Path
    journal: Path
    python: str
    reason: str = ""
    """The last line of what the last session has printed."""

    def fight(self, budget_s: float) -> float:
        """Sessions with one seed after the other up to the budget. Returns the processor time that was used."""
        self.journal.unlink(missing_ok=True)
        used_s, seed = 0.0, 0
        while budget_s - used_s > LEAST_S:
            lines = len(self.runs())
            began_s = children_s()
            self._session(seed, used_s, budget_s)
            runs = self.runs()
            # Processes that were ended with others are not counted by the system, but by the meter.
            used_s = max(used_s + children_s() - began_s, runs[-1]["s"] if runs else 0.0)
            seed += 1
            if len(runs) == lines:
                break  # it runs nothing, and would run nothing again
        return used_s

    def _session(self, seed: int, used_s: float, budget_s: float) -> None:
        known = sorted({kind for run in self.runs() for kind in run["kinds"]})
        left_s = budget_s - used_s
        process = subprocess.Popen(
            [self.python or sys.executable, *self.tool.command(self.base, seed, known)],
            cwd=self.folder,
            env=environment(self.base, self.folder)
            | {
                meter.JOURNAL: str(self.journal),
                meter.BUDGET: str(budget_s),
                meter.BEFORE: str(used_s),
                KNOWN: "|".join(known),
                "PYTEST_ADDOPTS": "-W ignore::pytest.PytestAssertRewriteWarning",  # the meter is loaded before pytest
            },
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            start_new_session=True,  # the meter ends all of its processes
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (int(left_s) + 5, int(left_s) + 5)),
        )
        try:
            output, _ = process.communicate(timeout=PATIENCE * left_s + 60.0)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, 9)
            output, _ = process.communicate()
        self.reason = meter.plain(next(iter(output.strip().splitlines()[-1:]), ""))

    def runs(self) -> list[dict[str, Any]]:
        """The lines of the journal."""
        return read(self.journal)


def read(journal: Path) -> list[dict[str, Any]]:
    """The runs of a journal; a last line that was cut off is left out."""
    text = journal.read_text(encoding="utf-8") if journal.exists() else ""
    return [json.loads(line) for line in text.split("\n")[:-1]]


def environment(base: CodeBase, folder: Path) -> dict[str, str]:
    """The environment of a tool's process."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST_", "COV_", "FIGHT_"))}
    path = [folder, *(folder / each for each in base.python_path), ROOT, FOLDER / "start"]
    return {**kept, "PYTHONPATH": os.pathsep.join(map(str, path)), "PYTHONHASHSEED": "0"}


def machine(python: str) -> str:
    """As `session.machine`, with the version of the interpreter that the tools are installed for."""
    own = session.machine().rpartition(", ")[0]
    version = subprocess.run(
        [python or sys.executable, "-V"], capture_output=True, text=True, check=True
    ).stdout.strip()
    return f"{own}, {version}"


def summary(runs: Sequence[Mapping[str, Any]], statements: int, branches: int) -> dict[str, Any]:
    """The figures of a tool on a code base: totals are those of the code under test."""
    failing = [run for run in runs if run["kinds"]]
    return {
        "runs": len(runs),
        "statements": [_covered(runs, "statements"), statements],
        "branches": [_covered(runs, "branches"), branches],
        "kinds": dict(_kinds(failing)),
        "first_s": failing[0]["s"] if failing else None,
        "shortest": min((run["actions"] for run in failing), default=None),
    }


def _covered(runs: Sequence[Mapping[str, Any]], key: str) -> int:
    bits = 0
    for run in runs:
        bits |= int(run[key], 16)
    return bits.bit_count()


def _kinds(failing: Sequence[Mapping[str, Any]]) -> Iterator[tuple[str, dict[str, float]]]:
    """Kind of violation -> when it was found first, and in how many actions at least."""
    for kind in sorted({kind for run in failing for kind in run["kinds"]}):
        those = [run for run in failing if kind in run["kinds"]]
        yield kind, {"first_s": those[0]["s"], "shortest": min(run["actions"] for run in those)}


def children_s() -> float:
    """Processor time of all children that have ended."""
    time.sleep(0.05)  # until a session that was killed has been waited for
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime
