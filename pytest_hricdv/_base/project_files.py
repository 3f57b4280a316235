"""What the runs of a project depend on besides its tests: its files and installed packages, by their hashes.

Together they are the `identity` of a process; campaigns and clusters compare it, and `differences` names what differs.
Resumed sessions compare `hashes` and `versions`.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator, Mapping
from hashlib import sha256
from importlib.metadata import version
from pathlib import Path

import msgspec

from pytest_hricdv._base.hash_seed import own_hash_seed
from pytest_hricdv._base.message import list_names

SOURCES = (".py", ".toml", ".ini", ".asl", ".mas2j")
"""Suffixes of the files of a project that runs can depend on."""

_NO_SOURCES = ("__pycache__", "node_modules", "site-packages", "pyvenv.cfg")
_SHOWN = 5  # maximum number of differences that a message names


def hashes(root: Path) -> dict[str, str]:
    """The sources below a folder, name -> hash."""
    return {path.relative_to(root).as_posix(): short_hash(path.read_bytes()) for path in sources(root)}


def versions() -> dict[str, str]:
    """Installed distribution -> version, by the names of the folders that describe them."""
    installed: dict[str, str] = {}
    for folder in sys.path:
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        for name in names:
            if name.endswith(".dist-info"):
                distribution, _, version = name.removesuffix(".dist-info").partition("-")
                installed.setdefault(distribution, version)
    return installed


def sources(root: Path) -> Iterator[Path]:
    """The sources below a folder, but for hidden folders and environments."""
    return (path for path in files(root) if path.suffix in SOURCES)


def files(root: Path) -> Iterator[Path]:
    """All files below a folder, in order, but for hidden folders and environments."""
    for folder, _, names in _walk(root):
        yield from (path for name in names if (path := folder / name).is_file())


def folder_links(root: Path) -> Iterator[Path]:
    """The symbolic links to folders below a folder, in order: they are not followed, so that nothing is found twice."""
    for folder, folders, _ in _walk(root):
        yield from (path for name in folders if (path := folder / name).is_symlink())


def _walk(root: Path) -> Iterator[tuple[Path, list[str], list[str]]]:
    for folder, folders, names in os.walk(root):
        if "pyvenv.cfg" in names:
            folders.clear()
            continue
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name not in _NO_SOURCES)
        yield Path(folder), folders, sorted(names)


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """The differences on one line; empty if there are none."""
    names = sorted(before.keys() | now.keys())
    changed = [name for name in names if before.get(name) != now.get(name)]
    return list_names([_difference(name, before.get(name), now.get(name)) for name in changed], _SHOWN)


def _difference(name: str, before: str | None, now: str | None) -> str:
    if before is None or now is None:
        return f"{name} is new" if before is None else f"{name} is gone"
    is_hash = len(before) == len(now) == len(short_hash(b""))
    return f"{name} changed" if is_hash else f"{name} {before or 'unset'}, now {now or 'unset'}"


def short_hash(data: bytes) -> str:
    """16 hexadecimal digits of SHA-256."""
    return sha256(data).hexdigest()[:16]


class Identity(msgspec.Struct, frozen=True):
    """The identity that a process reports before its first run.

    Args:
        project: name -> hash of the project's files. Runs of a process with other files are rejected.
        versions: the versions of installed packages and the machine, and Python's hash seed. They may differ, and are
            stored with each run.
    """

    project: Mapping[str, str]
    versions: Mapping[str, str]


def identity(root: Path, code: Mapping[str, str]) -> Identity:
    """The identity of this process.

    Args:
        code: name -> hash of the files of the code under test, which may be elsewhere.
    """
    of_code = {name: text[:16] for name, text in code.items()}
    here = {"machine": f"{platform.system()} {platform.machine()}", "python": platform.python_version()}
    here["hash seed"] = own_hash_seed()
    return Identity({**hashes(root), **of_code}, {**versions(), **here})


def plugin_versions() -> dict[str, str]:
    """The versions that both ends of a cluster must have in common to understand each other."""
    python = ".".join(platform.python_version_tuple()[:2])
    return {"python": python, **{name: version(name) for name in ("pytest-hricdv", "distributed", "msgspec")}}
