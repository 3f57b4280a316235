"""Renders the evidence as a page for screen and print: one file without scripts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from jinja2 import Environment, PackageLoader, StrictUndefined

from pytest_hricdv.extra.evidence.outputs import SessionFacts
from pytest_hricdv.extra.evidence.rows import EvidenceRow

SHOWN_CHECKS = 12
"""Number of tests of a requirement on the page; all are in `checks.csv`."""


def page(rows: Sequence[EvidenceRow], facts: SessionFacts) -> str:
    """The page."""
    environment = Environment(
        loader=PackageLoader("pytest_hricdv.extra.evidence", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    counts = Counter(row.status for row in rows)
    template = environment.get_template("evidence.html.jinja")
    return template.render(rows=rows, facts=facts, counts=counts, shown=SHOWN_CHECKS) + "\n"
