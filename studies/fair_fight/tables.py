"""The tables of the page: for each code base, what each tool reached."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from typing import Any

from pytest_hricdv.report.formatting import plural
from studies.fair_fight import CODE_BASES, FOLDER, CodeBase, faults
from studies.fair_fight.tools import TOOLS
from studies.page import table

HEAD = ("tool", "runs", "statements", "branches", "violations", "first, s", "shortest", "faults", "false alarms")
FALSE = "false alarm"
OURS = ("pseudorandom", "rl", "closure")

PYNGUIN = "pynguin"
TITLES = {**{tool.name: tool.title for tool in TOOLS}, PYNGUIN: "Pynguin"}


def verdicts() -> Mapping[str, Mapping[str, str]]:
    """Code base -> kind of violation -> "real", "by design" or "false alarm", and why."""
    judged: Mapping[str, Mapping[str, str]] = tomllib.loads((FOLDER / "verdicts.toml").read_text(encoding="utf-8"))
    return judged


def figures(rows: Mapping[str, Any]) -> str:
    """All tables, as Markdown."""
    parts = []
    for base in CODE_BASES:
        of_base = {key.partition("/")[2]: row for key, row in rows.items() if key.startswith(f"{base.name}/")}
        if of_base:
            parts += [
                f"### {base.title[0].upper()}{base.title[1:]}",
                _budget(of_base),
                table(HEAD, _rows(base, of_base)),
            ]
            parts += [table(("violation", "found by", "verdict"), _judged(base, of_base))]
    return "\n\n".join(parts)


def comparison(base: CodeBase, rows: Mapping[str, Any]) -> tuple[str, str] | None:
    """The best of our suites and the best other tool on a code base, by faults, then violations, then branches."""
    of_base = {key.partition("/")[2]: row for key, row in rows.items() if key.startswith(f"{base.name}/")}
    done = {name: row for name, row in of_base.items() if "noticed" in row}
    ours, others = ({name: row for name, row in done.items() if (name in OURS) is is_own} for is_own in (True, False))
    if not ours or not others:
        return None
    return _best(base, ours), _best(base, others)


def _best(base: CodeBase, rows: Mapping[str, Any]) -> str:
    def rank(name: str) -> tuple[int, int, float]:
        row = rows[name]
        return _noticed(row), len(_right(base, row)), row["branches"][0]

    name = max(rows, key=rank)
    row = rows[name]
    of_faults = f"{_noticed(row)} of {len(faults.sealed(base.name))} bugs"
    violations = plural(len(_right(base, row)), "violation")
    return f"{TITLES[name]}: {of_faults}, {violations}, {_share(row['branches'])} of branches"


def _right(base: CodeBase, row: Mapping[str, Any]) -> dict[str, Any]:
    """The violations that are no false alarms."""
    judged = verdicts().get(base.name, {})
    return {kind: each for kind, each in row["kinds"].items() if not judged.get(kind, "").startswith(FALSE)}


def _noticed(row: Mapping[str, Any]) -> int:
    return sum(map(bool, row.get("noticed", {}).values()))


def _budget(rows: Mapping[str, Any]) -> str:
    used = [row["used_s"] for row in rows.values()]
    machine = next(iter(rows.values()))["machine"]
    (budget_s,) = {row["budget_s"] for row in rows.values()}  # a table has one
    of_used = f"{min(used):.0f} to {max(used):.0f} s were used"
    return f"{budget_s:.0f} s of processor time for each tool ({of_used}), on {machine}."


def _rows(base: CodeBase, rows: Mapping[str, Any]) -> Iterator[tuple[object, ...]]:
    for name, title in TITLES.items():
        if name not in rows:
            yield (title, 0, *"-" * 6, "not run with this budget")
            continue
        row = rows[name]
        if "not_run" in row:
            yield (title, 0, *"-" * 6, f"not run: {row['not_run']}")
            continue
        right = _right(base, row)
        first = min((each["first_s"] for each in right.values()), default=None)
        shortest = min((each["shortest"] for each in right.values()), default=None)
        yield (
            title,
            row["runs"],
            _share(row["statements"]),
            _share(row["branches"]),
            len(right),
            "-" if first is None else f"{first:.0f}",
            "-" if shortest is None else shortest,
            f"{_noticed(row)} of {len(faults.sealed(base.name))}" if "noticed" in row else "-",
            len(row["kinds"]) - len(right) + bool(row.get("control")) + row.get("expected_failures", 0),
        )


def _share(pair: tuple[int, int]) -> str:
    return f"{100 * pair[0] / pair[1]:.0f} %"


def _judged(base: CodeBase, rows: Mapping[str, Any]) -> Iterator[tuple[object, ...]]:
    judged = verdicts().get(base.name, {})
    for kind in sorted({kind for row in rows.values() for kind in row.get("kinds", ())}):
        finders = [TITLES[name] for name in TITLES if kind in rows.get(name, {}).get("kinds", ())]
        by = "all that ran" if len(finders) == _ran(rows) else ", ".join(finders)
        yield kind if " " not in kind else f"fault: {kind}", by, judged.get(kind, "not judged yet")


def _ran(rows: Mapping[str, Any]) -> int:
    """The tools that run the world."""
    return sum(name != PYNGUIN and "not_run" not in row for name, row in rows.items())
