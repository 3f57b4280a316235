"""A shard, the unit of a campaign: every abstract test concretized with one seed, and run."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from pytest_hricdv.generate.abstract import AbstractTest
from pytest_hricdv.generate.concrete import variant
from pytest_hricdv.generate.suite_files import dump_tests
from studies import session

SCHEMA = "hricdv-campaign-shard/1"


class ShardError(Exception):
    """The file of a shard is invalid; the message says which file, why, and what to do."""


@dataclass(frozen=True)
class CampaignRun:
    """The results of one run.

    Args:
        test: id of the abstract test.
        id: of the concrete one: what `-k` of pytest finds.
        legs: how each turn ended.
        verdicts: requirement -> Passed, Failed or NC.
        triggers: requirement -> how often it was checked.
        margins: requirement -> the least margin, in the requirement's own unit; None where there is none.
        statements: of the code under test that ran, as a bit set.
        branches: the same of branches; None where they are not measured.
        bins: of the cross products that it hit.
        sim_s: simulated time.
        record_sha256: of all that happened; the same bytes whenever the run is repeated.
        error: what went wrong in a run that did not come to its end, which has checked and covered nothing.
    """

    test: str
    id: str
    legs: tuple[str, ...]
    verdicts: Mapping[str, str]
    triggers: Mapping[str, int]
    margins: Mapping[str, float | None]
    statements: int
    branches: int | None
    bins: tuple[str, ...]
    sim_s: float
    record_sha256: str
    error: str = ""


@dataclass(frozen=True)
class Total:
    """Number of statements or branches of the code under test, and how many of them can be reached."""

    count: int
    reachable: int


@dataclass(frozen=True)
class Shard:
    """The runs of one seed, in the order of their ids. Only their times (s) may differ between equal campaigns."""

    seed: int
    identity: str
    runs: tuple[CampaignRun, ...]
    statements: Total
    branches: Total | None
    titles: Mapping[str, str]
    missing: Mapping[str, tuple[int, ...]]
    """File of the code under test -> statements that none of the runs reached, waived ones too."""
    waived: Mapping[str, tuple[int, ...]]
    wall_s: float
    cpu_s: float

    def to_json(self) -> str:
        """The shard as text; bit sets are whole numbers."""
        return json.dumps({"schema": SCHEMA, **asdict(self)}, sort_keys=True, indent=1) + "\n"


def run(seed: int, tests: Sequence[AbstractTest], identity: str, work: Path, root: Path, workers: int) -> Shard:
    """Run all tests with the concretization number `seed`, as `--hri-concretizations` numbers them.

    Raises:
        SessionError: pytest did not run them all.
    """
    suite = work / "suite.txt"
    work.mkdir(parents=True, exist_ok=True)
    suite.write_text(dump_tests(variant(test, seed) for test in tests), encoding="utf-8")
    distributed = ["-n", str(workers)] if workers > 1 else ["-p", "no:xdist"]
    done = session.run(work / "report", [f"--hri-suite={suite}", *distributed], root)
    base = {variant(test, seed).id: test.id for test in tests}
    return _of_report(seed, identity, done, base)


def _of_report(seed: int, identity: str, done: session.Session, base: Mapping[str, str]) -> Shard:
    report = done.report
    (suite,) = report["suites"]
    code = report["code_under_test"]
    waived: dict[str, list[int]] = {}
    for waiver in code["waivers"]:
        waived.setdefault(waiver["file"], []).append(waiver["line"])
    return Shard(
        seed=seed,
        identity=identity,
        runs=tuple(_run(entry, base[entry["id"]]) for entry in sorted(report["tests"], key=lambda test: test["id"])),
        statements=_total(suite["code"]["statements"]),
        branches=None if suite["code"]["branches"] is None else _total(suite["code"]["branches"]),
        titles={name: each["title"] for name, each in report["requirements"].items()},
        missing={each["file"]: tuple(each["missing_lines"]) for each in code["files"]},
        waived={name: tuple(sorted(lines)) for name, lines in waived.items()},
        wall_s=round(done.wall_s, 1),
        cpu_s=round(done.cpu_s, 1),
    )


def _run(entry: Mapping[str, Any], test: str) -> CampaignRun:
    verdicts = entry["requirements"]
    aborted = entry["outcome"] == "error"
    statements, branches = ("0x0", "0x0") if aborted else entry["code"]["bits"]
    return CampaignRun(
        test=test,
        id=entry["id"],
        legs=tuple(entry["legs"]),
        verdicts={name: each["verdict"] for name, each in verdicts.items()},
        triggers={name: each["triggers"] for name, each in verdicts.items()},
        margins={name: each["margin"] for name, each in verdicts.items()},
        statements=int(statements, 16),
        branches=None if branches is None else int(branches, 16),
        bins=tuple(" x ".join(hit) for hits in entry.get("cross", {}).values() for hit in hits),
        sim_s=entry["sim_s"],
        record_sha256="" if aborted else entry["record_sha256"],
        error=entry["failure"].strip().partition("\n")[0] if aborted else "",
    )


def _total(figures: Mapping[str, int]) -> Total:
    return Total(figures["total"], figures["reachable"])


def read(path: Path) -> Shard:
    """Read a shard. Raises ShardError for a file that is truncated or of another version."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        found = data.pop("schema")
        if found != SCHEMA:
            raise ShardError(f"{path}: expected schema {SCHEMA!r}, found {found!r}: remove the file to run it again")
        runs = tuple(_read_run(each) for each in data.pop("runs"))
        statements = Total(**data.pop("statements"))
        branches = data.pop("branches")
        missing, waived = ({file: tuple(lines) for file, lines in data.pop(name).items()} for name in _LINES)
        branches = None if branches is None else Total(**branches)
        return Shard(runs=runs, statements=statements, branches=branches, missing=missing, waived=waived, **data)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise ShardError(f"{path}: not a shard of a campaign ({error!r}): remove the file to run it again") from None


_LINES = ("missing", "waived")


def _read_run(data: dict[str, Any]) -> CampaignRun:
    return CampaignRun(**{**data, "legs": tuple(data["legs"]), "bins": tuple(data["bins"])})
