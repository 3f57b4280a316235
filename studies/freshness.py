"""Whether the pictures of the documentation are older than what they show.

    python -m studies.freshness

Prints a line for each picture whose sources have changed since `make pictures` made it; a warning on GitHub. It ends
with status 0 all the same: a changed source need not change its picture.
"""

from __future__ import annotations

import hashlib
import os
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path

from pytest_hricdv._base.atomic_file import replace_file

ROOT = Path(__file__).parents[1]
PICTURES = Path("docs/pictures")
STAMPS = PICTURES / "made-from.toml"

PAGE = ("pytest_hricdv/report",)
FILM = ("controller", "sim", "pytest_hricdv/extra/film")
SUFFIXES = frozenset({".py", ".js", ".css", ".html", ".jinja", ".urdf", ".xml", ".toml"})


def sources_of(picture: str) -> tuple[str, ...]:
    """The folders whose files a picture shows."""
    return FILM if picture == "run.gif" else PAGE


def stamp(folders: Iterable[str], root: Path = ROOT) -> str:
    """A hash of all the files below some folders: their names and what is in them."""
    paths = (path for folder in folders for path in (root / folder).rglob("*") if path.suffix in SUFFIXES)
    digest = hashlib.sha256()
    for path in sorted(paths):
        digest.update(f"{path.relative_to(root).as_posix()}\n".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def stamps(root: Path = ROOT) -> Mapping[str, str]:
    """Picture -> the stamp of its sources when it was made."""
    path = root / STAMPS
    return tomllib.loads(path.read_text(encoding="utf-8")) if path.exists() else {}


def made(pictures: Iterable[str], root: Path = ROOT) -> None:
    """Remember that these pictures are of the sources as they are now."""
    kept = {**stamps(root), **{picture: stamp(sources_of(picture), root) for picture in pictures}}
    lines = [f'"{picture}" = "{kept[picture]}"\n' for picture in sorted(kept) if (root / PICTURES / picture).exists()]
    with replace_file(root / STAMPS) as part:
        part.write_text(
            "# Written by `make pictures`: of which state of its sources each picture is.\n" + "".join(lines)
        )


def outdated(root: Path = ROOT) -> list[str]:
    """The pictures whose sources have changed since they were made."""
    return [picture for picture, before in stamps(root).items() if stamp(sources_of(picture), root) != before]


def main() -> None:
    """Say which pictures are older than what they show."""
    for picture in outdated():
        warning = f"older than what it shows ({', '.join(sources_of(picture))} changed): make pictures"
        path = (PICTURES / picture).as_posix()
        print(f"::warning file={path}::{warning}" if os.environ.get("GITHUB_ACTIONS") else f"{path}: {warning}")


if __name__ == "__main__":
    main()
