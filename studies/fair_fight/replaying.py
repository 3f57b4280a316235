"""Replays the inputs of tools on code with a fault: `replaying CODE_BASE SECONDS JOURNAL...` in its folder.

Prints a line of JSON for each journal: how many inputs were run, and what the first that notices the fault violates.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv.generate.concrete import ConcreteTest
from studies.fair_fight import CodeBase, faults, meter
from studies.fair_fight.meter import plain
from studies.fair_fight.running import environment, read
from studies.fair_fight.world import World


def ordered(runs: Sequence[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    """Those first that covered something new when they were made, then the others."""
    statements = branches = 0
    others, seen = [], set()
    for run in runs:
        if run["test"] in seen:
            continue
        seen.add(run["test"])
        more, further = statements | int(run["statements"], 16), branches | int(run["branches"], 16)
        if (more, further) == (statements, branches):
            others.append(run)
        else:
            yield run
        statements, branches = more, further
    yield from others


def replay(world: World, journal: Path, seconds: float) -> dict[str, Any]:
    """Run the inputs of a journal until one notices the fault, or for so much processor time."""
    began_s, count = time.process_time(), 0
    for run in ordered(read(journal)):
        if time.process_time() - began_s > seconds:
            break
        count += 1
        try:
            new = {*meter.kinds(world.run(ConcreteTest.from_json(run["test"])))} - {*run["kinds"]}
        except Exception as error:  # a fault may be such that a run cannot be finished
            new = {f"{type(error).__name__} of the run"}
        if new:
            return {"runs": count, "noticed": sorted(new)}
    return {"runs": count, "noticed": []}


def noticed(base: CodeBase, work: Path, journals: Mapping[str, Path], python: str) -> dict[str, dict[str, Any]]:
    """Plant each sealed fault and replay the journals; first without a fault, as a control.

    Returns:
        For each journal: what the control violates anew (nothing where runs repeat), and fault -> what notices it.
    """
    found: dict[str, dict[str, Any]] = {key: {"control": [], "noticed": {}} for key in journals}
    for fault in (None, *faults.sealed(base.name)):
        folder = work / f"{base.name}-faulty"
        base.fill(folder, work / "clones")
        if fault is not None:
            faults.plant(fault, folder)
        print("   ", base.name, fault["id"] if fault else "without a fault", end=" ", flush=True)
        for key, line in zip(journals, _replayed(base, folder, [*journals.values()], python), strict=True):
            print(len(line["noticed"]), end=" ", flush=True)
            if fault is None:
                found[key]["control"] = line["noticed"]
            else:
                found[key]["noticed"][fault["id"]] = line["noticed"]
        print(flush=True)
    return found


def _replayed(base: CodeBase, folder: Path, journals: Sequence[Path], python: str) -> list[dict[str, Any]]:
    command = [python or sys.executable, "-m", "studies.fair_fight.replaying", base.name, str(base.replay_s)]
    done = subprocess.run(
        [*command, *map(str, journals)],
        cwd=folder,
        env=environment(base, folder),
        capture_output=True,
        text=True,
        check=False,
    )
    if done.returncode:  # the code cannot even be imported: whoever runs it notices that
        return [{"runs": 0, "noticed": [plain(done.stderr.strip().splitlines()[-1])]} for _ in journals]
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"runs"')]


def main() -> None:
    """One journal after the other, each in a process of its own."""
    name, seconds, journals = sys.argv[1], float(sys.argv[2]), sys.argv[3:]
    world = World.here(name, measured=False)
    for journal in journals:
        sys.stdout.flush()
        if (child := os.fork()) == 0:
            print(json.dumps(replay(world, Path(journal), seconds)), flush=True)
            os._exit(0)
        if os.waitpid(child, 0)[1]:
            print(json.dumps({"runs": 0, "noticed": ["the process ended"]}))


if __name__ == "__main__":
    main()
