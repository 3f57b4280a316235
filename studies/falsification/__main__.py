"""How many simulations falsify the Chasing Cars of ARCH-COMP.

python -m studies.falsification                 # all searches; what is in results.json is not run again
python -m studies.falsification --only CC1      # of one requirement
python -m studies.falsification --page          # write the page from results.json
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from statistics import fmean, median
from typing import Any

from pytest_hricdv._base import atomic_file
from studies.falsification.search import METHODS, REQUIREMENTS
from studies.page import replace_figures, table

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "results.json"
PAGE = FOLDER.parents[1] / "docs" / "studies" / "falsification.md"
COMMAND = "python -m studies.falsification --page"
SEEDS = range(20)

PUBLISHED = {
    "CC1": (("FalCAuN, 2023", 10, 10, 229.2, 214.0), ("FalCAuN, 2024", 10, 10, 396.0, 396.0)),
    "CC2": (("FalCAuN, 2023", 10, 10, 119.0, 119.0), ("FalCAuN, 2024", 10, 10, 76.0, 76.0)),
}
"""Of others, from what they keep of the competitions: who, falsified, of how many, mean, median."""


def main() -> None:
    """Run, store, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="REQUIREMENT", help="such as CC1")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FILE", help="that rows are stored in")
    parser.add_argument("--page", action="store_true", help="only write the page")
    options = parser.parse_args()
    if not options.page:
        for requirement in REQUIREMENTS:
            if options.only in ("", requirement.id):
                for name in METHODS:
                    _measure(requirement.id, name, options.results)
    replace_figures(PAGE, COMMAND, figures(read(options.results)))


def read(path: Path = RESULTS) -> dict[str, Any]:
    """The results so far: "requirement/method" -> how each seed ended."""
    results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return results


def _measure(requirement_id: str, name: str, path: Path) -> None:
    key = f"{requirement_id}/{name}"
    if key in read(path):
        return
    requirement = next(each for each in REQUIREMENTS if each.id == requirement_id)
    found = [METHODS[name][1](requirement, seed) for seed in SEEDS]
    simulations, falsified = [each.simulations for each in found], [each.violated for each in found]
    print(key, simulations, sum(falsified), flush=True)
    rows = {**read(path), key: {"simulations": simulations, "falsified": falsified}}
    order = [f"{each.id}/{method}" for each in REQUIREMENTS for method in METHODS]
    lines = ",\n".join(f' "{each}": {json.dumps(rows[each])}' for each in order if each in rows)
    atomic_file.write_text(path, f"{{\n{lines}\n}}\n")


def figures(rows: Mapping[str, Any]) -> str:
    """A table for each requirement, as Markdown."""
    head = ("how", "falsified", "simulations: mean", "median")
    parts = []
    for requirement in REQUIREMENTS:
        parts.append(f"### {requirement.id}: `{requirement.title}`")
        parts.append(f"Here: `{requirement.text}`")
        parts.append(table(head, _rows(requirement.id, rows)))
    return "\n\n".join(parts)


def _rows(requirement: str, rows: Mapping[str, Any]) -> Iterator[tuple[object, ...]]:
    for name, (title, _) in METHODS.items():
        if row := rows.get(f"{requirement}/{name}"):
            needed = [count for count, done in zip(row["simulations"], row["falsified"], strict=True) if done]
            yield title, *_summary(len(needed), len(row["falsified"]), needed)
    for who, falsified, of, mean, middle in PUBLISHED.get(requirement, ()):
        yield who, f"{falsified} of {of}", f"{mean:.0f}", f"{middle:.0f}"


def _summary(falsified: int, of: int, needed: list[int]) -> tuple[str, str, str]:
    if not needed:
        return f"0 of {of}", "-", "-"
    return f"{falsified} of {of}", f"{fmean(needed):.0f}", f"{median(needed):.0f}"


if __name__ == "__main__":
    main()
