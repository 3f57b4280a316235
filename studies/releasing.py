"""Whether a release can be made: tag, version and changelog have to agree. Prints the release's notes.

python -m studies.releasing v0.1.0
"""

from __future__ import annotations

import re
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
_HEADING = re.compile(r"^## (?P<version>\S+) \((?P<when>[^)]*)\)$", re.MULTILINE)
_DATE = re.compile(r"\d{4}-\d{2}-\d{2}")


class ReleaseError(Exception):
    """The release is not ready; the text says which file has to say what."""


def main(arguments: list[str]) -> int:
    """Print the notes of the release that a tag names; the exit status is 1 if there can be none."""
    (tag,) = arguments
    try:
        print(notes(tag, ROOT))
    except ReleaseError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def notes(tag: str, root: Path) -> str:
    """The section of the changelog on the version that a tag such as `v0.1.0` releases.

    Raises:
        ReleaseError: pyproject.toml has another version, or the changelog does not begin with this one and a date.
    """
    version = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    if tag != f"v{version}":
        raise ReleaseError(f"pyproject.toml: version is {version!r}, so the tag has to be 'v{version}'; it is {tag!r}")
    text = (root / "CHANGELOG.md").read_text(encoding="utf-8")
    headings = [*_HEADING.finditer(text)]
    if not headings or headings[0]["version"] != version or not _DATE.fullmatch(headings[0]["when"]):
        first = repr(headings[0][0]) if headings else "none"
        raise ReleaseError(
            f"CHANGELOG.md: the first heading of a version is {first}; expected '## {version} (YYYY-MM-DD)', "
            "with the day of the release"
        )
    end = headings[1].start() if len(headings) > 1 else len(text)
    return text[headings[0].end() : end].strip()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
