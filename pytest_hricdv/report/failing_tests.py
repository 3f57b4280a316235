"""The failing tests of a report in the terminal: what they fail for, and a line for each, before all else."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from pytest_hricdv._base.message import visible
from pytest_hricdv.execution.judge import ENGINE_SENSITIVE
from pytest_hricdv.report.formatting import Line, pad, plural, width, wrap
from pytest_hricdv.report.view import FailureCause, FailureCauses, failure_causes
from pytest_hricdv.report.violations import is_known, order_failures
from pytest_hricdv.results.model import Report, TestResult

MAX_ROWS = 40
"""So many tests have a line, unless all are asked for. Chosen: two screens; pytest's own list has all."""

_GAP = "  "


@dataclass(frozen=True)
class FailingTests:
    """The tests that failed, by their causes.

    Args:
        report: of the session.
        tests: node id -> test.
        causes: None where nobody looked for them.
    """

    report: Report
    tests: Mapping[str, TestResult]
    causes: FailureCauses | None

    @classmethod
    def of(cls, report: Report, columns: int | None = None) -> FailingTests:
        """Those of a report; what is said of causes fits into so many columns."""
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
        """What tests fail for, each cause with a line for each of its tests.

        Args:
            columns: as many as a line may have; None for any number.
            all_rows: not only the first `MAX_ROWS`.
        """
        if self.causes is not None:
            yield Line(visible(self.causes.headline), "title")
        elif len(self.tests) > 1:
            yield Line(f"{plural(len(self.tests), 'test')} failed", "title")
        room = len(self.tests) if all_rows else MAX_ROWS
        for cause, nodeids in self.groups:
            if cause is not None:
                yield from cause.lines
            elif self.causes is not None:
                yield Line(f"{plural(len(nodeids), 'more test')} failed", "bad")
            if len(self.tests) > 1:
                yield from self.rows(nodeids[:room], columns)
                room = max(0, room - len(nodeids))
        yield from self._replays(columns)
        if not all_rows and len(self.tests) > MAX_ROWS:
            yield Line(f"and {plural(len(self.tests) - MAX_ROWS, 'more test')}: -v lists all", "dim")
        if self.causes is not None and self.causes.remark:
            yield from (Line(line, "dim") for line in _wrap_lines(self.causes.remark, columns))

    def rows(self, nodeids: Sequence[str], columns: int | None = None) -> Iterator[Line]:
        """`id  R29 R21  replay`: nothing that tells tests apart is cut, and commands are whole or not there."""
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
        """Whether there is room for replay files beside all tests: rows of one list are all alike."""
        if columns is None:
            return True
        ids = max(width(visible(test.id)) for test in self.tests.values())
        names = max(width(" ".join(self._failure_names(test))) for test in self.tests.values())
        replays = max(width(visible(test.replay or "")) for test in self.tests.values())
        return 3 * width(_GAP) + ids + names + replays <= columns

    def _replays(self, columns: int | None) -> Iterator[Line]:
        """How the replay files are named that have no room beside their tests."""
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
