"""Run public packages with small testbenches, and list what was found in them.

    python -m studies.wild --clones FOLDER                  # all; what is in results.json already is not run again
    python -m studies.wild --clones FOLDER --only vel_mux   # one of them
    python -m studies.wild --known --clones FOLDER          # the known bugs of known.toml, into known.json
    python -m studies.wild --page                           # write the page from results.json and known.json

The packages are cloned at fixed commits into the folder, and run there: `cd FOLDER/vel_mux; pytest` repeats a row.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pytest_hricdv._base import atomic_file
from studies import session
from studies.code_bases.ros2 import FetchError
from studies.page import replace_figures
from studies.wild import FOLDER, packages
from studies.wild.known import known_bugs, measure_known
from studies.wild.running import measure
from studies.wild.tables import figures, known_figures

RESULTS = FOLDER / "results.json"
KNOWN = FOLDER / "known.json"
PAGE = FOLDER.parents[1] / "docs" / "studies" / "wild.md"
COMMAND = "python -m studies.wild --page"
KNOWN_COMMAND = "python -m studies.wild --known --page"


def main() -> None:
    """Run, store, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clones", type=Path, metavar="FOLDER", help="of the packages, cloned where missing")
    parser.add_argument("--only", default="", metavar="KEYS", help="of some packages, such as vel_mux,tello")
    parser.add_argument("--again", action="store_true", help="run also those that have a result")
    parser.add_argument("--known", action="store_true", help="the known bugs, not the packages")
    parser.add_argument("--page", action="store_true", help="write the page")
    options = parser.parse_args()
    only = list(filter(None, options.only.split(",")))
    if options.clones is not None:
        clones = options.clones.resolve()
        if options.known:
            bugs = {bug.key: bug for bug in known_bugs()}
            inputs = {key: bug.fingerprint() for key, bug in bugs.items()}
            _measure_all(KNOWN, inputs, lambda key: measure_known(bugs[key], clones), only, again=options.again)
        else:
            every = {package.key: package for package in packages()}
            inputs = {key: package.fingerprint() for key, package in every.items()}
            _measure_all(RESULTS, inputs, lambda key: measure(every[key], clones), only, again=options.again)
    if options.page:
        replace_figures(PAGE, COMMAND, figures(read(RESULTS), [*packages()]))
        replace_figures(PAGE, KNOWN_COMMAND, known_figures(read(KNOWN), [*known_bugs()]))


def read(path: Path) -> dict[str, Any]:
    """The results so far: key of a package or bug -> its row."""
    results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return results


def _measure_all(
    path: Path, inputs: dict[str, str], run: Callable[[str], dict[str, Any]], only: list[str], *, again: bool
) -> None:
    """Run those that have no result of the same testbench and commit, and store each."""
    for key, fingerprint in inputs.items():
        if (only and key not in only) or (not again and read(path).get(key, {}).get("input") == fingerprint):
            continue
        print(f"{key} ...", flush=True)
        try:
            row = run(key)
        except (FetchError, session.SessionError) as error:
            print(error)
            continue
        rows = {**read(path), key: row}
        atomic_file.write_text(path, json.dumps({each: rows[each] for each in inputs if each in rows}, indent=1) + "\n")
        for each in row.get("violations", ()):
            print("   ", *each["requirements"], each["seen"])


if __name__ == "__main__":
    main()
