"""What the runs of this repository depend on: files with their hashes, and versions."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

DEPENDS = (
    "conftest.py",
    "controller",
    "models_bdi",
    "pyproject.toml",
    "pytest_hricdv",
    "sim",
    "tests/hri/by_hand.toml",
    "tests/hri/requirements.toml",
    "tests/hri/test_table_assembly.py",
)
"""Files and folders that suites, records and verdicts depend on."""

LIBRARIES = ("pytest-hricdv", "pybullet", "numpy", "coverage")
"""Libraries whose versions can change results."""


class DependencyError(Exception):
    """What runs are said to depend on is not there."""


def depends(root: Path, names: Iterable[str] = DEPENDS) -> dict[str, str]:
    """Hashes of files, and of all files in folders, and versions of libraries.

    Args:
        root: the project's folder.
        names: of files and folders in it.

    Raises:
        DependencyError: one of them does not exist.
    """
    versions = {}
    for name in names:
        path = root / name
        if not path.exists():
            raise DependencyError(f"{path}: there is no such file or folder, though runs are said to depend on it")
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.is_file() and "__pycache__" not in file.parts:
                versions[file.relative_to(root).as_posix()] = hashlib.sha256(file.read_bytes()).hexdigest()
    versions["python"] = platform.python_version()
    versions["machine"] = platform.machine()
    for library in LIBRARIES:
        try:
            versions[library] = version(library)
        except PackageNotFoundError:
            continue
    return versions
