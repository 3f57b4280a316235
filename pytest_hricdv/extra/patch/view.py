"""`PatchView` shows patch coverage, the coverage of changed statements, in a report."""

from __future__ import annotations

from collections.abc import Iterator

from pytest_hricdv._base.message import visible
from pytest_hricdv.extra.patch.records import PATCH, FilePatch, Patch
from pytest_hricdv.report.formatting import Line, percent, plural
from pytest_hricdv.report.view import PageSection, View
from pytest_hricdv.results.model import Report


class PatchView(View):
    """The view of changed statements: how many are executed, and which are not."""

    name = "patch"

    def lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The sentence, and the places that no test reaches."""
        if (patch := PATCH.of(report)) is not None:
            yield Line(visible(f"{'patch':14}{sentence(patch)}"))
            for file in patch.files:
                if missing := list_gaps(file):
                    yield Line(visible(f"  {file.file}  {missing}"), "warn")

    def section(self, report: Report) -> PageSection | None:
        """The files, each with its statements that are not executed."""
        patch = PATCH.of(report)
        if patch is None:
            return None
        values = {
            "sentence": sentence(patch),
            "base": patch.base[:12],
            "rows": [(file, list_gaps(file)) for file in patch.files],
        }
        return PageSection("patch", "Patch", "patch/patch.html.jinja", values, headline=f"Patch: {sentence(patch)}")

    def markdown(self, report: Report) -> Iterator[str]:
        """The sentence."""
        if (patch := PATCH.of(report)) is not None:
            yield f"Patch: {sentence(patch)}"
            for file in patch.files:
                if missing := list_gaps(file):
                    yield f"{file.file}: not executed {missing}"

    def properties(self, report: Report) -> Iterator[tuple[str, object]]:
        """The percentage."""
        patch = PATCH.of(report)
        if patch is not None and patch.percent is not None:
            yield "hri.patch", f"{patch.percent:.2f}"


VIEW = PatchView()


def sentence(patch: Patch) -> str:
    """`6 tests execute 12 of 14 statements that changed since main (85.7 %), 1 of them fails: R2`."""
    if not patch.files:
        return f"no statement of the code under test changed since {patch.revision}"
    counted = f"{plural(patch.statements, 'statement')} that changed since {patch.revision}"
    if patch.percent is None:
        return f"{counted}; no coverage was measured"
    execute = "executes" if patch.tests == 1 else "execute"
    text = f"{plural(patch.tests, 'test')} {execute} {patch.hits} of {counted} ({percent(patch.percent)})"
    if not patch.failed:
        return text
    violated = f": {', '.join(patch.violated)}" if patch.violated else ""
    return f"{text}, {patch.failed} of them {'fails' if patch.failed == 1 else 'fail'}{violated}"


def list_gaps(file: FilePatch) -> str:
    """`31, 33, branch 40->44`: statements and branches that no test reaches."""
    branches = [f"branch {start}->{'exit' if end < 0 else end}" for start, end in file.missing_branches]
    return ", ".join([*map(str, file.missing_lines), *branches])
