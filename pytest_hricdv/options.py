"""Options: command line over ini, validated before anything runs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv import learning
from pytest_hricdv.learning import LearningOptions

KINDS = ("statements", "branches", "plans", "assertions", "cross")


@dataclass(frozen=True)
class Gate:
    """A lower bound of coverage, in percent; `named` on the command line, where it applies to any selection."""

    kind: str
    percent: float
    named: bool


@dataclass(frozen=True)
class Options:
    """Everything a user can set, after validation. `suites` and `replay` are empty when no suite is active."""

    suites: str
    suite_named: bool
    seed: int
    tests: int | None
    concretizations: int
    report: Path
    gates: tuple[Gate, ...]
    known: Mapping[str, str]
    strict: bool
    export: Path | None
    coverage: bool
    film: bool = False
    replay: tuple[Path, ...] = ()
    shrink: bool = False
    shrink_runs: int = 60
    shrink_seconds: int = 60
    search: int = 0
    learning: LearningOptions = field(default_factory=LearningOptions)
    again: tuple[str, ...] = ()
    """What the command line said, beside suite and seed, on which tests there are and what fails."""


def add_options(parser: pytest.Parser) -> None:
    """Register the group `hri` and its ini keys."""
    group = parser.getgroup("hri", "coverage-driven verification of human-robot interaction")
    group.addoption(
        "--hri-suite",
        metavar="NAME|PATH[,...]",
        help="generate and run these suites: by-hand, bdi-random, rl, pseudorandom, all, or a file or folder of "
        "abstract tests. Items that do not ask for hri_case are then left out, unless paths are given.",
    )
    group.addoption("--hri-seed", metavar="N", help="seed of generation and concretization (default 0)")
    group.addoption("--hri-tests", metavar="N", help="number of abstract tests per suite (default: the method's own)")
    group.addoption("--hri-concretizations", metavar="K", help="concrete tests per abstract test (default 1)")
    group.addoption("--hri-report", metavar="DIR", help="where report.json and index.html go (default hri-report)")
    group.addoption(
        "--hri-fail-under",
        metavar="KIND=PCT",
        action="append",
        help=f"fail when a suite covers less; KIND is one of {', '.join(KINDS)}; repeatable",
    )
    group.addoption(
        "--hri-known",
        metavar="REQUIREMENT",
        action="append",
        help="a requirement whose violation is known: reported, but does not fail the run; repeatable",
    )
    group.addoption("--hri-strict", action="store_true", default=None, help="let known violations fail, too")
    group.addoption(
        "--hri-replay",
        metavar="FILE[,...]",
        help="instead of a suite, run the tests of these files, which failing tests leave in the folder 'failures' of "
        "a report, and check that each run is the same to the bit",
    )
    group.addoption(
        "--hri-shrink",
        action="store_true",
        default=None,
        help="when all tests have run, make the shortest failing one of each requirement as short as it can be: drop "
        "actions, then simplify parameters, as long as it fails for the same reason",
    )
    group.addoption("--hri-shrink-runs", metavar="N", help="runs to shrink one test with, at most (default 60)")
    group.addoption("--hri-shrink-seconds", metavar="S", help="seconds to shrink one test in, at most (default 60)")
    group.addoption(
        "--hri-search",
        metavar="N",
        help="when all tests have run, vary the parameters of those that came nearest to violating a requirement, to "
        "come nearer: at most N runs for each requirement",
    )
    learning.add_options(parser, group)
    group.addoption("--hri-export", metavar="DIR", help="write the suites as text files that --hri-suite=DIR reads")
    group.addoption("--hri-film", action="store_true", default=None, help="film the runs of failing tests")
    group.addoption("--hri-no-cov", action="store_true", default=None, help="do not measure the code under test")
    for name, what in (
        ("suite", "default of --hri-suite"),
        ("seed", "default of --hri-seed"),
        ("tests", "default of --hri-tests"),
        ("concretizations", "default of --hri-concretizations"),
        ("report", "default of --hri-report"),
        ("export", "default of --hri-export"),
        ("search", "default of --hri-search"),
        ("shrink_runs", "default of --hri-shrink-runs"),
        ("shrink_seconds", "default of --hri-shrink-seconds"),
    ):
        parser.addini(f"hri_{name}", what, default="")
    parser.addini("hri_fail_under", "one KIND=PCT a line; applies when the whole suite is selected", "linelist")
    parser.addini("hri_known_violations", "one a line, 'R3: reason': reported, but does not fail the run", "linelist")
    parser.addini("hri_strict", "default of --hri-strict", "bool", default=False)
    parser.addini("hri_shrink", "default of --hri-shrink", "bool", default=False)
    parser.addini("hri_film", "default of --hri-film", "bool", default=False)
    parser.addini("hri_no_cov", "default of --hri-no-cov", "bool", default=False)


def read_options(config: pytest.Config) -> Options:
    """The options in force. Raises pytest.UsageError for one that makes no sense."""
    replay = _replay(config)
    return Options(
        suites="" if replay else _text(config, "suite"),
        suite_named=bool(replay) or config.getoption("hri_suite") is not None,
        seed=_integer(config, "seed", 0, least=None) or 0,
        tests=_integer(config, "tests", None, least=1),
        concretizations=_integer(config, "concretizations", 1, least=1) or 1,
        report=config.invocation_params.dir / (_text(config, "report") or "hri-report"),
        gates=_gates(config),
        known=_known(config),
        strict=_flag(config, "strict"),
        export=config.invocation_params.dir / _text(config, "export") if _text(config, "export") else None,
        coverage=not _flag(config, "no_cov"),
        film=_flag(config, "film"),
        replay=replay,
        search=_integer(config, "search", 0, least=1) or 0,
        shrink=_flag(config, "shrink"),
        shrink_runs=_integer(config, "shrink_runs", 60, least=1) or 60,
        shrink_seconds=_integer(config, "shrink_seconds", 60, least=1) or 60,
        learning=learning.read_options(config),
        again=_again(config),
    )


def _replay(config: pytest.Config) -> tuple[Path, ...]:
    given = config.getoption("hri_replay")
    if given is None:
        return ()
    if config.getoption("hri_suite") is not None:
        raise pytest.UsageError("--hri-replay and --hri-suite: give one of them; a replay file brings its test along")
    names = [name.strip() for name in given.split(",")]
    if not all(names):
        raise pytest.UsageError(f"--hri-replay={given}: expected the path of a replay file")
    return tuple(config.invocation_params.dir / name for name in names)


def _again(config: pytest.Config) -> tuple[str, ...]:
    single = [(name, config.getoption(f"hri_{name}")) for name in ("tests", "concretizations")]
    known = [f"--hri-known={requirement}" for requirement in config.getoption("hri_known") or ()]
    strict = ["--hri-strict"] if config.getoption("hri_strict") else []
    learned = learning.read_options(config).again
    return (*(f"--hri-{name}={value}" for name, value in single if value is not None), *learned, *known, *strict)


def _text(config: pytest.Config, name: str) -> str:
    given = config.getoption(f"hri_{name}")
    return str(config.getini(f"hri_{name}") if given is None else given).strip()


def _flag(config: pytest.Config, name: str) -> bool:
    given = config.getoption(f"hri_{name}")
    return bool(config.getini(f"hri_{name}") if given is None else given)


def _integer(config: pytest.Config, name: str, default: int | None, least: int | None) -> int | None:
    text, option = _text(config, name), f"--hri-{name.replace('_', '-')}"
    if not text:
        return default
    try:
        value = int(text)
    except ValueError:
        raise pytest.UsageError(f"{option}={text}: expected a whole number") from None
    if least is not None and value < least:
        raise pytest.UsageError(f"{option}={text}: expected at least {least}")
    return value


def _gates(config: pytest.Config) -> tuple[Gate, ...]:
    named: Sequence[str] = config.getoption("hri_fail_under") or ()
    lines: list[tuple[str, bool]] = [(line, True) for line in named]
    lines += [(line, False) for line in config.getini("hri_fail_under")]
    gates: dict[str, Gate] = {}
    for line, on_command_line in lines:
        kind, equals, bound = line.partition("=")
        kind = kind.strip()
        if not equals or kind not in KINDS:
            raise pytest.UsageError(f"--hri-fail-under={line}: expected KIND=PCT with KIND in {', '.join(KINDS)}")
        try:
            percent = float(bound)
        except ValueError:
            raise pytest.UsageError(f"--hri-fail-under={line}: expected a percentage, got {bound!r}") from None
        if not 0 <= percent <= 100:
            raise pytest.UsageError(f"--hri-fail-under={line}: expected a percentage from 0 to 100")
        gates.setdefault(kind, Gate(kind, percent, on_command_line))
    return tuple(gates.values())


def _known(config: pytest.Config) -> dict[str, str]:
    known: dict[str, Any] = {}
    for line in config.getini("hri_known_violations"):
        requirement, colon, reason = line.partition(":")
        if not colon or not reason.strip():
            raise pytest.UsageError(f"hri_known_violations: {line!r}: expected 'REQUIREMENT: reason'")
        known[requirement.strip()] = reason.strip()
    for given in config.getoption("hri_known") or ():
        for requirement in given.split(","):
            known.setdefault(requirement.strip(), "named with --hri-known")
    return known
