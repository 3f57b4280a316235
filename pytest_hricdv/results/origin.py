"""Where a report comes from: when, of which revision of the project, and by which command it was made."""

from __future__ import annotations

from collections.abc import Mapping

from pytest_hricdv._base.record import Names, PlainRecord


class ReportOrigin(PlainRecord, frozen=True, kw_only=True):
    """Of one session. It is no result: reports of equal runs differ in it.

    Args:
        began: date and time (UTC, ISO 8601, to the second).
        command: the arguments that pytest was given.
        revision: of the project's git repository; empty where there is none.
        dirty: tracked files differed from the revision.
        ini: the file with the options and waivers, relative to the project's root; empty where there is none.
        versions: name -> version, of what runs and measures the tests.
    """

    began: str
    command: Names
    revision: str = ""
    dirty: bool = False
    ini: str = ""
    versions: Mapping[str, str] = {}
