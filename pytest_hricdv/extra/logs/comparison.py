"""What logs show and tests do not, and the reverse."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from pytest_hricdv.coverage.cross_product import Bin
from pytest_hricdv.report.formatting import and_more, natural
from pytest_hricdv.results.model import Report

SHOWN = 8
"""Names of a kind that the terminal shows."""


@dataclass(frozen=True)
class Occurrences:
    """What occurred in runs: requirements that were triggered, bins that were hit, and actions of people."""

    requirements: frozenset[str]
    bins: Mapping[str, frozenset[Bin]]
    actions: frozenset[str]

    @classmethod
    def of(cls, report: Report, requirements: Collection[str], actions: Collection[str] | None = None) -> Occurrences:
        """What occurred in the runs of a report.

        Args:
            report: of logs, or of tests.
            requirements: that are of interest.
            actions: of the runs; None: the lines of the tests.
        """
        runs = [run for test in report.tests for run in test.runs]
        return cls(
            frozenset(
                name
                for run in runs
                for name in requirements
                if name in run.requirements and run.requirements[name].triggers
            ),
            {
                name: frozenset(hit for run in runs for hit in (run.cross or {}).get(name, ()))
                for name in report.cross_products
            },
            frozenset(line for run in runs for line in run.abstract) if actions is None else frozenset(actions),
        )

    def without(self, other: Occurrences) -> Occurrences:
        """What did not occur in other runs."""
        bins = {name: hits - other.bins.get(name, frozenset()) for name, hits in self.bins.items()}
        return Occurrences(
            self.requirements - other.requirements,
            {name: hits for name, hits in bins.items() if hits},
            self.actions - other.actions,
        )

    @property
    def data(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "requirements": sorted(self.requirements, key=natural),
            "bins": {name: sorted(bins) for name, bins in self.bins.items()},
            "actions": sorted(self.actions, key=natural),
        }

    def lines(self, title: str) -> Iterator[str]:
        """For the terminal: a line for each kind."""
        data = self.data
        kinds = {"requirements": data["requirements"], "actions": data["actions"]}
        kinds |= {f"bins of {name}": [*map(" x ".join, bins)] for name, bins in data["bins"].items()}
        if not any(kinds.values()):
            yield f"  {title}: nothing"
        for kind, names in kinds.items():
            if names:
                yield f"  {title}: {len(names)} {kind}: {', '.join(names[:SHOWN])}{and_more(len(names[SHOWN:]))}"
