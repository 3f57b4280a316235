"""Write docs/evidence.md and the figures of README.md, of what the studies have stored.

    python -m studies.evidence_page

What a study stored as JSON is counted here; a figure of a page that another command has written stands in
`evidence.toml`, and has to be in the words of that page.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from studies import page, wild
from studies.fair_fight import CODE_BASES
from studies.fair_fight.tables import comparison
from studies.races.catalogue import RACES
from studies.wild.tables import violated

FOLDER = Path(__file__).parent
ROOT = FOLDER.parent
QUOTED = FOLDER / "evidence.toml"
EVIDENCE, README = ROOT / "docs" / "evidence.md", ROOT / "README.md"

_HEAD = ("found", "figure", "against", "limits")
_README_TABLE = re.compile(r"(?<=## Does it work\?\n\n).*?(?=\n\n## )", re.DOTALL)
_WILD = "[{}](studies/wild.md)"


class EvidenceError(Exception):
    """A figure is not on the page that it is said to be from."""


def main() -> None:
    """Write both."""
    page.write(EVIDENCE, evidence())
    page.write(README, readme(README.read_text(encoding="utf-8")))


def evidence() -> str:
    """The page. Raises EvidenceError for a quoted figure that its study does not have."""
    quoted = [(row["question"], f"[{row['answer']}](studies/{row['page']})", row["limits"]) for row in _quoted()]
    return page.render(
        "evidence.md.jinja",
        {
            "found": page.table(_HEAD, found()),
            "quoted": page.table(("question", "answer", "limits"), quoted),
            "packages": len([*wild.packages()]),
        },
    )


def found() -> Iterator[tuple[str, str, str, str]]:
    """Rows of the first table: what was found where, against whom, with which limits."""
    yield from _in_packages()
    yield from _known_bugs()
    yield _races()
    results = _stored("fair_fight/results.json")
    for base in CODE_BASES:
        if pair := comparison(base, results):
            ours, theirs = pair
            link = f"[{ours}](studies/fair-fight.md)"
            yield f"{base.title}: same code, world, requirements, budget", link, theirs, "one seed; our testbenches"


def _in_packages() -> Iterator[tuple[str, str, str, str]]:
    results, packages = _stored("wild/results.json"), [*wild.packages()]
    verdicts = [
        package.verdicts.get(name, "open")
        for package in packages
        for name in (violated(results[package.key]) if package.key in results else ())
    ]
    real = [verdict for verdict in verdicts if verdict.startswith("real: ")]
    causes = sum(not verdict.startswith("real: as ") for verdict in real)
    wrong = sum(verdict.startswith("false alarm") for verdict in verdicts)
    ran = sum("suites" in row for row in results.values())
    yield (
        f"in {ran} public packages, unmodified",
        _WILD.format(f"{causes} bugs, {len(real)} violated requirements"),
        f"{wrong} false alarms; {sum(verdict.startswith('by design') for verdict in verdicts)} by design",
        "testbenches of 100 lines and verdicts are ours; nothing was reported",
    )


def _known_bugs() -> Iterator[tuple[str, str, str, str]]:
    bugs = _stored("wild/known.json")
    if bugs:
        caught = sum(bool(bug["found_by"]) and not bug["fix_violated_by"] for bug in bugs.values())
        own, ran = ([bool(bug["own"][key]) for bug in bugs.values()].count(True) for key in ("find", "passed"))
        yield (
            "known bugs of public packages, at the commit before their fix",
            _WILD.format(f"{caught} of {len(bugs)}"),
            f"the packages' own tests at that commit, where they run ({ran}): {own}",
            "requirements written from the reports, which we chose",
        )


def _races() -> tuple[str, str, str, str]:
    results = _stored("races/results.json")
    searched = {key.split()[0] for key in results}
    held = [race.name for race in RACES if race.is_held_out and race.name in searched]
    fails: dict[tuple[str, ...], list[bool]] = {tuple(key.split()[:2]): [] for key in results}
    for key, races in results.items():
        fails[tuple(key.split()[:2])].append(any(race["is_counted"] for race in races))
    sessions = [each for name in held for each in fails.get((name, "robot"), [])]
    twins = [each for (_, kind), of_kind in fails.items() if kind == "repaired" for each in of_kind]
    return (
        f"planted races in {len(held)} robots that nothing was tuned on",
        f"[{sum(sessions)} of {len(sessions)} searches](studies/races.md)",
        f"{sum(twins)} of {len(twins)} searches of repaired code",
        "small robots; 100 runs a search",
    )


def readme(text: str) -> str:
    """README with its four figures. Raises EvidenceError where it has no such table."""
    rows = [
        (f"[{row['figure']}](docs/studies/{row['page']}) {row['of']}", row["limits"])
        for row in _quoted()
        if "figure" in row
    ]
    limits = (f"{next(_in_packages())[2].partition(';')[0]}; our own verdicts", "we chose, and read, the reports")
    for found_in, limit in reversed([*zip((*_in_packages(), *_known_bugs()), limits, strict=False)]):
        number = found_in[1].partition("]")[0].strip("[")
        rows.insert(0, (f"[{number}](docs/evidence.md) {found_in[0]}", limit))
    table = page.table(("measured", "limits"), rows[:4])
    new, count = _README_TABLE.subn(
        lambda _: f"{table}\n\nAll of it, and who was better: [evidence](docs/evidence.md).", text
    )
    if count != 1:
        raise EvidenceError(f"{README.name}: expected one section 'Does it work?'")
    return new


def _quoted() -> Iterator[Mapping[str, str]]:
    """Rows of `evidence.toml` whose words are on their pages."""
    for row in tomllib.loads(QUOTED.read_text(encoding="utf-8"))["row"]:
        text = " ".join((ROOT / "docs" / "studies" / row["page"]).read_text(encoding="utf-8").split())
        if row["words"] not in text:
            raise EvidenceError(f"{QUOTED.name}: {row['page']} has not the words {row['words']!r}")
        yield row


def _stored(name: str) -> dict[str, Any]:
    path = FOLDER / name
    stored: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return stored


if __name__ == "__main__":
    main()
