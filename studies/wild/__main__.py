"""Run public packages with small testbenches, and list what was found in them.

    python -m studies.wild --clones FOLDER                  # all; what is in results.json already is not run again
    python -m studies.wild --clones FOLDER --only vel_mux   # one of them
    python -m studies.wild --page                           # write the page from results.json

The packages are cloned at fixed commits into the folder, and run there: `cd FOLDER/vel_mux; pytest` repeats a row.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from pytest_hricdv._base import atomic_file
from studies import session
from studies.code_bases.ros2 import FetchError
from studies.page import replace_figures
from studies.wild import FOLDER, Package, chosen, packages
from studies.wild.running import measure
from studies.wild.tables import figures

RESULTS = FOLDER / "results.json"
PAGE = FOLDER.parents[1] / "docs" / "studies" / "wild.md"
COMMAND = "python -m studies.wild --page"


def main() -> None:
    """Run, store, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clones", type=Path, metavar="FOLDER", help="of the packages, cloned where missing")
    parser.add_argument("--only", default="", metavar="KEYS", help="of some packages, such as vel_mux,tello")
    parser.add_argument("--again", action="store_true", help="run also those that have a result")
    parser.add_argument("--page", action="store_true", help="write the page")
    options = parser.parse_args()
    only = list(filter(None, options.only.split(",")))
    if options.clones is not None:
        for package in chosen(packages(), only):
            _measure(package, options.clones.resolve(), options.again)
    if options.page:
        replace_figures(PAGE, COMMAND, figures(read(), [*packages()]))


def read() -> dict[str, Any]:
    """The results so far: key of a package -> its row."""
    results: dict[str, Any] = json.loads(RESULTS.read_text(encoding="utf-8")) if RESULTS.exists() else {}
    return results


def _measure(package: Package, clones: Path, again: bool) -> None:
    """Run a package, unless it has a result of the same testbench and commit; store it."""
    if not again and read().get(package.key, {}).get("input") == package.fingerprint():
        return
    print(f"{package.key} ...", flush=True)
    try:
        row = measure(package, clones)
    except (FetchError, session.SessionError) as error:
        print(error)
        return
    order = [each.key for each in packages()]
    rows = {**read(), package.key: row}
    text = json.dumps({key: rows[key] for key in order if key in rows}, indent=1)
    atomic_file.write_text(RESULTS, text + "\n")
    for each in row.get("violations", ()):
        print("   ", *each["requirements"], each["seen"])


if __name__ == "__main__":
    main()
