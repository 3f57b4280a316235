"""The `Options` of a session, read and validated by `read_options`; the command line overrides the ini file.

`plugin` reads them when pytest is configured, before anything runs, and gives them to `Collection`. `Shard` says which
tests of a suite belong to one part of it.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from pathlib import Path
from typing import Any

import pytest

from pytest_hricdv.results.gates import (
    ALLOWED_UNTRIGGERED,
    KNOWN,
    MAX_SHARDS,
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
from pytest_hricdv.session.option import MAX_INTEGER, OptionReader, feature_options, usage_error

MAX_TESTS = 100_000
"""Most tests of a suite; the same number as in `generate.beliefs`, which a session without a suite does not import."""

SESSION_DAY = "hricdv_session_day"
"""A key of what a worker receives: the date on which the session began."""
_RERUN_OPTIONS = ("tests", "concretizations", "sampling", "fidelity")
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
        digest = sha256(test_id.encode("utf-8")).digest()
        return int.from_bytes(digest[:8], "big") % self.of == self.index - 1

    def __str__(self) -> str:
        return f"{self.index}/{self.of}"


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
    known_violations: Mapping[str, Exemption]
    """The known violations that have not expired; also in a strict run, which ignores them."""
    strict: bool
    export: Path | None
    coverage: bool
    replay: tuple[Path, ...] = ()
    replay_force: bool = False
    learning: LearningOptions = field(default_factory=LearningOptions)
    stop_at: tuple[str, ...] = ()
    """Requirements at whose violation a debugger stops."""
    shard: Shard | None = None
    baseline: Path | None = None
    update_baseline: bool = False
    fidelity: str = ""
    resume: bool = False
    isolate: bool = False
    """Each test is called in a process of its own."""
    no_waivers: bool = False
    """Comments `# unreachable` in the code do not count."""
    today: datetime.date = datetime.date.min
    """The day on which the session began (UTC)."""
    again: tuple[str, ...] = ()
    """Options of the command line, besides suite and seed, that decide which tests are generated and which fail."""
    features: Mapping[str, Any] = field(default_factory=dict)
    """Feature -> its settings."""


def read_options(config: pytest.Config) -> Options:
    """The options in force. Raises pytest.UsageError for an invalid one."""
    reader, replay, today = OptionReader(config), _replay(config), session_day(config)
    known_violations, baseline = _exemptions(config, "known", "known_violations", KNOWN), reader.text("baseline")
    if config.getoption("hri_update_baseline") and not baseline:
        raise usage_error("--hri-update-baseline: say which file, with --hri-baseline=FILE or hri_baseline")
    if not baseline and _fail_on_change(reader):
        raise usage_error("--hri-fail-on=change: compared with what? give --hri-baseline=FILE or hri_baseline")
    asking = [feature for feature in feature_options() if feature.asks_for_suites(reader)]
    suites = "" if replay else reader.text("suite") or ",".join(name for feature in asking for name in feature.suites)
    return Options(
        suites=suites,
        suite_named=bool(replay or asking) or config.getoption("hri_suite") is not None,
        seed=reader.integer("seed", 0, minimum=-MAX_INTEGER),
        tests=reader.integer("tests", None, minimum=1, maximum=MAX_TESTS),
        concretizations=reader.integer("concretizations", 1, minimum=1),
        sampling=_read_sampling(reader),
        report=config.invocation_params.dir / (reader.text("report") or "hri-report"),
        gates=Gates(
            thresholds=_thresholds(config),
            fail_on_nc=reader.flag("fail_on_nc"),
            allowed_untriggered=_exemptions(config, "allow_nc", "allow_nc", ALLOWED_UNTRIGGERED),
            known_violations={} if reader.flag("strict") else known_violations,
            fail_on_change=_fail_on_change(reader),
            fail_on_pending=reader.flag("fail_on_pending"),
        ),
        known_violations={
            name: exemption for name, exemption in known_violations.items() if not exemption.is_expired(today)
        },
        shard=_shard(config),
        baseline=config.invocation_params.dir / baseline if baseline else None,
        update_baseline=bool(config.getoption("hri_update_baseline")),
        today=today,
        strict=reader.flag("strict"),
        export=config.invocation_params.dir / reader.text("export") if reader.text("export") else None,
        coverage=not reader.flag("no_cov"),
        fidelity=reader.text("fidelity"),
        resume=bool(config.getoption("hri_resume")),
        isolate=reader.flag("isolate"),
        no_waivers=reader.flag("no_waivers"),
        replay=replay,
        replay_force=bool(config.getoption("hri_replay_force")),
        features={feature.name: feature.read(reader) for feature in feature_options()},
        learning=read_learning(config),
        stop_at=_stop_at(config),
        again=_again(config),
    )


def _fail_on_change(reader: OptionReader) -> bool:
    """The key of the ini file does not hold where the command line says `--hri-baseline=`: compare with none."""
    switched_off = reader.command_line_value("baseline") is not None and not reader.text("baseline")
    words = str(reader.command_line_value("fail_on") or "").split(",")
    is_given = "change" in words or bool(reader.command_line_value("fail_on_change"))
    return is_given or (reader.flag("fail_on_change") and not switched_off)


def _replay(config: pytest.Config) -> tuple[Path, ...]:
    text = config.getoption("hri_replay")
    if text is None:
        return ()
    if config.getoption("hri_suite") is not None:
        raise usage_error("--hri-replay and --hri-suite: give one of them; a replay file contains its test")
    names = [name.strip() for name in text.split(",")]
    if not all(names):
        raise usage_error(f"--hri-replay={text}: expected the path of a replay file")
    return tuple(config.invocation_params.dir / name for name in names)


def _again(config: pytest.Config) -> tuple[str, ...]:
    single = [(name, config.getoption(f"hri_{name}")) for name in _RERUN_OPTIONS]
    known_violations = [f"--hri-known={requirement}" for requirement in config.getoption("hri_known") or ()]
    strict = ["--hri-strict"] if config.getoption("hri_strict") else []
    learned = read_learning(config).again
    anyway = ["--hri-replay-force"] if config.getoption("hri_replay_force") else []
    drawn = (f"--hri-{name}={value}" for name, value in single if value is not None)
    further = (option for feature in feature_options() for option in feature.rerun_options(OptionReader(config)))
    return (*drawn, *further, *learned, *known_violations, *strict, *anyway)


def _read_sampling(reader: OptionReader) -> str:
    name = reader.text("sampling")
    if not name:
        return "uniform"
    from pytest_hricdv.generate.sampler import SAMPLINGS  # a project without a suite loads options, and no generator

    if name not in SAMPLINGS:
        raise usage_error(f"{reader.setting('sampling')}: expected one of {', '.join(SAMPLINGS)}")
    return name


def _stop_at(config: pytest.Config) -> tuple[str, ...]:
    text = str(config.getoption("hri_break_on_violation") or "")
    if text and getattr(config.option, "numprocesses", None):
        raise usage_error(
            "--hri-break-on-violation: a debugger needs a terminal, and workers have none: leave -n out, or give -n0"
        )
    return tuple(name.strip() for name in text.split(",") if name.strip())


def _thresholds(config: pytest.Config) -> tuple[Threshold, ...]:
    named: Sequence[str] = config.getoption("hri_fail_under") or ()
    lines: list[tuple[str, bool]] = [(line, True) for line in named]
    lines += [(line, False) for line in config.getini("hri_fail_under")]
    thresholds: dict[str, Threshold] = {}
    for line, on_command_line in lines:
        try:
            threshold = parse_threshold(line, named=on_command_line)
        except ThresholdError as error:
            where = "--hri-fail-under=" if on_command_line else "hri_fail_under: "
            raise usage_error(f"{where}{error}") from None
        thresholds.setdefault(threshold.kind, threshold)
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
        exemptions = parse_exemptions(config.getini(f"hri_{ini}"), form)
    except ExemptionError as error:
        raise usage_error(f"hri_{ini}: {error}") from None
    name = f"--hri-{option.replace('_', '-')}"
    for value in config.getoption(f"hri_{option}") or ():
        # Several names are separated by commas; conditions and reasons may have commas of their own.
        for text in [value] if re.search(r":|\s(?:in|of|when|until)\s", value) else value.split(","):
            try:
                exemption = parse_exemption(text, form, reason=f"named with {name}")
            except ExemptionError as error:
                raise usage_error(f"{name}={error}") from None
            before = exemptions.get(exemption.requirement)
            if before is None or _where(before) != _where(exemption):
                exemptions[exemption.requirement] = exemption
    return exemptions


def _where(exemption: Exemption) -> tuple[object, ...]:
    return exemption.condition, exemption.suites, exemption.causes


def session_day(config: pytest.Config) -> datetime.date:
    """The day on which the session began (UTC), taken once: a session over midnight has one day."""
    session_day = getattr(config, "workerinput", {}).get(SESSION_DAY)
    if session_day is not None:
        return datetime.date.fromisoformat(session_day)
    return config.stash.setdefault(_DAY, datetime.datetime.now(datetime.UTC).date())
