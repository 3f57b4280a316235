"""`ReportOrigin`: a report's time, command and revision, for `SessionReporter`; `GenerationResult`: of each suite."""

from __future__ import annotations

import datetime
import shutil
import subprocess
from collections.abc import Iterable, Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

from msgspec import Meta

from pytest_hricdv._base.record import Count, Names, NotNegative, PlainRecord


class LastNewPlan(PlainRecord, frozen=True, kw_only=True):
    """The iteration of learning, and the number of the test, after which no new plan was executed."""

    iteration: Count | None
    test: Count


class Diversity(PlainRecord, frozen=True, kw_only=True):
    """How varied a suite is, before any test has run; `plans_executed` is agent -> number of plans."""

    distinct_subsets: Count
    belief_entropy_bits: NotNegative
    belief_entropy_most_bits: NotNegative
    plans_executed: Mapping[str, Count]
    last_new_plan: LastNewPlan


class GenerationResult(PlainRecord, frozen=True, kw_only=True):
    """How a suite was generated. `q_delta` is the largest change of a cell of Q, one number an iteration."""

    wall_s: NotNegative
    cached: bool
    bdi_runs: Count
    iterations: Count
    converged_at: Count | None
    q_delta: tuple[NotNegative, ...]
    distinct_texts: Count
    reward: str
    diagnosis: Diversity
    notes: Names


_TIMEOUT_S = 10.0
"""Time limit for a call of git (s), which answers within milliseconds. Chosen: a session may wait this long for a
repository that hangs."""

RerunOption = Annotated[
    str,
    Meta(
        pattern=r"^--hri-(?!report|export|rl-save|update|baseline|cobertura|lcov|ucis|summary|history|cluster|send)"
        r"[a-z][a-z0-9-]*(=[\s\S]*)?\Z"
    ),
]
"""It stands in commands that people copy from a report, so it is one of the plugin's own, and none that writes a file:
pytest's `--basetemp=DIR` would empty a folder."""

_PACKAGES = ("pytest", "pytest-xdist", "coverage")


class ReportOrigin(PlainRecord, frozen=True, kw_only=True):
    """The provenance of one session. It is not a result: reports of equal runs differ in it.

    Args:
        began: date and time (UTC, ISO 8601, to the second).
        command: the arguments that pytest was given.
        revision: the revision of the project's git repository; empty if there is none.
        dirty: whether tracked files differed from the revision.
        ini: the file with the options and waivers, relative to the project's root; empty if there is none.
        versions: name -> version, of what runs and measures the tests.
        hash_seed: the hash seed of the processes that ran the tests, in decimal digits; "random" where Python drew it,
            which nobody can repeat; "several" where they differ. Empty: an older version did not say.
    """

    began: str
    command: Names
    revision: str = ""
    dirty: bool = False
    ini: str = ""
    versions: Mapping[str, str] = {}
    hash_seed: str = ""


def origin_of_session(
    arguments: Iterable[object], root: Path, ini: Path | None, began: datetime.datetime, environment: Mapping[str, str]
) -> ReportOrigin:
    """Where the report of a session comes from that ends now.

    Args:
        arguments: the arguments that pytest was given.
        ini: the file with the options, if there is one.
        began: when the session did (UTC).
        environment: what records depend on, name -> version.
    """
    revision = _git(root, "rev-parse", "HEAD")
    return ReportOrigin(
        began=began.isoformat(timespec="seconds"),
        command=tuple(map(str, arguments)),
        revision=revision,
        dirty=bool(revision and _git(root, "status", "--porcelain", "--untracked-files=no")),
        ini=_relative(ini, root),
        versions={**environment, **{name: version(name) for name in _PACKAGES}},
    )


def _git(folder: Path, *arguments: str) -> str:
    """The output of git; empty without git or a repository."""
    git = shutil.which("git")
    if git is None:
        return ""
    try:
        done = subprocess.run(
            [git, "-C", str(folder), *arguments],
            capture_output=True,
            encoding="utf-8",  # git's own, for names and messages
            errors="replace",
            timeout=_TIMEOUT_S,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def _relative(path: Path | None, root: Path) -> str:
    if path is None:
        return ""
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else path.name
