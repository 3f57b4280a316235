"""Let other explorers of schedules find the anchors, each in an environment of its own; write a table to the page.

    python -m studies.races.peers [--newer PYTHON] [--page]

What they find is kept in `peers.json`, with the processor time of a session of ours. They are installed from PyPI.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from textwrap import fill
from typing import Any

from studies.page import duration, replace_figures, table
from studies.races.__main__ import PAGE, fails, first, search_races
from studies.races.catalogue import ANCHORS, Race

HERE = Path(__file__).parent
RESULTS = HERE / "peers.json"
COMMAND = "python -m studies.races.peers"

TOOLS = {
    "frontrun": "frontrun, by classes",
    "frontrun-random": "frontrun, at random",
    "detangle": "detangle",
    "simloom": "simloom",
}
"""What is run -> the head of its column."""

VERSIONS = {"frontrun": "0.7.0", "detangle": "0.1.0", "simloom": "0.5.0"}

PROPERTIES = (
    ("what is run", "the robot, with a person", "functions of threads or tasks", "tasks", "tasks"),
    ("written for each race", "a formula", "a model, an invariant", "a model, an assertion", "a model, an assertion"),
    ("switches", "at statements", "**at each access**", "at `await`", "at `await`"),
    ("can say that there is none", "no", "**yes**, within bounds", "**yes**, within bounds", "**yes**, within bounds"),
    ("executors of ROS 2", "**yes**", "no", "no", "no"),
    ("other processes, networks, disks", "late messages", "**SQL, Redis, sockets**", "**networks**", "**both**"),
    ("order told from delay", "**yes**", "no", "no", "no"),
)
"""Of the four; bold is what one has and this search lacks, or the other way round."""


def main() -> None:
    """Run all, and write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--page", action="store_true", help="write the table of what is stored")
    parser.add_argument("--newer", default="python3.12", metavar="PYTHON", help="Python 3.12 or newer, for simloom")
    options = parser.parse_args()
    if sys.version_info[:2] != (3, 11):
        parser.error("expected Python 3.11, whose asyncio has two of the races")
    if not options.page:
        lines = ",\n".join(
            f"{json.dumps(key)}: {json.dumps(value)}" for key, value in _explore_all(options.newer).items()
        )
        RESULTS.write_text(f"{{\n{lines}\n}}\n", encoding="utf-8")
    results, ours = (json.loads(path.read_text(encoding="utf-8")) for path in (RESULTS, HERE / "results.json"))
    replace_figures(PAGE, COMMAND, tables(results, ours))


def _explore_all(newer: str) -> dict[str, Any]:
    results: dict[str, Any] = {}
    with tempfile.TemporaryDirectory() as folder:
        for tool in TOOLS:
            results[tool] = explore(tool, newer if tool == "simloom" else sys.executable, Path(folder))
            print(tool, results[tool]["version"], flush=True)
    results["here"] = {race.name: round(_session_s(race), 1) for race in ANCHORS}
    return results


def explore(tool: str, python: str, folder: Path) -> dict[str, Any]:
    """What a tool finds, in an environment in this folder."""
    package = tool.partition("-")[0]
    environment = folder / package
    if not environment.exists():
        _run(python, "-m", "venv", str(environment))
        _run(str(environment / "bin" / "pip"), "install", "-q", f"{package}=={VERSIONS[package]}")
    own = str(environment / "bin" / "python")
    # Only its own command prepares a process for frontrun.
    begin = [str(environment / "bin" / "frontrun"), own] if package == "frontrun" else [own]
    old_asyncio = Path(asyncio.__file__).parent
    made: dict[str, Any] = json.loads(
        _run(*begin, str(HERE / "peer_models.py"), tool, str(old_asyncio)).splitlines()[-1]
    )
    return made


def _run(*command: str) -> str:
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def _session_s(race: Race) -> float:
    """Processor time (s), which says the same on a busy machine."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    search_races(race, 0, 100)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def tables(results: Mapping[str, Any], ours: Mapping[str, Any]) -> str:
    """What each finds, then what each is."""
    rows = [_row(race, results, ours) for race in ANCHORS]
    figures = table(("race", "here", *TOOLS.values(), "lines of the model"), rows)
    versions = ", ".join(f"{package} {version}" for package, version in VERSIONS.items())
    twins = [model["repaired"][0] for tool in TOOLS for model in results[tool]["models"].values()]
    bench = sum(
        bool(line.strip())
        for file in sorted((HERE / "bench").iterdir())
        if file.is_file()
        for line in file.read_text(encoding="utf-8").splitlines()
    )
    above = (
        f"{versions}, each on models that are as small as its documentation suggests. Of 20 seeds, how many found the "
        "race within 100 runs; the median run; the processor time of a search, here of a session at one seed. frontrun "
        f"goes through equivalent classes without a seed. {sum(twins)} of {len(twins)} repaired models fail."
    )
    below = (
        "On models, the others take a hundredth to a thousandth of the time, need fewer runs where several decisions "
        "are needed (`three_tools`, `lost_notify`), and frontrun goes through all classes of the repaired ones. Here, "
        f"a testbench of {bench} lines is shared by all robots, and the robot itself is run."
    )
    properties = table(("", "here", "frontrun", "detangle", "simloom"), PROPERTIES)
    return "\n\n".join(("### Other explorers", fill(above, 130), figures, fill(below, 130), properties))


def _row(race: Race, results: Mapping[str, Any], ours: Mapping[str, Any]) -> Sequence[str]:
    searched = [races for key, races in ours.items() if key.startswith(f"{race.name} robot ")]
    found = [first(races) for races in searched if fails(races)]
    here = _cell(len(found), len(searched), found, results["here"][race.name], duration)
    models = [results[tool]["models"].get(race.name) for tool in TOOLS]
    lines = next((str(model["lines"]) for model in models if model is not None), "-")
    return race.name, here, *map(_cell_of, models), lines


def _cell_of(model: Mapping[str, Any] | None) -> str:
    if model is None:
        return "-"
    runs = [run for is_found, run in model["found"] if is_found]
    return _cell(len(runs), len(model["found"]), runs, model["cpu_s"], lambda cpu_s: f"{1000 * cpu_s:.0f} ms")


def _cell(found: int, of: int, runs: Sequence[int], cpu_s: float, show: Callable[[float], str]) -> str:
    share = f"{found} of {of}, " if of > 1 else ""
    return f"{share}run {median(runs):g}, {show(cpu_s)}" if runs else f"{share}-, {show(cpu_s)}"


if __name__ == "__main__":
    main()
