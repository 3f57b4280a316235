"""`FailingTests`: a report's failing tests by cause, for `terminal_summary`, `markdown` and `annotations`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv._base.message import list_names, visible
from pytest_hricdv.execution.judge import ENGINE_SENSITIVE
from pytest_hricdv.report.formatting import Line, listing, pad, plural, split_first, width, wrap
from pytest_hricdv.report.view import FailureCause, FailureCauses, failure_causes
from pytest_hricdv.report.violations import is_known, order_failures
from pytest_hricdv.results.model import Report, TestResult

MAX_CAUSES = 5
"""Most causes shown, and most tests without a cause, unless all are asked for (chosen: a screen)."""

_GAP = "  "


@dataclass(frozen=True)
class FailingTests:
    """The tests that failed, by their causes.

    Args:
        tests: node id -> test.
        causes: None if nobody looked for them.
    """

    report: Report
    tests: Mapping[str, TestResult]
    causes: FailureCauses | None

    @classmethod
    def of(cls, report: Report, columns: int | None = None) -> FailingTests:
        """The failing tests of a report; texts on causes fit into this many columns."""
        tests = {test.nodeid: test for test in report.tests if test.outcome == "failed"}
        return cls(report, tests, failure_causes(report, columns))

    @property
    def groups(self) -> list[tuple[FailureCause | None, list[str]]]:
        """Each cause with the tests that no cause before it has; last, the tests of none."""
        left = dict.fromkeys(self.tests)
        groups: list[tuple[FailureCause | None, list[str]]] = []
        for cause in self.causes.causes if self.causes else ():
            groups.append((cause, [nodeid for nodeid in cause.tests if nodeid in left]))
            left = {nodeid: None for nodeid in left if nodeid not in cause.tests}
        return [*groups, (None, [*left])] if left else groups

    @property
    def examples(self) -> list[str]:
        """The node ids of the tests that stand for the others, in the order in which they are to be shown."""
        return [nodeids[0] for cause, nodeids in self.groups if nodeids and cause is not None] + [
            nodeid for cause, nodeids in self.groups if cause is None for nodeid in nodeids
        ]

    def labels(self) -> dict[str, str]:
        """Node id -> its causes, as `cause 1`, or `causes 1, 2`."""
        labels: dict[str, list[str]] = {}
        for cause in self.causes.causes if self.causes else ():
            for nodeid in cause.tests:
                labels.setdefault(nodeid, []).append(cause.label)
        return {nodeid: _join_labels(of_test) for nodeid, of_test in labels.items()}

    def lines(self, columns: int | None, *, all_rows: bool = False) -> Iterator[Line]:
        """Lines on why tests fail: the first causes with some of their tests.

        Args:
            columns: as many as a line may have; None for any number.
            all_rows: whether to list all causes, with a line for each of their tests.
        """
        groups = self.groups
        shown, more = split_first(groups, len(groups) if all_rows else MAX_CAUSES)
        for cause, nodeids in shown:
            yield from cause.lines if cause is not None else self._lines_without_cause(nodeids)
            if all_rows and len(self.tests) > 1:
                yield from self.rows(nodeids, columns)
            elif cause is not None and len(nodeids) > 1:
                yield self._also(nodeids[1:], columns)
        if more:
            yield Line(f"and {more} more: -v shows all", "bad")
        if all_rows:
            yield from self._replays(columns)
            if self.causes is not None and self.causes.remark:
                yield from (Line(line, "dim") for line in _wrap_lines(self.causes.remark, columns))

    def list_causes(self, columns: int) -> Iterator[Line]:
        """How many causes, then each; nothing if nobody looked for them."""
        if self.causes is not None:
            yield from (Line(self.headline, "title"), *self.lines(columns))

    @property
    def headline(self) -> str:
        """`24 tests fail for 3 causes`."""
        if self.causes is not None:
            return visible(self.causes.headline)
        return f"{plural(len(self.tests), 'test')} failed"

    def _lines_without_cause(self, nodeids: Sequence[str]) -> Iterator[Line]:
        """How many, with a line for the first of them."""
        if self.causes is not None:
            yield Line(f"{plural(len(nodeids), 'more test')} failed", "bad")
        first, more = split_first(nodeids, MAX_CAUSES)
        for nodeid in first:
            test = self.tests[nodeid]
            yield Line(visible(f"  {test.id}  {' '.join(self._failure_names(test))}"))
        if more:
            yield Line(f"  and {more} more: -v lists all")

    def _also(self, nodeids: Sequence[str], columns: int | None) -> Line:
        names = [visible(self.tests[nodeid].id) for nodeid in nodeids]
        if columns is None:
            return Line(f"  also   {list_names(names, MAX_CAUSES)}")
        first, more = split_first(names, MAX_CAUSES)
        return Line(f"  also   {listing(first, columns - 9, more)}")

    def rows(self, nodeids: Sequence[str], columns: int | None = None) -> Iterator[Line]:
        """`id  R29 R21  replay`: ids are never cut, and commands are complete or left out."""
        tests = [self.tests[nodeid] for nodeid in nodeids]
        if not tests:
            return
        names = [" ".join(self._failure_names(test)) for test in tests]
        id_columns, name_columns = max(width(test.id) for test in tests), max(map(width, names))
        start = width(_GAP) + id_columns + width(_GAP)
        for test, failed in zip(tests, names, strict=True):
            head = f"{_GAP}{pad(visible(test.id), id_columns)}{_GAP}"
            if self._fits(columns):
                yield Line(f"{head}{pad(failed, name_columns)}{_GAP}{visible(test.replay or '')}".rstrip())
                continue
            for line in wrap(failed.split(" "), max((columns or 0) - start, 8)):
                yield Line(f"{head}{line}".rstrip())
                head = " " * start

    def _fits(self, columns: int | None) -> bool:
        """Whether there is room for replay files next to all tests: rows of one list are all alike."""
        if columns is None:
            return True
        ids = max(width(visible(test.id)) for test in self.tests.values())
        names = max(width(" ".join(self._failure_names(test))) for test in self.tests.values())
        replays = max(width(visible(test.replay or "")) for test in self.tests.values())
        return 3 * width(_GAP) + ids + names + replays <= columns

    def _replays(self, columns: int | None) -> Iterator[Line]:
        """How the replay files are named that have no room next to their tests."""
        replayed = next((test for test in self.tests.values() if test.replay), None)
        if len(self.tests) > 1 and replayed is not None and replayed.replay and not self._fits(columns):
            folder = visible(replayed.replay).removesuffix(f"{visible(replayed.id)}.json")
            yield Line(f"replay each: --hri-replay={folder}ID.json", "dim")

    def _failure_names(self, test: TestResult) -> list[str]:
        """The requirements that a test failed for, by the time of their violation."""
        declared = {} if self.report.strict else self.report.known_violations
        names = [name for name in order_failures(test, declared) if not is_known(name, test, declared)]
        names += ["fault"] if test.errors else []
        # On the engine that the report is of, such a test may violate nothing.
        by_engine = ENGINE_SENSITIVE if test.failure.startswith(ENGINE_SENSITIVE) else "failed"
        return [visible(name) for name in names] or [by_engine]


def _join_labels(labels: Sequence[str]) -> str:
    """`cause 1`, or `causes 1, 2`."""
    if len(labels) == 1:
        return labels[0]
    word = labels[0].partition(" ")[0]
    return f"{word}s {', '.join(label.partition(' ')[2] for label in labels)}"


def _wrap_lines(text: str, columns: int | None) -> list[str]:
    return [visible(text)] if columns is None else wrap(visible(text).split(" "), columns)
