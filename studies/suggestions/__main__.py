"""Study: what is suggested from runs of three testbenches without requirements (docs/studies/suggestions.md).

    python -m studies.suggestions [--only coffee,vacuum,table] [--folder DIR] [--again]

A session for each: the robots of the two tutorials in folders of their own, and the table. The table's takes half an
hour on two cores. Each leaves its report in DIR (default hri-suggestions); one that is there is not made again: end the
command at any time, and start it anew. `--again` makes none, and writes the page of what is there.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from pytest_hricdv.extra.suggestion.records import SUGGESTIONS, SuggestionResult
from pytest_hricdv.results.codec import load
from pytest_hricdv.results.model import Report
from studies import page
from studies.examples import blocks_of, write_files

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "studies" / "suggestions.md"
COMMAND = "python -m studies.suggestions"


@dataclass(frozen=True)
class Project:
    """A testbench: its page in docs/ (empty: the project itself), its host test, and options of the command."""

    page: str
    test: str
    options: tuple[str, ...] = field(default=())


PROJECTS: Mapping[str, Project] = {
    "coffee": Project("tutorial.md", "test_coffee.py", ("--suite=rl",)),
    "vacuum": Project("vacuum.md", "test_vacuum.py"),
    "table": Project("", "tests/hri/test_table_assembly.py", ("--suite=rl", "--tests=40")),
}


def main() -> None:
    """Run what is missing; write the figures of the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", default=",".join(PROJECTS), help="some of coffee, vacuum, table")
    parser.add_argument("--folder", type=Path, default=Path("hri-suggestions"), help="of the reports")
    parser.add_argument("--again", action="store_true", help="run no session")
    parser.add_argument("--page", type=Path, default=PAGE, help="to write")
    options = parser.parse_args()
    reports = {}
    for name in options.only.split(","):
        folder = (options.folder / name).resolve()
        if not options.again and not (folder / "report" / "report.json").exists():
            suggest(PROJECTS[name], folder)
        if (folder / "report" / "report.json").exists():
            reports[name] = load(folder / "report")
    page.replace_figures(options.page, COMMAND, figures(reports))


def suggest(project: Project, folder: Path) -> None:
    """Run a session that suggests; its report is in the folder."""
    folder.mkdir(parents=True, exist_ok=True)
    if project.page:
        write_files(blocks_of(ROOT / "docs" / project.page), folder)
    command = [sys.executable, "-m", "pytest_hricdv", "suggest", "--anew", "--most=40", *project.options]
    where = folder if project.page else ROOT
    ran = subprocess.run([*command, "--", project.test, f"--hri-report={folder / 'report'}"], cwd=where, check=False)
    if ran.returncode > 1:
        sys.exit(f"suggestions: {' '.join(command)} ended with status {ran.returncode}")


def figures(reports: Mapping[str, Report]) -> str:
    """The tables of the page."""
    results = {name: result for name, report in reports.items() if (result := SUGGESTIONS.of(report)) is not None}
    columns = ("testbench", "runs", "candidates", "refuted", "suggestions", "faults that change a run")
    head = (*columns, "noticed by exceptions", "with the first ten", "with all that are shown")
    rows = [(name, *_row(result)) for name, result in results.items()]
    return page.table(head, rows)


def _row(result: SuggestionResult) -> Sequence[object]:
    def noticed(count: int) -> str:
        total = result.noticed + sum(suggestion.added for suggestion in result.suggestions[:count])
        return f"{total} ({100 * total / result.faults:.0f} %)" if result.faults else "-"

    shown = len(result.suggestions)
    runs = result.runs + result.validation_runs
    return runs, result.candidates, result.refuted, shown, result.faults, result.noticed, noticed(10), noticed(shown)


if __name__ == "__main__":
    main()
