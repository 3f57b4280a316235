"""The options of the group `hri` and their ini keys, which `plugin` adds to pytest by `add_options`."""

from __future__ import annotations

import dataclasses
import datetime
import itertools
import shlex
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Any

import pytest

from pytest_hricdv.report import EXPORT_FORMATS
from pytest_hricdv.results.gates import KINDS
from pytest_hricdv.session.option import (
    FAIL_ON,
    Flag,
    Option,
    OptionGroup,
    OptionReader,
    Repeatable,
    Value,
    feature_options,
    usage_error,
)

TESTS = (
    Value(
        "suite",
        "NAME|PATH[,...]",
        "generate and run these suites: by-hand, bdi-random, rl, pseudorandom, all, closure, or a file or folder of "
        "abstract tests. Unless paths are given, only the files of hri_testpaths are collected, and only items that "
        "ask for hri_case.",
    ),
    Value("seed", "N", "seed of generation and concretization (default 0)"),
    Value("tests", "N", "number of abstract tests per suite (default: the method's own)"),
    Value("concretizations", "K", "concrete tests per abstract test (default 1)"),
    Value(
        "sampling",
        "NAME",
        "how parameters are drawn from their ranges: uniform (default), or corners (extreme values every other time)",
    ),
    Value("fidelity", "NAME", "how the world is simulated: one of the testbench's fidelities"),
    Value(
        "shard",
        "INDEX/OF",
        "run one part of the suite, for instance 1/3; merge the reports afterwards",
        key=False,
    ),
    Value(
        "replay",
        "FILE[,...]",
        "instead of a suite, run the tests of these replay files (folder 'failures' of a report), and check that the "
        "record of each run is the same",
        key=False,
    ),
    Flag(
        "replay-force",
        "replay also when the code under test or a version has changed; the record may differ then",
        key=False,
    ),
    Value("export", "DIR", "write the suites as text files, which --hri-suite=DIR reads"),
)

LEARNING = (
    Repeatable(
        "rl",
        "NAME=VALUE",
        "set a constant of Q-learning, for instance gamma=0.2; see QLearning for the names",
        "constants of Q-learning, one NAME=VALUE a line",
    ),
    Value("rl-reward", "NAME", "reward of learning: published (default), or uncovered (what is not covered yet)"),
    Value(
        "rl-start",
        "FILE",
        "start learning from a table that --hri-rl-save wrote, or from belief sets (*.toml, as for by-hand)",
    ),
    Value("rl-save", "FILE", "save the learned table of Q"),
)

WHEN = "'R3 when CONDITION: reason' where a condition holds at the violation, each also with 'until 2027-01-31'"
GATES = (
    Repeatable(
        "fail-under",
        "KIND=PCT",
        "fail when a suite covers less; KIND is one of "
        + ", ".join((*KINDS, *(kind for feature in feature_options() for kind in feature.kinds))),
        "one KIND=PCT a line; checked when the whole suite is selected",
    ),
    Repeatable(
        "known",
        "REQUIREMENT",
        "a requirement whose violations are known, or 'REQUIREMENT when CONDITION' if only those are at which the "
        "condition holds; known violations are reported, but do not fail the run",
        f"one a line, 'R3: reason', or {WHEN}: does not fail the run",
        key="hri_known_violations",
        shown=False,
    ),
    Flag("strict", "also fail on known violations"),
    Value(
        FAIL_ON,
        "KIND[,...]",
        "also fail for nc (a requirement that no test triggered), pending (a trigger undecided at the end of a run), "
        "or change (a test that behaves differently from the baseline)",
    ),
    Flag(
        "fail-on-nc",
        "with --hri-tests, too, fail when no test triggered a requirement (verdict NC in all tests); a whole suite "
        "always does",
    ),
    Repeatable(
        "allow-nc",
        "REQUIREMENT",
        "a requirement that no test need trigger, or 'REQUIREMENT in SUITE,...'",
        "one a line, 'R5: reason', or 'R5 in SUITE,... until 2027-01-31: reason': no test need trigger it",
        shown=False,
    ),
    Flag(
        "fail-on-pending",
        "fail when a requirement was triggered and is undecided at the end of a run, which goes on past its limit only "
        "to the last deadline that is open then",
    ),
    Value(
        "baseline",
        "FILE",
        "compare with this file: new failures, lost coverage and lost triggers fail the run; tests that behave "
        "differently are listed",
    ),
    Flag("update-baseline", "update the file of --hri-baseline", key=False),
    Flag("fail-on-change", "fail when a test behaves differently from the baseline, even where nothing got worse"),
)

AFTER_THE_TESTS = (
    Value(
        "break-on-violation",
        "REQUIREMENT[,...]",
        "stop in a debugger at the instant of a violation, inside the code under test; hri_state has time, signals, "
        "messages, state and verdicts",
        key=False,
    ),
)

RUNS = (
    Flag(
        "resume",
        "resume the session that was killed or interrupted in the folder of --hri-report: tests with a result are "
        "not run again, as long as code, testbench, suites, options and versions are the same",
        key=False,
    ),
    Flag("no-cov", "do not measure the code under test"),
    Flag("no-waivers", "ignore comments '# unreachable:' in the code, which were written for another testbench"),
    Flag("isolate", "run each test in its own process, so that no test sees state left behind by another"),
)

OUTPUT = (Value("report", "DIR", "folder of report.json and index.html (default hri-report)"),)

EXPORTS = tuple(Value(name, "FILE", description, shown=False) for name, description in EXPORT_FORMATS.items())


TESTPATHS = "hri_testpaths"
"""The only key of the ini file without an option."""


_GROUPS: Mapping[OptionGroup, tuple[str, tuple[Option, ...]]] = {
    "tests": ("which tests, and how they run", (*TESTS, *LEARNING, *RUNS)),
    "verdict": ("what fails the session", GATES),
    "after": ("after the last test", AFTER_THE_TESTS),
    "files": ("files", (*OUTPUT, *EXPORTS)),
}
"""Group -> its title, and the options of the core."""


def all_options() -> tuple[Option, ...]:
    """The options of the core and of the features, by group, in the order of --help."""
    return tuple(option for group in _GROUPS for option in _options_of(group))


def _options_of(group: OptionGroup) -> tuple[Option, ...]:
    of_features = (option for feature in feature_options() if feature.group == group for option in feature.options)
    return tuple(map(_in_help, (*_GROUPS[group][1], *of_features)))


def _in_help(option: Option) -> Option:
    """The option as --help shows it: with the names of hidden options that refine it, such as `mutate-tests`."""
    names = [other.name for other in _core_and_features()]
    if any(option.name.startswith(f"{name}-") for name in names):
        return dataclasses.replace(option, shown=False)
    finer = [f"--hri-{name}" for name in names if name.startswith(f"{option.name}-")]
    return dataclasses.replace(option, help=f"{option.help} (also {', '.join(finer)})") if finer else option


@cache
def _core_and_features() -> tuple[Option, ...]:
    core = (option for _, options in _GROUPS.values() for option in options)
    return (*core, *(option for feature in feature_options() for option in feature.options))


def add_options(parser: pytest.Parser) -> None:
    """Register the groups of options and their ini keys."""
    for name, (title, _) in _GROUPS.items():
        group = parser.getgroup(f"hri-{name}", f"hricdv: {title} (all options: docs/reference.md)")
        for option in _options_of(name):
            option.add(group, parser)
    parser.addini(
        TESTPATHS,
        "files and folders of the host tests, relative to the ini file; globs are allowed. With --hri-suite and no "
        "paths, only these are collected (default: testpaths)",
        "paths",
        default=[],
    )


def refuse_typos(config: pytest.Config, arguments: Sequence[str]) -> None:
    """Refuse an option or a key of the ini file that is nearly one of this plugin.

    Raises:
        pytest.UsageError: it is; what is like none is left to pytest.
    """
    words = itertools.takewhile(lambda word: word != "--", arguments)
    options, keys = all_options(), getattr(config, "_inicfg", None) or {}
    for prefix, given, there, where in (
        ("--hri-", (word.partition("=")[0] for word in words), [option.name for option in options], ""),
        ("hri_", keys, [option.ini[4:] for option in options if option.ini] + [TESTPATHS[4:]], f"{config.inipath}: "),
    ):
        for name in given:
            rest = name.removeprefix(prefix)
            near = get_close_matches(rest, there, n=1) if name.startswith(prefix) and rest not in there else []
            if near:
                raise usage_error(f"{where}{name}: there is none; did you mean {prefix}{near[0]}?")


def refuse_unknown_kinds(config: pytest.Config) -> None:
    """Raises pytest.UsageError for a word of `--hri-fail-on` that names no flag."""
    reader, prefix = OptionReader(config), f"{FAIL_ON}-"
    kinds = [option.name.removeprefix(prefix) for option in all_options() if option.name.startswith(prefix)]
    if any(word not in kinds for word in reader.words("fail_on")):
        raise usage_error(f"{reader.setting('fail_on')}: expected some of {', '.join(kinds)}")


_TRUTH = {
    **dict.fromkeys(("1", "yes", "true", "on"), True),
    **dict.fromkeys(("0", "no", "false", "off"), False),
}
"""Words for truth values, as pytest reads them in an ini file."""


def adapt(config: pytest.Config) -> None:
    """Adapt the values of all keys of this plugin, once.

    Raises:
        pytest.UsageError: a value that no ini file could have, such as a table.
    """
    values = getattr(config, "_inicfg", None)  # of pytest 9; before, there were texts only
    if not isinstance(values, dict):
        return
    kinds: dict[str, Any] = {option.ini: option for option in all_options() if option.ini}
    for key in (*kinds, TESTPATHS):
        entry: Any = values.get(key)
        if getattr(entry, "mode", "") != "toml":
            continue
        try:
            value = _convert(key, kinds.get(key), entry.value)
        except ValueError as error:
            raise usage_error(f"{config.inipath}: {key}: {error}") from None
        values[key] = dataclasses.replace(entry, value=value)


def _convert(key: str, kind: object, value: object) -> object:
    if key == TESTPATHS:
        return shlex.split(value) if isinstance(value, str) else [_text(entry) for entry in _as_list(value)]
    if isinstance(kind, Flag):
        return _flag(value)
    if isinstance(kind, Repeatable):
        lines = value.splitlines() if isinstance(value, str) else _as_list(value)
        return [line for entry in lines if (line := _text(entry).strip())]
    return ",".join(_text(entry) for entry in _as_list(value))


def _as_list(value: object) -> list[object]:
    return value if isinstance(value, list) else [value]


def _text(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, str | int | float):
        return str(value)
    kind = "a table" if isinstance(value, dict) else "a list in a list" if isinstance(value, list) else "that"
    raise ValueError(f"expected a string, a number or a list of these; {kind} has no place here: {value!r}")


def _flag(value: object) -> bool:
    if isinstance(value, bool):
        return value
    word = value.strip().lower() if isinstance(value, str) else ""
    if word not in _TRUTH:
        raise ValueError(f"expected true or false, got {value!r}")
    return _TRUTH[word]
