"""Which files a session writes for other tools: options, ini keys, and what GitHub's environment asks for."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import pytest

from pytest_hricdv.session.option_table import FILES


@dataclass(frozen=True)
class ExportOptions:
    """The files to write; None for those that were not asked for.

    `job_summary` is GitHub's, and is appended to; `github` says that the session runs in a workflow there.
    """

    cobertura: Path | None
    lcov: Path | None
    summary: Path | None
    job_summary: Path | None
    github: bool

    @classmethod
    def read(cls, config: pytest.Config) -> ExportOptions:
        """The files in force. Raises pytest.UsageError for one that cannot be written."""
        named = {name: _path(config, name) for name in FILES}
        given = [path for path in named.values() if path is not None]
        twice = next((path for path in given if given.count(path) > 1), None)
        if twice is not None:
            names = " and ".join(f"--hri-{name}" for name, path in named.items() if path == twice)
            raise pytest.UsageError(f"{names}: expected a file for each, and both are to be {twice}")
        return cls.of(named)

    @classmethod
    def of(cls, named: Mapping[str, Path | None]) -> ExportOptions:
        """These files, and what GitHub's environment asks for."""
        job = os.environ.get("GITHUB_STEP_SUMMARY", "")
        return cls(**named, job_summary=Path(job) if job else None, github=os.environ.get("GITHUB_ACTIONS") == "true")


def _path(config: pytest.Config, name: str) -> Path | None:
    given = config.getoption(f"hri_{name}")
    text = str(config.getini(f"hri_{name}") if given is None else given).strip()
    if not text:
        if given is not None:
            raise pytest.UsageError(f"--hri-{name}: expected the name of a file to write")
        return None
    path = config.invocation_params.dir / text
    if path.is_dir():
        raise pytest.UsageError(f"--hri-{name}={text}: expected the name of a file to write, and there is a folder")
    return path
