"""The tables of the page: what was run, and what was found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from studies.page import table
from studies.wild import Package
from studies.wild.known import KnownBug
from studies.wild.running import ALONE

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


SUITES = ("rl", ALONE, "schedules")
KNOWN_HEAD = ("bug", "lines by hand", "`rl`", "`closure`", "schedules", "at the fix", "own tests", "found")


def known_figures(results: dict[str, Any], every: Sequence[KnownBug]) -> str:
    """The table of known bugs, as Markdown, with a sentence that counts them."""
    rows = [(bug, results[bug.key]) for bug in every if bug.key in results]
    kept = [row for _, row in rows if is_found(row)]
    by = [sum(suite in row["found_by"] for row in kept) for suite in SUITES]
    added = sum("closure" in row["found_by"] and "rl" not in row["found_by"] for row in kept)
    ordered = sum(had_order(row) for _, row in rows)
    ran, own = ([bool(row["own"][key]) for _, row in rows].count(True) for key in ("passed", "find"))
    sentence = (
        f"{len(kept)} of {len(rows)} known bugs found: {by[0]} by `rl`, {by[1]} by `closure`, {by[2]} by schedules, "
        f"which had something to order in {ordered}. `closure` after `rl` adds {added} to what `rl` found. "
        f"The package's own tests at the commit before run here for {ran}, and find {own}."
    )
    open_ones = ", ".join(f"`{bug.key}`" for bug in every if bug.key not in results)
    if open_ones:
        sentence += f" Not run so far: {open_ones}."
    reports = [(f"`{bug.key}`", f"[{bug.text}]({bug.report})", seen(row) or "-", bug.note or "-") for bug, row in rows]
    return "\n\n".join((
        "## Which known bugs were found",
        sentence,
        table(KNOWN_HEAD, [_known_row(bug, row) for bug, row in rows]),
        table(("key", "report", "what the first failing test shows", "remark"), reports),
    ))  # fmt: skip


def is_found(row: dict[str, Any]) -> bool:
    """Whether a bug was found: its requirement fails before the fix, and is checked and holds at it."""
    return bool(row["found_by"]) and not row["fix_violated_by"] and row["fix_checks"] > 0


def seen(row: dict[str, Any]) -> str:
    """What the first violation of the requirement shows."""
    return next((each["seen"] for each in row["violations"]), "")


def had_order(row: dict[str, Any]) -> bool:
    """Whether schedules were tried, and two threads, tasks or callbacks of the code took turns."""
    return bool(row.get("schedules")) and row["schedules"]["ended"] != "nothing to order"


def _known_row(bug: KnownBug, row: dict[str, Any]) -> tuple[object, ...]:
    tried = (1, bug.before.close_runs, had_order(row))
    suites = [("yes" if suite in row["found_by"] else "no") if runs else "-"
              for suite, runs in zip(SUITES, tried, strict=True)]  # fmt: skip
    at_fix = "fails" if row["fix_violated_by"] else "holds" if row["fix_checks"] else "never checked"
    return (
        bug.before.title,
        row["lines"],
        *suites,
        at_fix,
        own_words(bug, row["own"]),
        "yes" if is_found(row) else "no",
    )


def own_words(bug: KnownBug, own: dict[str, Any]) -> str:
    """What the package's own tests came to, in words."""
    if not bug.own:
        return "none"
    if not own["passed"]:
        return "do not run here"
    return f"{own['passed']} pass, {own['failed'] + own['error']} fail, {len(own['find']) or 'none'} find it"
