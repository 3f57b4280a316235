"""Which planted faults a draft notices, with the first ten requirements that are suggested for it accepted.

    python -m studies.draft_kills porter vacuum                   # of these code bases of studies.drafts (many minutes)
    python -m studies.draft_kills home-care --faults=40 --switches  # with the published faults of its code
    python -m studies.draft_kills dance --ros2-packages FOLDER     # of public nodes of ROS 2, cloned into a folder
    python -m studies.draft_kills vacuum --keep=FOLDER             # drafts and their reports stay there

Needs the extra `mutation`, and `transitions` for the porter. Faults are drawn with seed 0 among all mutants, those that
no test executes included: the share is of all that were drawn, and is noted for docs/studies/drafts.md.
"""

from __future__ import annotations

import argparse
import datetime
import json
import os
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from studies.code_bases import CodeBase
from studies.draft_table import note, write_page
from studies.drafts import chosen

SUITES = "rl,closure"
"""The suites that faults are tried on: those that a draft is made to be green with."""

MOST = 10
"""Suggestions that are accepted."""


def kills(code: CodeBase, folder: Path, faults: int, switches: bool) -> Iterator[str]:
    """Lines on one code base: what was suggested, what was noticed, and what survived, by operator."""
    target = folder / f"draft-of-{code.key}"
    made = [sys.executable, "-m", "pytest_hricdv", "init", str(target), *code.asked]
    subprocess.run(made, cwd=code.folder, check=True, capture_output=True)
    alone = _mutation(_report(target, "--hri-suggest", f"--hri-suggest-most={MOST}", f"--hri-suggest-faults={faults}",
                              "--hri-mutate", f"--hri-mutate-faults={faults}"))  # fmt: skip
    yield f"{code.key}: {_accept(target, _read(target))} suggestions accepted"
    # Faults are drawn in one order, so the first ones are those that suggestions were ranked by.
    every = _mutation(_report(target, "--hri-mutate", f"--hri-mutate-faults={2 * faults}"))
    ranking = [mutant for mutant in every if mutant["id"] in {other["id"] for other in alone}]
    others = [mutant for mutant in every if mutant not in ranking]
    note(code, {"faults": _noticed(others), "ranking_faults": _noticed(ranking), "alone": _noticed(alone)})
    for which, mutants in (("the draft alone", alone), ("ranked by them", ranking), ("other faults", others)):
        noticed, drawn = _noticed(mutants)
        yield f"{code.key}, {which}: {noticed} of {drawn} faults noticed ({100 * noticed / max(1, drawn):.0f} %)"
    left = Counter((mutant["status"], mutant["operator"]) for mutant in every if mutant["status"] != "killed")
    for (status, operator), count in left.most_common():
        yield f"{code.key}:   {status}, {operator}: {count}"
    for switch in code.switches if switches else ():
        found = _report(target, environment={code.switch: switch})
        failed = sum(test["outcome"] == "failed" for test in found["tests"])
        yield f"{code.key}: published fault {switch}: {'noticed' if failed else 'not noticed'} ({failed} tests fail)"


def _mutation(report: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The faults that were tried."""
    return list(report["mutation"]["mutants"]) if report.get("mutation") else []


def _noticed(mutants: Sequence[Mapping[str, Any]]) -> list[int]:
    """How many are noticed, and of how many."""
    return [sum(mutant["status"] == "killed" for mutant in mutants), len(mutants)]


def _report(folder: Path, *options: str, environment: Mapping[str, str] | None = None) -> dict[str, Any]:
    """The report of a session of a draft."""
    command = [sys.executable, "-m", "pytest", "-q", f"--hri-suite={SUITES}", "--hri-audit=off", *options]
    subprocess.run(command, cwd=folder, capture_output=True, check=False, env={**os.environ, **(environment or {})})
    return _read(folder)


def _read(folder: Path) -> dict[str, Any]:
    report: dict[str, Any] = json.loads((folder / "hri-report" / "report.json").read_text(encoding="utf-8"))
    return report


def _accept(folder: Path, report: Mapping[str, Any]) -> int:
    """Paste what was suggested, as accepted by this study; how many there were."""
    result = report.get("suggestions") or {"suggestions": []}
    lines = []
    for one in result["suggestions"][:MOST]:
        lines += ["", f"[{one['id']}]", f"title = {json.dumps(one['title'], ensure_ascii=False)}",
                  f"formula = {json.dumps(one['formula'], ensure_ascii=False)}",
                  'suggested = "from runs of this study"',
                  'accepted_by = "studies.draft_kills"', f"accepted_on = {datetime.date.today()}"]  # fmt: skip
    with (folder / "requirements.toml").open("a", encoding="utf-8") as file:
        file.write("\n".join(lines) + "\n")
    return len(result["suggestions"][:MOST])


def main() -> None:
    """Measure, and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("keys", nargs="*", metavar="CODE", help="which code bases (default: all)")
    parser.add_argument("--faults", type=int, default=60, help="so many faults of each, drawn with seed 0")
    parser.add_argument("--ros2-packages", type=Path, metavar="FOLDER", help="of repositories, cloned where missing")
    parser.add_argument("--keep", type=Path, metavar="FOLDER", help="where drafts stay (default: nowhere)")
    parser.add_argument("--switches", action="store_true", help="and the published faults of the code")
    options = parser.parse_args()
    if options.keep is not None and options.keep.exists():
        parser.error(f"--keep: {options.keep} exists; expected a folder to be made")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if options.keep is not None:
            folder = options.keep.resolve()
            folder.mkdir(parents=True)
        for code in chosen(folder, options.ros2_packages, options.keys):
            for line in kills(code, folder, options.faults, options.switches):
                print(line, flush=True)
    write_page()


if __name__ == "__main__":
    main()
