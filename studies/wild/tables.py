"""The tables of the page: what was run, and what was found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from studies.page import table
from studies.wild import Package

HEAD = ("package", "kind", "lines by hand", "tests", "statements", "requirements", "violated")


def figures(results: dict[str, Any], every: Sequence[Package]) -> str:
    """The tables, as Markdown, with a sentence that counts what is in them."""
    rows = [_row(package, results[package.key]) for package in every if package.key in results]
    found = [line for package in every for line in _found(package, results.get(package.key, {}))]
    ran = sum("suites" in row for row in results.values())
    kinds = [verdict.partition(":")[0] for _, _, verdict in found]
    counted = ", ".join(
        f"{kinds.count(kind)} {kind}" for kind in sorted(set(kinds), key=lambda kind: (kind == "real", kind))
    )
    causes = sum(verdict.startswith("real: ") and not verdict.startswith("real: as ") for _, _, verdict in found)
    sentence = (
        f"{ran} of {len(every)} packages run, all unmodified. Violated requirements: {counted}, of {causes} causes."
    )
    open_ones = ", ".join(f"`{package.key}`" for package in every if package.key not in results)
    if open_ones:
        sentence += f" Without a testbench so far: {open_ones}."
    return "\n\n".join((sentence, table(HEAD, rows), table(("package", "requirement", "who is wrong"), found)))


def _row(package: Package, row: dict[str, Any]) -> tuple[object, ...]:
    if "not_run" in row:
        return (package.title, package.kind, "-", "-", "-", "-", f"not run: {row['not_run']}")
    suites = row["suites"].values()
    tests = sum(suite["tests"] for suite in suites)
    covered = max(suite["statements"]["percent"] for suite in suites if suite["tests"])
    asked = {name for suite in suites for name in suite["requirements"]}
    return (package.title, package.kind, row["lines"], tests, f"{covered:.0f} %", len(asked),
            ", ".join(violated(row)) or "none")  # fmt: skip


def violated(row: dict[str, Any]) -> list[str]:
    """The violated requirements of a row, and `fault` where a run ended with one."""
    return sorted({name for each in row.get("violations", ()) if each.get("counts", True)
                   for name in each["requirements"] or ["fault"]})  # fmt: skip


def _found(package: Package, row: dict[str, Any]) -> Iterator[tuple[str, str, str]]:
    for name in violated(row):
        yield (f"`{package.key}`", name, package.verdicts.get(name, "not judged yet"))
