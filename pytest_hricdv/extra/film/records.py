"""The film of a failed test, as a report names it."""

from __future__ import annotations

from msgspec.structs import replace

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv.results.section import FileNames, TestSection

FOLDER = "films"
"""Of the report: the files are in it."""


class FilmResult(PlainRecord, frozen=True, kw_only=True):
    """The film of a failed test, with paths relative to the report; `note` says why there is none, or what is wrong."""

    video: str | None
    strip: str | None
    seconds: NotNegative | None
    frames: Count
    note: str


def _renamed(film: FilmResult | None, names: FileNames) -> FilmResult | None:
    return film and replace(film, video=names.file(FOLDER, film.video), strip=names.file(FOLDER, film.strip))


FILM: TestSection[FilmResult | None] = TestSection("film", FilmResult | None, None, rename=_renamed, folder=FOLDER)
"""Of a test that failed in a session with `--hri-film`."""

TEST_SECTIONS = (FILM,)
