"""The original's own tests, run here: outcomes, verdicts and order of coverage compared, for docs/agreement.md.

    python -m benchmarks.agreement [--report DIR] [--again]

It leaves the report in DIR (default hri-agreement); `--again` compares with the report that is there.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from benchmarks import page, pictures, session
from benchmarks.agreement import charts, original
from benchmarks.agreement.asked import asked
from benchmarks.agreement.pair import OurRun, Pair
from benchmarks.agreement.readings import in_turn
from benchmarks.agreement.tables import context
from pytest_hricdv.generate.files import Files
from pytest_hricdv.generate.method import Context


def main() -> None:
    """Run, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--report", type=Path, default=Path("hri-agreement"), metavar="DIR", help="the report's folder")
    parser.add_argument("--docs", type=Path, default=session.ROOT / "docs", metavar="DIR", help="the page's folder")
    parser.add_argument("--again", action="store_true", help="do not run: compare with the report that is there")
    options = parser.parse_args()
    folder = options.report.resolve()
    try:
        report = read(folder) if options.again else run(folder)
        pairs = paired(report)
    except session.SessionError as error:
        sys.exit(f"agreement: {error}")
    pictures.save(charts.coverage(pairs), options.docs / "pictures" / "agreement-coverage.svg")
    page.write(options.docs / "agreement.md", page.render("agreement/agreement.md.jinja", context(pairs)))
    print(f"written: {options.docs / 'agreement.md'}")


def run(folder: Path) -> dict[str, Any]:
    """The report of all given tests. Raises SessionError."""
    print("running the original's tests on two workers ...", flush=True)
    return session.run(folder, [f"--hri-suite={original.FILE}", "-n", "2"]).report


def read(folder: Path) -> dict[str, Any]:
    """The report in a folder. Raises SessionError where there is none."""
    path = folder / "report.json"
    try:
        report: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise session.SessionError(f"{path}: no report ({error}); leave out --again to run the tests") from None
    return report


def paired(report: Mapping[str, Any]) -> tuple[Pair, ...]:
    """Each of the original's runs with ours of the same test.

    Raises:
        SessionError: the report is of other tests.
    """
    suite = Files(original.FILE).generate(Context(seed=report["suites"][0]["seed"]))
    ids = {test.name: test.id for test in suite.tests}
    entries = {test["id"]: test for test in report["tests"]}
    if entries.keys() != set(ids.values()):
        raise session.SessionError(f"the report is not one of the tests in {original.FILE}")
    for entry in entries.values():
        if entry["code"] is None:
            raise session.SessionError(f"{entry['id']} did not come to its end: {entry['failure']}")
    return tuple(Pair(theirs, _ours(entries[ids[theirs.name]])) for theirs in original.runs())


def _ours(entry: Mapping[str, Any]) -> OurRun:
    legs = tuple(entry["legs"])
    return OurRun(
        id=entry["id"],
        coverage=float(entry["code"]["percent"]),
        verdicts={name: entry["requirements"][name]["verdict"] for name in original.REQUIREMENTS},
        legs=legs,
        readings=in_turn(legs, entry["cross"]["decision"], asked(entry["abstract"])),
    )


if __name__ == "__main__":
    main()
