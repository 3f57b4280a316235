"""What the results of a session depend on: suites, options, files and versions. Where all are equal, so are results."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

from pytest_hricdv.session.collection import Collection
from pytest_hricdv.session.options import Options
from pytest_hricdv.session.replaying import Provenance

SOURCES = (".py", ".toml", ".ini", ".asl", ".mas2j")
"""Files of a project that runs can depend on."""

_NO_SOURCES = ("__pycache__", "node_modules", "site-packages", "pyvenv.cfg")
_SHOWN = 5


def fingerprint(collection: Collection, provenance: Provenance) -> dict[str, str]:
    """All that the results of a session depend on: name -> value, or hash.

    Which of the project's files a testbench loads is known only when all tests have run, so all count.
    """
    code = {name: text[:16] for name, text in provenance.code.items()}
    suites = {f"suite {each.suite.name}": _hash(each.suite.to_json().encode()) for each in collection.selected}
    replays = {each.name: _hash(each.replay.to_json().encode()) for each in collection.replays.values()}
    project = files_and_versions(collection.config.rootpath)
    return {**_options(collection.options), **suites, **replays, **project, **code, **provenance.made_with}


def files_and_versions(root: Path) -> dict[str, str]:
    """The sources below a folder, name -> hash, and what is installed, name -> version."""
    return {path.relative_to(root).as_posix(): _hash(path.read_bytes()) for path in _sources(root)} | _versions()


def differences(before: Mapping[str, str], now: Mapping[str, str]) -> str:
    """What is not as it was, on one line; empty where all is."""
    names = sorted(before.keys() | now.keys())
    found = [_difference(name, before.get(name), now.get(name)) for name in names if before.get(name) != now.get(name)]
    more = len(found) - _SHOWN
    return ", ".join(found[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _difference(name: str, before: str | None, now: str | None) -> str:
    if before is None or now is None:
        return f"{name} is new" if before is None else f"{name} is gone"
    is_hash = len(before) == len(now) == len(_hash(b""))
    return f"{name} changed" if is_hash else f"{name} {before or 'unset'}, now {now or 'unset'}"


def _options(options: Options) -> dict[str, str]:
    """The options that results depend on, as far as suites do not tell."""
    known = [f"{name} while {each.condition}" if each.condition else name for name, each in options.known.items()]
    return {
        "--hri-suite": options.suites,
        "--hri-seed": str(options.seed),
        "--hri-concretizations": str(options.concretizations),
        "--hri-sampling": options.sampling,
        "--hri-fidelity": options.fidelity,
        "--hri-engine": options.engine,
        "--hri-shard": str(options.shard or ""),
        "--hri-no-cov": "" if options.coverage else "set",
        "--hri-film": "set" if options.film else "",
        "--hri-strict": "set" if options.strict else "",
        "known violations": ", ".join(sorted(known)),
    }


def _versions() -> dict[str, str]:
    """Installed distribution -> version, by the names of the folders that describe them."""
    found: dict[str, str] = {}
    for folder in sys.path:
        try:
            names = sorted(os.listdir(folder))
        except OSError:
            continue
        for name in names:
            if name.endswith(".dist-info"):
                distribution, _, version = name.removesuffix(".dist-info").partition("-")
                found.setdefault(distribution, version)
    return found


def _sources(root: Path) -> Iterator[Path]:
    """The sources below a folder, but for hidden folders and environments."""
    for folder, folders, names in os.walk(root):
        if "pyvenv.cfg" in names:
            folders.clear()
            continue
        folders[:] = sorted(name for name in folders if not name.startswith(".") and name not in _NO_SOURCES)
        for name in sorted(names):
            path = Path(folder, name)
            if path.suffix in SOURCES and path.is_file():
                yield path


def _hash(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()[:16]
