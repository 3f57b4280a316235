"""Options in force: the command line wins over the ini file, and all are validated before anything runs."""

from __future__ import annotations

import datetime
import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal

import pytest

from pytest_hricdv.extra.closing.options import NAME as CLOSURE
from pytest_hricdv.extra.closing.options import ClosingOptions, read_closing
from pytest_hricdv.results.gates import (
    KNOWN,
    MAX_SHARDS,
    MAY_BE_NC,
    MUTANTS,
    Exemption,
    ExemptionError,
    Gates,
    Threshold,
    ThresholdError,
    parse_exemption,
    parse_exemptions,
    parse_threshold,
)
from pytest_hricdv.session.learning_options import LearningOptions, read_learning
from pytest_hricdv.session.usage import usage_error

MAX_INTEGER = 2**63 - 1
"""Of an option: seeds have 63 bits, and nothing else needs more."""

MAX_TESTS, MAX_CONCRETIZATIONS = 100_000, 10_000
"""As in `generate.beliefs`, which a session without a suite does not import."""

SESSION_DAY = "hricdv_session_day"
_AGAIN = ("tests", "concretizations", "sampling", "fidelity", "engine")
_DAY = pytest.StashKey[datetime.date]()


@dataclass(frozen=True)
class Shard:
    """The part `index` (from 1) of `of` parts of a suite.

    The shard of a test depends on its id and on `of` only: new tests move no other test, and the jobs that run the
    shards need not know of each other.
    """

    index: int
    of: int

    def __contains__(self, test_id: str) -> bool:
        digest = hashlib.sha256(test_id.encode("utf-8")).digest()
        return int.from_bytes(digest[:8], "big") % self.of == self.index - 1

    def __str__(self) -> str:
        return f"{self.index}/{self.of}"


@dataclass(frozen=True)
class MutationOptions:
    """How mutants are tried.

    Args:
        asked: whether they are.
        tests: at most so many of each suite; None: all.
        mutants: at most so many; None: all.
        seconds: none is begun later; None: no limit.
        matrix: try further tests after one has failed.
    """

    asked: bool = False
    tests: int | None = 10
    mutants: int | None = None
    seconds: int | None = None
    matrix: bool = False


@dataclass(frozen=True)
class ClusterOptions:
    """On which cluster the closing loop and a search run tests.

    Args:
        address: as `pytest_hricdv.extra.cluster.address` reads it; empty: on none.
        send_code: the project is sent to the workers, which do not have it.
    """

    address: str = ""
    send_code: bool = False


@dataclass(frozen=True)
class Options:
    """All that a user can set, validated. `suites` and `replay` are empty when no suite is active."""

    suites: str
    suite_named: bool
    seed: int
    tests: int | None
    concretizations: int
    sampling: str
    report: Path
    gates: Gates
    known: Mapping[str, Exemption]
    """The known violations that have not expired; also in a strict run, which ignores them."""
    strict: bool
    export: Path | None
    coverage: bool
    plan: Path | None = None
    """The file of the verification plan."""
    history: Path | None = None
    """The file to which a line on the session is added."""
    film: bool = False
    mcap: Literal["", "failing", "all"] = ""
    """Whose runs are written as MCAP files."""
    replay: tuple[Path, ...] = ()
    replay_anyway: bool = False
    shrink: bool = False
    shrink_runs: int = 60
    shrink_seconds: int = 60
    search: int = 0
    mutation: MutationOptions = MutationOptions()
    learning: LearningOptions = field(default_factory=LearningOptions)
    closing: ClosingOptions = field(default_factory=ClosingOptions)
    cluster: ClusterOptions = ClusterOptions()
    stop_at: tuple[str, ...] = ()
    """Requirements at whose violation a debugger stops."""
    shard: Shard | None = None
    baseline: Path | None = None
    update_baseline: bool = False
    fidelity: str = ""
    engine: str = ""
    resume: bool = False
    today: datetime.date = datetime.date.min
    """The day on which the session began (UTC)."""
    again: tuple[str, ...] = ()
    """Options of the command line, besides suite and seed, that decide which tests are generated and which fail."""


def read_options(config: pytest.Config) -> Options:
    """The options in force. Raises pytest.UsageError for an invalid one."""
    replay, today = _replay(config), session_day(config)
    known, baseline = _exemptions(config, "known", "known_violations", KNOWN), _text(config, "baseline")
    if config.getoption("hri_update_baseline") and not baseline:
        raise usage_error("--hri-update-baseline: say which file, with --hri-baseline=FILE or hri_baseline")
    if not baseline and _fail_on_change(config):
        raise usage_error("--hri-fail-on-change: compared with what? give --hri-baseline=FILE or hri_baseline")
    suites = "" if replay else _text(config, "suite") or (CLOSURE if config.getoption("hri_close") else "")
    return Options(
        suites=suites,
        suite_named=bool(replay or config.getoption("hri_close")) or config.getoption("hri_suite") is not None,
        seed=_integer(config, "seed", 0, least=None) or 0,
        tests=_integer(config, "tests", None, least=1, most=MAX_TESTS),
        concretizations=_integer(config, "concretizations", 1, least=1, most=MAX_CONCRETIZATIONS) or 1,
        sampling=_sampling(config),
        report=config.invocation_params.dir / (_text(config, "report") or "hri-report"),
        gates=Gates(
            thresholds=_thresholds(config),
            fail_on_nc=_flag(config, "fail_on_nc"),
            may_be_nc=_exemptions(config, "allow_nc", "allow_nc", MAY_BE_NC),
            known={} if _flag(config, "strict") else known,
            fail_on_change=_fail_on_change(config),
        ),
        known={name: each for name, each in known.items() if not each.expired(today)},
        shard=_shard(config),
        baseline=config.invocation_params.dir / baseline if baseline else None,
        update_baseline=bool(config.getoption("hri_update_baseline")),
        today=today,
        strict=_flag(config, "strict"),
        export=config.invocation_params.dir / _text(config, "export") if _text(config, "export") else None,
        coverage=not _flag(config, "no_cov"),
        fidelity=_text(config, "fidelity"),
        engine=_text(config, "engine"),
        plan=_file(config, "plan"),
        history=_file(config, "history"),
        film=_flag(config, "film"),
        mcap="all" if _flag(config, "mcap_all") else "failing" if _flag(config, "mcap") else "",
        resume=bool(config.getoption("hri_resume")),
        replay=replay,
        replay_anyway=bool(config.getoption("hri_replay_anyway")),
        search=_integer(config, "search", 0, least=1) or 0,
        shrink=_flag(config, "shrink"),
        shrink_runs=_integer(config, "shrink_runs", 60, least=1) or 60,
        shrink_seconds=_integer(config, "shrink_seconds", 60, least=1) or 60,
        mutation=_mutation(config),
        learning=read_learning(config),
        closing=_closing(config, suites),
        cluster=ClusterOptions(_text(config, "cluster"), _flag(config, "send_code")),
        stop_at=_stop_at(config),
        again=_again(config),
    )


def _file(config: pytest.Config, name: str) -> Path | None:
    """A file as given, relative to where pytest was started; of the ini file, relative to that."""
    given = config.getoption(f"hri_{name}")
    text = _text(config, name)
    return (config.invocation_params.dir if given is not None else config.rootpath) / text if text else None


def _fail_on_change(config: pytest.Config) -> bool:
    """The key of the ini file does not hold where the command line says `--hri-baseline=`: compare with none."""
    switched_off = config.getoption("hri_baseline") is not None and not _text(config, "baseline")
    return bool(config.getoption("hri_fail_on_change")) or (_flag(config, "fail_on_change") and not switched_off)


def _replay(config: pytest.Config) -> tuple[Path, ...]:
    given = config.getoption("hri_replay")
    if given is None:
        return ()
    if config.getoption("hri_suite") is not None:
        raise usage_error("--hri-replay and --hri-suite: give one of them; a replay file brings its test along")
    names = [name.strip() for name in given.split(",")]
    if not all(names):
        raise usage_error(f"--hri-replay={given}: expected the path of a replay file")
    return tuple(config.invocation_params.dir / name for name in names)


def _mutation(config: pytest.Config) -> MutationOptions:
    text = _text(config, "mutate_tests")
    if not (text.isascii() and text.isdigit()) and text not in ("", "all"):
        raise usage_error(f"--hri-mutate-tests={text}: expected a whole number, or all")
    tests = None if text == "all" else _integer(config, "mutate_tests", MutationOptions.tests, least=1)
    options = MutationOptions(
        asked=_flag(config, "mutate"),
        tests=tests,
        mutants=_integer(config, "mutate_faults", None, least=1),
        seconds=_integer(config, "mutate_seconds", None, least=1),
        matrix=_flag(config, "mutate_matrix"),
    )
    if options.asked and _flag(config, "no_cov"):
        raise usage_error("--hri-mutate and --hri-no-cov: which tests to try a fault on is known from coverage")
    if options.asked and config.getoption("hri_shard") is not None:
        raise usage_error("--hri-mutate and --hri-shard: give one of them; faults are tried on whole suites")
    needed = [line for line in config.getoption("hri_fail_under") or () if line.partition("=")[0].strip() == MUTANTS]
    if needed and not options.asked:
        raise usage_error(f"--hri-fail-under={needed[0]}: add --hri-mutate, or there are no mutants")
    return options


def _closing(config: pytest.Config, suites: str) -> ClosingOptions:
    options = read_closing(
        suites,
        close=bool(suites and config.getoption("hri_close")),
        runs=_integer(config, "close_runs", ClosingOptions.runs, least=1) or 0,
        seconds=_integer(config, "close_seconds", ClosingOptions.seconds, least=1) or 0,
        without=_text(config, "close_without"),
    )
    if options.asked and _sampling(config) != "uniform":
        raise usage_error(f"--hri-sampling and the suite {CLOSURE}: the closing loop chooses parameters itself")
    return options


def _again(config: pytest.Config) -> tuple[str, ...]:
    single = [(name, config.getoption(f"hri_{name}")) for name in _AGAIN]
    known = [f"--hri-known={requirement}" for requirement in config.getoption("hri_known") or ()]
    strict = ["--hri-strict"] if config.getoption("hri_strict") else []
    learned = read_learning(config).again
    anyway = ["--hri-replay-anyway"] if config.getoption("hri_replay_anyway") else []
    drawn = (f"--hri-{name}={value}" for name, value in single if value is not None)
    closing = [(name, config.getoption(f"hri_close_{name}")) for name in ("runs", "without")]
    closed = (f"--hri-close-{name}={value}" for name, value in closing if value is not None)
    close = ("--hri-close",) if config.getoption("hri_close") else ()
    return (*drawn, *learned, *known, *strict, *anyway, *close, *closed)


def _sampling(config: pytest.Config) -> str:
    name = _text(config, "sampling")
    if not name:
        return "uniform"
    from pytest_hricdv.generate.sampler import SAMPLINGS  # a project without a suite loads options, and no generator

    if name not in SAMPLINGS:
        raise usage_error(f"--hri-sampling={name}: expected one of {', '.join(SAMPLINGS)}")
    return name


def _stop_at(config: pytest.Config) -> tuple[str, ...]:
    given = str(config.getoption("hri_break") or "")
    if given and getattr(config.option, "numprocesses", None):
        raise usage_error("--hri-break: a debugger needs a terminal, and workers have none: leave -n out, or give -n0")
    return tuple(name.strip() for name in given.split(",") if name.strip())


def _text(config: pytest.Config, name: str) -> str:
    given = config.getoption(f"hri_{name}")
    return str(config.getini(f"hri_{name}") if given is None else given).strip()


def _flag(config: pytest.Config, name: str) -> bool:
    given = config.getoption(f"hri_{name}")
    return bool(config.getini(f"hri_{name}") if given is None else given)


def _integer(
    config: pytest.Config, name: str, default: int | None, least: int | None, most: int = MAX_INTEGER
) -> int | None:
    text, option = _text(config, name), f"--hri-{name.replace('_', '-')}"
    if not text:
        return default
    try:
        value = int(text if text.isascii() else "")
    except ValueError:
        raise usage_error(f"{option}={text}: expected a whole number") from None
    least = -MAX_INTEGER if least is None else least
    if not least <= value <= most:
        expected = f"at least {least}" if value < least else f"at most {most}"
        raise usage_error(f"{option}={text}: expected {expected}")
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
            raise usage_error(f"--hri-fail-under={error}") from None
        thresholds.setdefault(found.kind, found)
    return tuple(thresholds.values())


def _shard(config: pytest.Config) -> Shard | None:
    text = config.getoption("hri_shard")
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text.strip())
    if match is None or not 1 <= int(match[1]) <= int(match[2]) <= MAX_SHARDS:
        expected = f"expected INDEX/OF, as in 1/3, with INDEX from 1 to OF, and OF at most {MAX_SHARDS}"
        raise usage_error(f"--hri-shard={text}: {expected}")
    return Shard(int(match[1]), int(match[2]))


def _exemptions(config: pytest.Config, option: str, ini: str, form: str) -> dict[str, Exemption]:
    """Requirement -> exemption, of the ini file and of the command line, which wins."""
    try:
        found = parse_exemptions(config.getini(f"hri_{ini}"), form)
    except ExemptionError as error:
        raise usage_error(f"hri_{ini}: {error}") from None
    name = f"--hri-{option.replace('_', '-')}"
    for given in config.getoption(f"hri_{option}") or ():
        # Several names are separated by commas; conditions and reasons may have commas of their own.
        for text in [given] if re.search(r":|\s(?:in|while|until)\s", given) else given.split(","):
            try:
                exemption = parse_exemption(text, form, reason=f"named with {name}")
            except ExemptionError as error:
                raise usage_error(f"{name}={error}") from None
            before = found.get(exemption.requirement)
            if before is None or (before.condition, before.suites) != (exemption.condition, exemption.suites):
                found[exemption.requirement] = exemption
    return found


def session_day(config: pytest.Config) -> datetime.date:
    """The day on which the session began (UTC), taken once: a session over midnight has one day."""
    handed = getattr(config, "workerinput", {}).get(SESSION_DAY)
    if handed is not None:
        return datetime.date.fromisoformat(handed)
    return config.stash.setdefault(_DAY, datetime.datetime.now(datetime.UTC).date())
