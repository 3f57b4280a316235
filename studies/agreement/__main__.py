"""Run the original's own tests here and compare outcomes, verdicts and coverage order: docs/studies/agreement.md.

    python -m studies.agreement [--report DIR] [--again]

The report is written to DIR (default hri-agreement); `--again` compares with the report that is already there.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

from pytest_hricdv.generate.context import GenerationContext
from pytest_hricdv.generate.suite_files import Files
from studies import page, plots, session
from studies.agreement.pair import OurRun, Pair, readings_by_turn
from studies.agreement.tables import context, coverage_chart
from studies.original.requests import leg_requests
from studies.original.runs import FILE, REQUIREMENTS, load_runs


def main() -> None:
    """Run, compare, write."""
    options = session.arguments(__doc__, "hri-agreement").parse_args()
    try:
        pairs = paired(session.report(options, [f"--hri-suite={FILE}", "-n", "2"]))
    except session.SessionError as error:
        sys.exit(f"agreement: {error}")
    plots.save(coverage_chart(pairs), options.docs / "pictures" / "agreement-coverage.svg")
    page.write(options.docs / "studies" / "agreement.md", page.render("agreement/agreement.md.jinja", context(pairs)))
    print(f"written: {options.docs / 'studies' / 'agreement.md'}")


def paired(report: Mapping[str, Any]) -> tuple[Pair, ...]:
    """Each of the original's runs with our run of the same test.

    Raises:
        SessionError: the report is of other tests, or a test ended with an error.
    """
    suite = Files(FILE).generate(GenerationContext(seed=report["suites"][0]["seed"]))
    ids = {test.name: test.id for test in suite.tests}
    entries = {test["id"]: test for test in report["tests"]}
    if entries.keys() != set(ids.values()):
        raise session.SessionError(f"the report is not one of the tests in {FILE}")
    for entry in entries.values():
        if entry["code"] is None:
            raise session.SessionError(f"{entry['id']} ended with an error: {entry['failure']}")
    return tuple(Pair(original, _our_run(entries[ids[original.name]])) for original in load_runs())


def _our_run(entry: Mapping[str, Any]) -> OurRun:
    legs = tuple(entry["outcomes"])
    return OurRun(
        id=entry["id"],
        coverage=float(entry["code"]["percent"]),
        verdicts={name: entry["requirements"][name]["verdict"] for name in REQUIREMENTS},
        legs=legs,
        readings=readings_by_turn(legs, entry["cross"]["decision"], leg_requests(entry["abstract"])),
    )


if __name__ == "__main__":
    main()
