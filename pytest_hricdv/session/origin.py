"""Where the report of a session comes from: read when it is made."""

from __future__ import annotations

import datetime
import shutil
import subprocess
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import pytest

from pytest_hricdv.results.origin import ReportOrigin

_TIMEOUT_S = 10.0
_PACKAGES = ("pytest", "pytest-xdist", "coverage")


def origin(config: pytest.Config, began: datetime.datetime, made_with: Mapping[str, str]) -> ReportOrigin:
    """Where the report of this session comes from.

    Args:
        began: when the session did (UTC).
        made_with: what records depend on, name -> version.
    """
    revision = _git(config.rootpath, "rev-parse", "HEAD")
    return ReportOrigin(
        began=began.isoformat(timespec="seconds"),
        command=tuple(map(str, config.invocation_params.args)),
        revision=revision,
        dirty=bool(revision and _git(config.rootpath, "status", "--porcelain", "--untracked-files=no")),
        ini=_relative(config.inipath, config.rootpath),
        versions={**made_with, **{name: version(name) for name in _PACKAGES}},
    )


def _git(folder: Path, *arguments: str) -> str:
    """What git prints; nothing where there is no git, or no repository."""
    git = shutil.which("git")
    if git is None:
        return ""
    try:
        done = subprocess.run([git, "-C", str(folder), *arguments], capture_output=True, text=True, timeout=_TIMEOUT_S)
    except (OSError, subprocess.SubprocessError, UnicodeDecodeError):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def _relative(path: Path | None, root: Path) -> str:
    if path is None:
        return ""
    return path.relative_to(root).as_posix() if path.is_relative_to(root) else path.name
