"""Patch coverage (`--hri-patch`): `PatchFeature` reports which statements that changed since a git revision are tested.

A `Repository` finds the changed lines; `records.measure` compares them with the coverage of the session's tests.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext

_TIMEOUT_S = 60.0
"""Time limit (s) of a git command, which usually takes milliseconds; in a network folder, it might never end."""

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
        """The commit at which HEAD and a revision diverged, with which a pull request is compared.

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
                raise PatchError(f"git ignores {path}, so changes there are unknown")
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


KIND = "patch"
"""A kind of threshold."""


class PatchOptions(NamedTuple):
    """The revision with which the code is compared; empty for none."""

    revision: str


class PatchFeature(Feature[PatchOptions]):
    """Says which changed statements the tests execute."""

    name = "patch"
    kinds = (KIND,)
    switched_off = MappingProxyType({"hri_patch": None})
    options = (
        Value(
            "patch",
            "REV",
            "report which of the statements changed since REV (a git branch, tag or commit) the tests execute",
        ),
    )

    def read(self, reader: OptionReader) -> PatchOptions:
        """The revision. Raises pytest.UsageError for one that nothing could be reported on."""
        revision = reader.text("patch")
        if revision and reader.flag("no_cov"):
            raise usage_error("--hri-patch and --hri-no-cov: which statements are executed is known from coverage")
        needed = [line for line in reader.config.getoption("hri_fail_under") or () if _kind(line) == KIND]
        if needed and not revision:
            raise usage_error(f"--hri-fail-under={needed[0]}: add --hri-patch=REV, which says what changed")
        return PatchOptions(revision)

    def check(self, context: RunContext) -> None:
        """Whether git knows the revision."""
        if not self.settings(context.options).revision:
            return
        try:
            self._compare(context)
        except PatchError as error:
            raise usage_error(f"--hri-patch: {error}") from None

    def follow_up(self, context: RunContext) -> str:
        """The comparison, where it is asked for."""
        return "the coverage of the patch (--hri-patch)" if self.settings(context.options).revision else ""

    def extend_report(self, session: FeatureSession, report: Report) -> Report:
        """Compare, if asked to."""
        from pytest_hricdv.extra.patch.records import PATCH, measure

        revision = self.settings(session.options).revision
        if not revision:
            return report
        context = session.context
        try:
            repository, base = self._compare(context)
            changed: dict[str, set[int]] = {}
            for file in context.code.files:
                if sha256(file.path.read_bytes()).hexdigest() != context.code.contents[file.name]:
                    raise PatchError(f"{file.path} changed during the session")
                lines = repository.find_changed_lines(base, file.path)
                first = context.code.reporters[str(file.path)].translate_lines(lines or ())
                changed[file.name] = {*file.statements} & {*first} if lines is not None else {*file.statements}
        except (PatchError, OSError) as error:
            session.problems.append(f"--hri-patch: {error}")
            return report
        session.done.add(self.name)
        return PATCH.put(report, measure(report, revision, base, changed))

    def _compare(self, context: RunContext) -> tuple[Repository, str]:

        repository = Repository(context.collection.config.rootpath)
        return repository, repository.find_base(self.settings(context.options).revision)


def _kind(threshold: str) -> str:
    return threshold.partition("=")[0].strip()


def merge(reports: Sequence[Report], merged: Report) -> Report:
    """The merged report with what all tests together reach, where all sessions compared the same code likewise."""
    from pytest_hricdv.extra.patch.records import PATCH, measure

    patches = [PATCH.of(report) for report in reports]
    first = patches[0]
    if first is None or any(patch is None or patch.by_file != first.by_file for patch in patches):
        return merged
    return PATCH.put(merged, measure(merged, first.revision, first.base, first.by_file))


FEATURE = PatchFeature()
