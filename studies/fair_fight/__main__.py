"""Several tools on the same code, with the same world, requirements, faults and processor time.

    python -m studies.fair_fight --work FOLDER                        # all; what is in results.json is not run again
    python -m studies.fair_fight --work FOLDER --only table/rl,tello  # a row, or a code base
    python -m studies.fair_fight --work FOLDER --only table/rl --budget 60 --results ROWS.json  # that row again
    python -m studies.fair_fight --page                               # write the page from results.json

`--python` names the interpreter of an environment with this project, Hypothesis, HypoFuzz, Atheris and CrossHair,
`--pynguin` that of one with Pynguin. Code bases, clones and journals are kept in the folder.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv._base import atomic_file
from pytest_hricdv.coverage.code_map import CodeMap
from studies.fair_fight import CODE_BASES, FOLDER, CodeBase, faults, tables, unit_tests
from studies.fair_fight.replaying import noticed
from studies.fair_fight.running import Bout, machine, summary
from studies.fair_fight.tables import PYNGUIN, TITLES
from studies.fair_fight.tools import TOOLS
from studies.page import replace_figures

RESULTS = FOLDER / "results.json"
PAGE = FOLDER.parents[1] / "docs" / "studies" / "fair-fight.md"
COMMAND = "python -m studies.fair_fight --page"
BUDGET_S = 300.0
"""Nine tools with 600 s on three code bases would take more than two hours on two cores."""


def main() -> None:
    """Run, store, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, metavar="FOLDER", help="of code bases, clones and journals")
    parser.add_argument("--python", default="", metavar="FILE", help="that has the tools (this one)")
    parser.add_argument("--pynguin", default="", metavar="FILE", help="that has Pynguin (without it: not run)")
    parser.add_argument("--only", default="", metavar="KEYS", help="such as table,tello/rl")
    parser.add_argument("--budget", type=float, default=BUDGET_S, metavar="SECONDS", help="of processor time (300)")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FILE", help="that rows are stored in")
    parser.add_argument("--seal", action="store_true", help="draw the faults, which is done once")
    parser.add_argument("--page", action="store_true", help="write the page")
    options = parser.parse_args()
    if options.work is not None:
        only = list(filter(None, options.only.split(",")))
        for base in CODE_BASES:
            if not only or any(key.partition("/")[0] == base.name for key in only):
                _measure(base, only, options)
    if options.page:
        replace_figures(PAGE, COMMAND, tables.figures(read(options.results)))


def read(path: Path = RESULTS) -> dict[str, Any]:
    """The results so far: "code base/tool" -> its row."""
    results: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return results


def _measure(base: CodeBase, only: Sequence[str], options: argparse.Namespace) -> None:
    work, path = options.work.resolve(), options.results
    folder = work / base.name
    base.fill(folder, work / "clones")
    code = base.map(folder)
    if options.seal:
        _seal(base, folder, code)
        return
    chosen = [name for name in TITLES if not only or base.name in only or f"{base.name}/{name}" in only]
    _check_budget(path, base, options.budget)
    journals: dict[str, Path] = {}
    for tool in (tool for tool in TOOLS if tool.name in chosen):
        key, journal = f"{base.name}/{tool.name}", work / f"{base.name}-{tool.name}.jsonl"
        if key not in read(path):
            print(key, "...", flush=True)
            _store(path, key, _fight(Bout(tool, base, folder, journal, options.python), code, options.budget))
        if journal.exists() and "noticed" not in read(path)[key]:
            journals[key] = journal
    for key, found in noticed(base, work, journals, options.python).items() if journals else ():
        _store(path, key, {**read(path)[key], **found})
    key = f"{base.name}/{PYNGUIN}"
    if options.pynguin and PYNGUIN in chosen and key not in read(path):
        print(key, "...", flush=True)
        _store(path, key, unit_tests.measure(base, work, options.pynguin, options.python, options.budget))


def _check_budget(path: Path, base: CodeBase, budget_s: float) -> None:
    """A table has one budget."""
    for key, row in read(path).items():
        if key.startswith(f"{base.name}/") and row["budget_s"] != budget_s:
            raise SystemExit(f"{path}: {key} had {row['budget_s']:.0f} s, not {budget_s:.0f} s: give other --results")


def _seal(base: CodeBase, folder: Path, code: CodeMap) -> None:
    sealed = json.loads(faults.KEPT.read_text(encoding="utf-8")) if faults.KEPT.exists() else {}
    text = json.dumps({**sealed, base.name: faults.draw(folder, code)}, indent=1)
    atomic_file.write_text(faults.KEPT, text + "\n")


def _fight(bout: Bout, code: CodeMap, budget_s: float) -> dict[str, Any]:
    used_s = bout.fight(budget_s)
    row = {"budget_s": budget_s, "used_s": round(used_s, 1), "machine": machine(bout.python)}
    row |= summary(bout.runs(), code.statements, code.branches)
    reason = "no run ended within the budget" if used_s >= budget_s else bout.reason
    return row if row["runs"] else {**row, "not_run": reason}


def _store(path: Path, key: str, row: dict[str, Any]) -> None:
    order = [f"{base.name}/{name}" for base in CODE_BASES for name in TITLES]
    rows = {**read(path), key: row}
    text = json.dumps({each: rows[each] for each in order if each in rows}, indent=1)
    atomic_file.write_text(path, text + "\n")
    print("   ", {name: row[name] for name in row if name not in ("machine", "noticed")}, flush=True)


if __name__ == "__main__":
    main()
