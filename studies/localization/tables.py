"""The figures of the study: how often each ranking points at the fault."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from studies import page
from studies.localization.measuring import Measured
from studies.localization.ranking import FIRST

RANKINGS = {
    "diagnosis": "places of a cause",
    "ochiai": "Ochiai alone",
    "dstar": "DStar alone",
    "chance": "chance",
}


def text(measured: Sequence[Measured], runs: int | None = None) -> str:
    """A table of all faults together, and one by testbench and kind.

    Args:
        measured: faults that were tried.
        runs: that each diagnosis might take; None for its default.
    """
    failing = [fault for fault in measured if fault.hits]
    kinds = {
        "planted": [fault for fault in failing if fault.kind == "planted"],
        "mutants": [fault for fault in failing if fault.kind != "planted"],
        "something is missing": [fault for fault in failing if fault.is_omission],
    }
    projects = {name: [fault for fault in failing if fault.project == name] for name in _projects(failing)}
    head = ["ranking", "function first", *(f"statement among the first {most}" for most in FIRST)]
    rows = [[label, *_shares(failing, name)] for name, label in RANKINGS.items()]
    by_head = ["faults", "number", *head[1:], "Ochiai alone: function", f"Ochiai alone: first {FIRST[-1]}"]
    by_rows = [
        [label, len(group), *_shares(group, "diagnosis"), *_ends(_shares(group, "ochiai"))]
        for label, group in (projects | kinds).items()
        if group
    ]
    counts = ", ".join(f"{len(group)} of {name}" for name, group in projects.items())
    tried = "that were tried" if runs is None else f"that were tried with `--hri-diagnose={runs}`"
    said = f"Of {len(measured)} faults {tried}, {len(failing)} make tests fail ({counts}):"
    shown = [fault.shown for fault in failing if fault.shown is not None]
    said_shown = (
        f"{len(shown)} of {len(failing)} causes show a statement; {sum(shown)} of these are in the faulty function."
    )
    return "\n\n".join(
        [said, page.table(head, rows), said_shown, "By testbench and kind:", page.table(by_head, by_rows)]
    )


def _projects(measured: Iterable[Measured]) -> list[str]:
    return list(dict.fromkeys(fault.project for fault in measured))


def _shares(measured: Sequence[Measured], ranking: str) -> list[str]:
    hits = [fault.hits[ranking] for fault in measured]
    columns = [[hit.function for hit in hits], *zip(*(hit.statements for hit in hits), strict=True)]
    return [page.percent(100.0 * sum(column) / len(column), 0) for column in columns]


def _ends(shares: Sequence[str]) -> list[str]:
    return [shares[0], shares[-1]]
