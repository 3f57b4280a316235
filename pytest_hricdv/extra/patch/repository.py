"""Changes since a revision, according to git."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

_TIMEOUT_S = 60.0
"""Time limit of a git command, which takes milliseconds: a network folder that does not answer ends the comparison."""

_HUNK = re.compile(r"^@@ -\d+(?:,\d+)? \+(\d+)(?:,(\d+))? @@", re.MULTILINE)


class PatchError(Exception):
    """Git cannot make the comparison."""


class Repository:
    """The repository that a folder is in.

    Raises:
        PatchError: there is no git, or no repository.
    """

    def __init__(self, folder: Path) -> None:
        found = shutil.which("git")
        if found is None:
            raise PatchError("it needs git, and there is none on PATH")
        self._git, self._folder = found, folder
        self._run("rev-parse", "--show-toplevel")

    def find_base(self, revision: str) -> str:
        """The commit at which HEAD and a revision went apart: what a pull request is compared with.

        Raises:
            PatchError: there is no such revision, or they have nothing in common.
        """
        self._run(
            "rev-parse",
            "--verify",
            "--quiet",
            "--end-of-options",
            f"{revision}^{{commit}}",
            lacks=f"revision {revision} in {self._folder}",
        )
        unrelated = f"commit that {revision} and HEAD have in common; a shallow clone needs git fetch --unshallow"
        return self._run("merge-base", "--end-of-options", revision, "HEAD", lacks=unrelated)

    def find_changed_lines(self, base: str, path: Path) -> frozenset[int] | None:
        """The lines of a file that are new or changed since a commit; None for all of them, as in a new file.

        Raises:
            PatchError: git ignores the file, or cannot compare it.
        """
        if not self._run("ls-files", "--", str(path)):
            if not self._run("ls-files", "--others", "--exclude-standard", "--", str(path)):
                raise PatchError(f"git ignores {path}, so nobody knows what changed there")
            return None
        options = ("--unified=0", "--inter-hunk-context=0", "--no-color", "--no-ext-diff", "--no-textconv", "--text")
        hunks = _HUNK.findall(self._run("diff", *options, base, "--", str(path)))
        return frozenset(line for first, count in hunks for line in range(int(first), int(first) + int(count or 1)))

    def _run(self, *arguments: str, lacks: str = "") -> str:
        """The output of git; PatchError if it fails, with `lacks` as the missing thing, or with git's own words."""
        try:
            done = subprocess.run(
                [self._git, "-C", str(self._folder), *arguments],
                capture_output=True,
                encoding="utf-8",
                errors="replace",
                timeout=_TIMEOUT_S,
            )
        except (OSError, subprocess.SubprocessError) as error:
            raise PatchError(f"git {arguments[0]} in {self._folder}: {error}") from None
        if done.returncode:
            said = done.stderr.strip().partition("\n")[0] or f"exit status {done.returncode}"
            raise PatchError(f"there is no {lacks}" if lacks else f"git {arguments[0]} in {self._folder}: {said}")
        return done.stdout.strip()
