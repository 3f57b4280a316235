"""Patch coverage in a session: its option, and the query of git after the last test."""

from __future__ import annotations

from collections.abc import Sequence
from hashlib import sha256
from types import MappingProxyType
from typing import TYPE_CHECKING, NamedTuple

from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.extra.patch.repository import Repository
    from pytest_hricdv.results.model import Report
    from pytest_hricdv.session.run_context import RunContext

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
            "report which statements that changed since REV, a branch, tag or commit of git, the tests execute",
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
        from pytest_hricdv.extra.patch.repository import PatchError  # with the library for processes

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
        from pytest_hricdv.extra.patch.repository import PatchError

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
        from pytest_hricdv.extra.patch.repository import Repository

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
