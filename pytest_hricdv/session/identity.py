"""Who works: the project and the versions that a process found. Runs of other projects are no part of a report."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

import msgspec

from pytest_hricdv._base import project_files
from pytest_hricdv._base.hash_seed import own_hash_seed


class Identity(msgspec.Struct, frozen=True):
    """What a process says of itself before its first run.

    Args:
        project: the project's files, name -> hash: where they are others, its runs are not those that are asked for.
        versions: of what is installed, of the machine, and Python's hash seed: these may differ, and are kept beside
            each run.
    """

    project: Mapping[str, str]
    versions: Mapping[str, str]


def identity(root: Path, code: Mapping[str, str]) -> Identity:
    """Of this process.

    Args:
        root: the project's folder.
        code: files of the code under test, which may be elsewhere: name -> hash.
    """
    of_code = {name: text[:16] for name, text in code.items()}
    here = {"machine": f"{platform.system()} {platform.machine()}", "python": platform.python_version()}
    here["hash seed"] = own_hash_seed()
    return Identity({**project_files.hashes(root), **of_code}, {**project_files.versions(), **here})


def plugin_versions() -> dict[str, str]:
    """The versions that both ends of a cluster need to have in common: what is sent is understood by the same only."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **{name: version(name) for name in ("pytest-hricdv", "distributed", "msgspec")}}
