"""The planar base beside that in MuJoCo: each test of some suites runs on both, and the page says what differs.

    python -m studies.fidelities [--suites NAME,...] [--tests N] [--seed N] [--workers N] [--folder DIR] [--keep DIR]

The page is `fidelities.md`. It is made of the report of `pytest --hri-suite=NAME,... --hri-engine=both`; with `--keep`,
of the one that is there, if there is one.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import eq
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
PROJECT = HERE.parent
RAN = (0, 1)
"""Exit statuses of pytest after which there is a report: all passed, or some failed."""


IDLE = (
    "The robot is idle 30 s after the last order is done and it is docked. With motors that take time, and ways around "
    "others that begin elsewhere, this is up to some seconds later or earlier: an order at about that time comes first "
    "on one base only."
)
CAUSES = {
    "A2": IDLE,
    "A4": "It stands for a second beside somebody as it leaves its charger: on one base before, on the other after it "
    "is 0.2 m away, from where the published monitor asks it to move.",
    "N6": IDLE,
    "N7": "The battery is just above its limit when the robot comes to its charger: with motors that take time it is "
    "there a moment later, and just below.",
    "S2": "With motors that take 0.1 s to slow down it comes a centimetre nearer to a dog, and so to less than 0.15 m.",
    "S3": "In MuJoCo the motors take 0.1 s to slow down: at the edge of the half second it may still be too fast.",
    "S4": "The planar force is that of the impact, or what the wheels push with. In MuJoCo both come together, up to "
    "120 N more.",
}
"""Requirement -> why its verdict depends on the base."""


class FidelityError(Exception):
    """There is nothing to compare; the text says why."""


@dataclass(frozen=True)
class Difference:
    """A verdict that depends on the fidelity: the test, the requirement, both verdicts and both margins."""

    test: str
    requirement: str
    verdicts: tuple[str, str]
    margins: tuple[float | None, float | None]


@dataclass(frozen=True)
class Agreement:
    """A requirement over all tests.

    Args:
        requirement: its name.
        same: tests with the same verdict.
        triggers: tests with the same number of triggers.
        margin: how far margins of tests with the same verdict are apart at most, in the requirement's unit; None: no
            test has two.
    """

    requirement: str
    same: int
    triggers: int
    margin: float | None


@dataclass(frozen=True)
class Fidelities:
    """What a report of tests on two fidelities says.

    Args:
        engines: their names.
        suites: with how many tests each.
        orders: which came to the same end, and of how many.
        agreements: one of each requirement.
        differences: verdicts that depend on the fidelity.
    """

    engines: tuple[str, str]
    suites: Mapping[str, int]
    orders: tuple[int, int]
    agreements: tuple[Agreement, ...]
    differences: tuple[Difference, ...]


def fidelities(report: Mapping[str, Any]) -> Fidelities:
    """What a report says. Raises FidelityError where no test of it ran on two."""
    tests = [test for test in report["tests"] if test["cross_check"]]
    if not tests:
        raise FidelityError("no test of the report ran on two engines: run it with --hri-engine=both")
    ends = [(len(test["outcomes"]), test["outcomes"], test["cross_check"]["outcomes"]) for test in tests]
    suites: dict[str, int] = {}
    for test in tests:
        suites[test["suite"]] = suites.get(test["suite"], 0) + 1
    return Fidelities(
        engines=(tests[0]["engine"], tests[0]["cross_check"]["engine"]),
        suites=suites,
        orders=(
            sum(sum(map(eq, first, second)) for _, first, second in ends),
            sum(max(len(first), len(second)) for _, first, second in ends),
        ),
        agreements=tuple(_agreement(name, tests) for name in tests[0]["requirements"]),
        differences=tuple(_differences(tests)),
    )


def _agreement(name: str, tests: Sequence[Mapping[str, Any]]) -> Agreement:
    pairs = [(test["requirements"][name], test["cross_check"]["requirements"][name]) for test in tests]
    apart = [
        abs(first["margin"] - second["margin"])
        for first, second in pairs
        if first["verdict"] == second["verdict"] and None not in (first["margin"], second["margin"])
    ]
    return Agreement(
        name,
        sum(first["verdict"] == second["verdict"] for first, second in pairs),
        sum(first["triggers"] == second["triggers"] for first, second in pairs),
        max(apart, default=None),
    )


def _differences(tests: Sequence[Mapping[str, Any]]) -> Iterator[Difference]:
    for test in tests:
        for name, other in test["cross_check"]["requirements"].items():
            first = test["requirements"][name]
            if first["verdict"] != other["verdict"]:
                verdicts, margins = (first["verdict"], other["verdict"]), (first["margin"], other["margin"])
                yield Difference(test["id"], name, verdicts, margins)


def page(compared: Fidelities, options: str = "") -> str:
    """The page, in Markdown; `options` of the command that made it."""
    tests = sum(compared.suites.values())
    ran = ", ".join(f"{count} of `{suite}`" for suite, count in compared.suites.items())
    verdicts = tests * len(compared.agreements)
    same = sum(agreement.same for agreement in compared.agreements)
    ended, orders = compared.orders
    lines = [
        "# Two fidelities of the base",
        "",
        f"Written by `python -m studies.fidelities{options}`: each test runs with the planar base, which moves as",
        "it is told at once, and with that in MuJoCo, which has a mass, motors of limited force, and contacts that",
        "give way.",
        "Margins are in the requirement's own unit (s, m, m/s, N).",
        "",
        f"Tests: {ran}. Verdicts that agree: {same:,} of {verdicts:,}. Orders that end alike: {ended} of {orders}.",
        "",
        *_agreement_table(compared, tests),
        "",
        "## Verdicts that depend on the fidelity",
        "",
        *(_difference_table(compared) if compared.differences else ["None."]),
        "",
    ]
    return "\n".join(lines)


def _agreement_table(compared: Fidelities, tests: int) -> list[str]:
    return [
        "| requirement | same verdict | same number of triggers | margins of same verdicts differ by at most |",
        "| --- | --- | --- | --- |",
        *(
            f"| {row.requirement} | {row.same} of {tests} | {row.triggers} of {tests} | {_apart(row)} |"
            for row in compared.agreements
        ),
    ]


def _difference_table(compared: Fidelities) -> list[str]:
    names = dict.fromkeys(row.requirement for row in compared.differences)
    return [
        f"| test | requirement | {' | '.join(compared.engines)} |",
        "| --- | --- | --- | --- |",
        *(f"| {row.test} | {row.requirement} | {_said(row, 0)} | {_said(row, 1)} |" for row in compared.differences),
        "",
        *(f"- {name}: {CAUSES.get(name, 'Not known.')}" for name in names),
    ]


def _apart(row: Agreement) -> str:
    return "-" if row.margin is None else f"{row.margin:.3g}"


def _said(row: Difference, which: int) -> str:
    margin = row.margins[which]
    return row.verdicts[which] + ("" if margin is None else f" by {margin:+.3g}")


def _session(report: Path, suites: str, tests: int, seed: int, workers: int) -> None:
    options = [f"--hri-suite={suites}", f"--hri-tests={tests}", f"--hri-seed={seed}", f"--hri-report={report}"]
    shared = ["-n", str(workers)] if workers > 1 else []
    fixed = ["--hri-engine=both", "--hri-no-cov", "--hri-diagnose=0", "-q", "-p", "no:cacheprovider"]
    command = [sys.executable, "-m", "pytest", *options, *fixed, *shared]
    ended = subprocess.run(command, cwd=PROJECT, capture_output=True, text=True, check=False)
    if ended.returncode not in RAN:
        raise FidelityError(f"{' '.join(command)} ended with {ended.returncode}:\n{ended.stdout}{ended.stderr}")


def main(arguments: Sequence[str] | None = None) -> int:
    """The command; 0, or 2 where there is nothing to compare."""
    parser = argparse.ArgumentParser(prog="python -m studies.fidelities", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--suites", default="rl,pseudorandom", help="comma-separated (default: rl,pseudorandom)")
    parser.add_argument("--tests", type=int, default=12, help="of each suite (default: 12)")
    parser.add_argument("--seed", type=int, default=0, help="of the suites (default: 0)")
    parser.add_argument("--workers", type=int, default=2, help="processes (default: 2)")
    parser.add_argument("--folder", type=Path, default=HERE, help="of the page (default: here)")
    parser.add_argument("--keep", type=Path, help="keep the report here, and make the page of the one that is there")
    parsed = parser.parse_args(arguments)
    try:
        with tempfile.TemporaryDirectory(prefix="home-care-") as scratch:
            keep = (parsed.keep or Path(scratch)).resolve()
            if not (keep / "report.json").exists():
                _session(keep, parsed.suites, parsed.tests, parsed.seed, parsed.workers)
            compared = fidelities(json.loads((keep / "report.json").read_text(encoding="utf-8")))
            text = page(compared, f" --suites {parsed.suites} --tests {parsed.tests} --seed {parsed.seed}")
    except FidelityError as error:
        print(error, file=sys.stderr)
        return 2
    parsed.folder.mkdir(parents=True, exist_ok=True)
    (parsed.folder / "fidelities.md").write_text(text, encoding="utf-8")
    print(parsed.folder / "fidelities.md")
    return 0


if __name__ == "__main__":
    sys.exit(main())
