"""Options: command line over ini, validated before anything runs."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from pytest_hricdv.results.gates import (
    KINDS,
    Exemption,
    ExemptionError,
    Gates,
    Threshold,
    ThresholdError,
    parse_exemptions,
    parse_threshold,
)
from pytest_hricdv.session import exports, learning
from pytest_hricdv.session.learning import LearningOptions
from pytest_hricdv.session.shard import Shard, ShardError, shard

SESSION_DAY = "hricdv_session_day"
_DAY = pytest.StashKey[datetime.date]()


@dataclass(frozen=True)
class Options:
    """Everything a user can set, after validation. `suites` and `replay` are empty when no suite is active."""

    suites: str
    suite_named: bool
    seed: int
    tests: int | None
    concretizations: int
    sampling: str
    report: Path
    gates: Gates
    known: Mapping[str, str]
    strict: bool
    export: Path | None
    coverage: bool
    film: bool = False
    replay: tuple[Path, ...] = ()
    replay_anyway: bool = False
    shrink: bool = False
    shrink_runs: int = 60
    shrink_seconds: int = 60
    search: int = 0
    learning: LearningOptions = field(default_factory=LearningOptions)
    shard: Shard | None = None
    baseline: Path | None = None
    update_baseline: bool = False
    today: datetime.date = datetime.date.min
    """The day on which the session began (UTC)."""
    again: tuple[str, ...] = ()
    """What the command line said, beside suite and seed, on which tests there are and what fails."""


def add_options(parser: pytest.Parser) -> None:
    """Register the group `hri` and its ini keys."""
    group = parser.getgroup("hri", "coverage-driven verification of human-robot interaction")
    group.addoption(
        "--hri-suite",
        metavar="NAME|PATH[,...]",
        help="generate and run these suites: by-hand, bdi-random, rl, pseudorandom, all, or a file or folder of "
        "abstract tests. Unless paths are given, only the files of hri_testpaths are collected, and only items that "
        "ask for hri_case.",
    )
    group.addoption("--hri-seed", metavar="N", help="seed of generation and concretization (default 0)")
    group.addoption("--hri-tests", metavar="N", help="number of abstract tests per suite (default: the method's own)")
    group.addoption("--hri-concretizations", metavar="K", help="concrete tests per abstract test (default 1)")
    group.addoption(
        "--hri-sampling",
        metavar="NAME",
        help="how parameters are drawn from their ranges: uniform (default), or corners: extreme values every other "
        "time",
    )
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
    group.addoption(
        "--hri-fail-on-nc",
        action="store_true",
        default=None,
        help="fail when no test triggered a requirement (verdict NC throughout)",
    )
    group.addoption(
        "--hri-allow-nc",
        metavar="REQUIREMENT",
        action="append",
        help="a requirement that --hri-fail-on-nc lets pass; repeatable",
    )
    group.addoption(
        "--hri-baseline",
        metavar="FILE",
        help="compare with this file: new failures, lost coverage and lost triggers fail, improvements are reported",
    )
    group.addoption(
        "--hri-update-baseline", action="store_true", default=None, help="write the file of --hri-baseline anew"
    )
    group.addoption(
        "--hri-shard",
        metavar="INDEX/OF",
        help="run one part of the suite, as in 1/3; 'python -m pytest_hricdv.report merge' puts the reports together, "
        "and holds the gates",
    )
    group.addoption("--hri-strict", action="store_true", default=None, help="let known violations fail, too")
    group.addoption(
        "--hri-replay",
        metavar="FILE[,...]",
        help="instead of a suite, run the tests of these files, which failing tests leave in the folder 'failures' of "
        "a report, and check that each run is the same to the bit",
    )
    group.addoption(
        "--hri-replay-anyway",
        action="store_true",
        default=False,
        help="replay files also where the code under test or a version has changed since: the run need not be the same",
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
    exports.add_options(group, parser)
    group.addoption("--hri-film", action="store_true", default=None, help="film the runs of failing tests")
    group.addoption("--hri-no-cov", action="store_true", default=None, help="do not measure the code under test")
    for name, what in (
        ("suite", "default of --hri-suite"),
        ("seed", "default of --hri-seed"),
        ("tests", "default of --hri-tests"),
        ("concretizations", "default of --hri-concretizations"),
        ("sampling", "default of --hri-sampling"),
        ("report", "default of --hri-report"),
        ("export", "default of --hri-export"),
        ("search", "default of --hri-search"),
        ("baseline", "default of --hri-baseline"),
        ("shrink_runs", "default of --hri-shrink-runs"),
        ("shrink_seconds", "default of --hri-shrink-seconds"),
    ):
        parser.addini(f"hri_{name}", what, default="")
    parser.addini(
        "hri_testpaths",
        "files and folders of the host tests, relative to the ini file; globs are allowed. With "
        "--hri-suite and no paths, only these are collected (default: testpaths)",
        "paths",
        default=[],
    )
    parser.addini("hri_fail_under", "one KIND=PCT a line; applies when the whole suite is selected", "linelist")
    until = "or 'R3 until 2027-01-31: reason'"
    parser.addini("hri_known_violations", f"one a line, 'R3: reason' {until}: does not fail the run", "linelist")
    parser.addini("hri_allow_nc", f"one a line, 'R5: reason' {until}: hri_fail_on_nc lets it pass", "linelist")
    parser.addini("hri_fail_on_nc", "default of --hri-fail-on-nc", "bool", default=False)
    parser.addini("hri_strict", "default of --hri-strict", "bool", default=False)
    parser.addini("hri_shrink", "default of --hri-shrink", "bool", default=False)
    parser.addini("hri_film", "default of --hri-film", "bool", default=False)
    parser.addini("hri_no_cov", "default of --hri-no-cov", "bool", default=False)


def read_options(config: pytest.Config) -> Options:
    """The options in force. Raises pytest.UsageError for one that makes no sense."""
    replay, today = _replay(config), session_day(config)
    known, baseline = _allowed(config, "known", "known_violations"), _text(config, "baseline")
    if config.getoption("hri_update_baseline") and not baseline:
        raise pytest.UsageError("--hri-update-baseline: say which file, with --hri-baseline=FILE or hri_baseline")
    return Options(
        suites="" if replay else _text(config, "suite"),
        suite_named=bool(replay) or config.getoption("hri_suite") is not None,
        seed=_integer(config, "seed", 0, least=None) or 0,
        tests=_integer(config, "tests", None, least=1),
        concretizations=_integer(config, "concretizations", 1, least=1) or 1,
        sampling=_sampling(config),
        report=config.invocation_params.dir / (_text(config, "report") or "hri-report"),
        gates=Gates(
            thresholds=_thresholds(config),
            fail_on_nc=_flag(config, "fail_on_nc"),
            may_be_nc=_allowed(config, "allow_nc", "allow_nc"),
            known={} if _flag(config, "strict") else known,
        ),
        known={name: each.reason for name, each in known.items() if not each.expired(today)},
        shard=_shard(config),
        baseline=config.invocation_params.dir / baseline if baseline else None,
        update_baseline=bool(config.getoption("hri_update_baseline")),
        today=today,
        strict=_flag(config, "strict"),
        export=config.invocation_params.dir / _text(config, "export") if _text(config, "export") else None,
        coverage=not _flag(config, "no_cov"),
        film=_flag(config, "film"),
        replay=replay,
        replay_anyway=config.getoption("hri_replay_anyway"),
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
    single = [(name, config.getoption(f"hri_{name}")) for name in ("tests", "concretizations", "sampling")]
    known = [f"--hri-known={requirement}" for requirement in config.getoption("hri_known") or ()]
    strict = ["--hri-strict"] if config.getoption("hri_strict") else []
    learned = learning.read_options(config).again
    anyway = ["--hri-replay-anyway"] if config.getoption("hri_replay_anyway") else []
    drawn = (f"--hri-{name}={value}" for name, value in single if value is not None)
    return (*drawn, *learned, *known, *strict, *anyway)


def _sampling(config: pytest.Config) -> str:
    name = _text(config, "sampling")
    if not name:
        return "uniform"
    from pytest_hricdv.generate.sampler import SAMPLINGS  # a project without a suite loads options, and no generator

    if name not in SAMPLINGS:
        raise pytest.UsageError(f"--hri-sampling={name}: expected one of {', '.join(SAMPLINGS)}")
    return name


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


def _thresholds(config: pytest.Config) -> tuple[Threshold, ...]:
    named: Sequence[str] = config.getoption("hri_fail_under") or ()
    lines: list[tuple[str, bool]] = [(line, True) for line in named]
    lines += [(line, False) for line in config.getini("hri_fail_under")]
    thresholds: dict[str, Threshold] = {}
    for line, on_command_line in lines:
        try:
            found = parse_threshold(line, named=on_command_line)
        except ThresholdError as error:
            raise pytest.UsageError(f"--hri-fail-under={error}") from None
        thresholds.setdefault(found.kind, found)
    return tuple(thresholds.values())


def _shard(config: pytest.Config) -> Shard | None:
    given = config.getoption("hri_shard")
    try:
        return None if given is None else shard(given)
    except ShardError as error:
        raise pytest.UsageError(f"--hri-shard={error}") from None


def _allowed(config: pytest.Config, option: str, ini: str) -> dict[str, Exemption]:
    try:
        found = parse_exemptions(config.getini(f"hri_{ini}"))
    except ExemptionError as error:
        raise pytest.UsageError(f"hri_{ini}: {error}") from None
    for given in config.getoption(f"hri_{option}") or ():
        for name in map(str.strip, given.split(",")):
            found.setdefault(name, Exemption(name, f"named with --hri-{option.replace('_', '-')}"))
    return found


def session_day(config: pytest.Config) -> datetime.date:
    """The day on which the session began (UTC): taken once, so that a run over midnight is judged by one day."""
    handed = getattr(config, "workerinput", {}).get(SESSION_DAY)
    if handed is not None:
        return datetime.date.fromisoformat(handed)
    return config.stash.setdefault(_DAY, datetime.datetime.now(datetime.UTC).date())
