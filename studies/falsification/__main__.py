"""How many simulations falsify the Chasing Cars and the F16 of ARCH-COMP.

python -m studies.falsification                 # all searches; what is in results.json is not run again
python -m studies.falsification --f16 FOLDER    # with those of the F16, by a clone of AeroBenchVVPython
python -m studies.falsification --only CC1      # of one requirement
python -m studies.falsification --page          # write the page from results.json
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from statistics import fmean, median
from typing import Any

from pytest_hricdv._base import atomic_file
from studies.falsification import f16
from studies.falsification.search import CARS, METHODS, FalsificationProblem
from studies.page import replace_figures, table

FOLDER = Path(__file__).parent
RESULTS = FOLDER / "results.json"
PAGE = FOLDER.parents[1] / "docs" / "studies" / "falsification.md"
COMMAND = "python -m studies.falsification --page"
SEEDS = range(20)
REQUIREMENTS = (*(problem.requirement for problem in CARS), f16.REQUIREMENT)
SURVEY = "F16/survey"

PUBLISHED = {
    "CC1": (("FalCAuN, 2023", 10, 10, 229.2, 214.0), ("FalCAuN, 2024", 10, 10, 396.0, 396.0)),
    "CC2": (("FalCAuN, 2023", 10, 10, 119.0, 119.0), ("FalCAuN, 2024", 10, 10, 76.0, 76.0)),
}
"""Of others, from what they keep of the competitions: who, falsified, of how many, mean, median."""


def main() -> None:
    """Run, store, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default="", metavar="REQUIREMENT", help="such as CC1")
    parser.add_argument("--f16", type=Path, metavar="FOLDER", help="clone of AeroBenchVVPython, see the page")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FILE", help="that rows are stored in")
    parser.add_argument("--page", action="store_true", help="only write the page")
    options = parser.parse_args()
    if not options.page:
        _run(options.f16, options.only, options.results)
    replace_figures(PAGE, COMMAND, figures(read(options.results)))


def _run(clone: Path | None, only: str, path: Path) -> None:
    fly = None if clone is None else f16.flight(clone)
    if fly is None:
        print(f"F16: left out, as there is no --f16=FOLDER, a clone of {f16.SOURCE} at {f16.COMMIT}")
    elif only in ("", "F16"):
        _keep(SURVEY, lambda: [list(row) for row in f16.survey(fly)], path)
    for problem in (*CARS, *([f16.falsification_problem(fly)] if fly else [])):
        if only in ("", problem.requirement.id):
            for method in METHODS:
                _keep(f"{problem.requirement.id}/{method}", partial(_search, problem, method), path)


def read(path: Path = RESULTS) -> dict[str, Any]:
    """The results so far: "requirement/method" -> how each seed ended."""
    results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return results


def _search(problem: FalsificationProblem, method: str) -> dict[str, Any]:
    outcomes = [METHODS[method][1](problem, seed) for seed in SEEDS]
    return {
        "simulations": [outcome.simulations for outcome in outcomes],
        "falsified": [outcome.violated for outcome in outcomes],
    }


def _keep(key: str, measure: Callable[[], Any], path: Path) -> None:
    """Measure what the results do not have yet."""
    if key in read(path):
        return
    rows = {**read(path), key: measure()}
    print(key, json.dumps(rows[key]), flush=True)
    order = [*(f"{requirement.id}/{method}" for requirement in REQUIREMENTS for method in METHODS), SURVEY]
    lines = ",\n".join(f' "{name}": {json.dumps(rows[name])}' for name in order if name in rows)
    atomic_file.write_text(path, f"{{\n{lines}\n}}\n")


def figures(rows: Mapping[str, Any]) -> str:
    """A table for each requirement, as Markdown."""
    head = ("how", "falsified", "simulations: mean", "median")
    parts = []
    for requirement in REQUIREMENTS:
        parts.append(f"### {requirement.id}: `{requirement.title}`")
        parts.append(f"Here: `{requirement.text}`")
        parts.append(table(head, _rows(requirement.id, rows)))
    parts.append("### F16: how low it gets")
    parts.append(table(("from (ft)", "step (s)", "lowest altitude (ft)", "crashes"), _survey(rows.get(SURVEY, ()))))
    return "\n\n".join(parts)


def _rows(requirement: str, rows: Mapping[str, Any]) -> Iterator[tuple[object, ...]]:
    for name, (title, _) in METHODS.items():
        if row := rows.get(f"{requirement}/{name}"):
            needed = [count for count, done in zip(row["simulations"], row["falsified"], strict=True) if done]
            yield title, *_summary(len(needed), len(row["falsified"]), needed)
    for who, falsified, of, mean, middle in PUBLISHED.get(requirement, ()):
        yield who, f"{falsified} of {of}", f"{mean:.0f}", f"{middle:.0f}"


def _survey(rows: Iterable[tuple[float, float, float, int, int]]) -> Iterator[tuple[object, ...]]:
    for start_ft, step_s, lowest_ft, crashes, points in rows:
        yield start_ft, f"1/{1 / step_s:.0f}", f"{lowest_ft:.1f}", f"{crashes} of {points}"


def _summary(falsified: int, of: int, needed: list[int]) -> tuple[str, str, str]:
    if not needed:
        return f"0 of {of}", "-", "-"
    return f"{falsified} of {of}", f"{fmean(needed):.0f}", f"{median(needed):.0f}"


if __name__ == "__main__":
    main()
