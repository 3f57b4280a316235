"""The trend in a session: a line on it in the file of `--hri-history`, and earlier ones in its report."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pytest_hricdv._base.input_file import MalformedError
from pytest_hricdv._base.message import visible
from pytest_hricdv.session.feature import Feature, FeatureSession
from pytest_hricdv.session.option import OptionReader, Value

if TYPE_CHECKING:
    from pytest_hricdv.results.model import Report


class TrendFeature(Feature[Path]):
    """Keeps a history of sessions."""

    name = "trend"
    options = (
        Value("history", "FILE", "add a line on this session to FILE (JSON lines), and report the trend over sessions"),
    )

    def read(self, reader: OptionReader) -> Path | None:
        """The file of the history."""
        return reader.file("history")

    def after_gates(self, session: FeatureSession, report: Report) -> Report:
        """Add the session to the history, and earlier ones of the same suites and options to its report.

        A session that did not run whole suites is kept in the file, and compared with nothing.
        """
        path = self.settings(session.options)
        if path is None:
            return report
        from pytest_hricdv.extra.trend import records
        from pytest_hricdv.extra.trend.entry import entry_of

        entry = entry_of(report, is_whole=session.is_whole)
        try:
            earlier, damaged = records.read(path)
            records.append(path, entry)
        except (OSError, MalformedError) as error:
            reason = error.strerror or error if isinstance(error, OSError) else error
            session.problems.append(visible(f"--hri-history: {path}: {reason}"))
            return report
        session.warnings += [f"{path}:{number}: no session of a history; it was left out" for number in damaged]
        entries = (*records.comparable(earlier, entry), entry) if session.is_whole else ()
        return records.HISTORY.put(report, entries)


FEATURE = TrendFeature()
