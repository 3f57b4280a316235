"""The identity of a process that runs tests: its project files and versions. All runs of a report have the same one."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import msgspec

from pytest_hricdv._base import project_files
from pytest_hricdv._base.hash_seed import own_hash_seed


class Identity(msgspec.Struct, frozen=True):
    """The identity that a process reports before its first run.

    Args:
        project: name -> hash of the project's files. Runs of a process with other files are rejected.
        versions: of installed packages and the machine, and Python's hash seed. They may differ, and are stored with
            each run.
    """

    project: Mapping[str, str]
    versions: Mapping[str, str]


def identity(root: Path, code: Mapping[str, str]) -> Identity:
    """The identity of this process.

    Args:
        root: the project's folder.
        code: name -> hash of the files of the code under test, which may be elsewhere.
    """
    of_code = {name: text[:16] for name, text in code.items()}
    here = {"machine": f"{platform.system()} {platform.machine()}", "python": platform.python_version()}
    here["hash seed"] = own_hash_seed()
    return Identity({**project_files.hashes(root), **of_code}, {**project_files.versions(), **here})


def plugin_versions() -> dict[str, str]:
    """The versions that both ends of a cluster must have in common to understand each other."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **{name: version(name) for name in ("pytest-hricdv", "distributed", "msgspec")}}
