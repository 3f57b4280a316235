"""`FilmResult`: the record of a film in `report.json`, with its files and the simulated times of its frames.

`FilmMaker` makes it; `FilmFeature` puts it into the result of a test as its section `FILM`.
"""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta
from msgspec.structs import replace

from pytest_hricdv._base.record import Count, NotNegative, PlainRecord
from pytest_hricdv.results.section import FileNames, TestSection

FOLDER = "films"
"""The report's folder with the films."""


VideoName = Annotated[str, Meta(pattern=r"^films/[A-Za-z0-9._-]+\.(mp4|gif)\Z")]
StripName = Annotated[str, Meta(pattern=r"^films/[A-Za-z0-9._-]+\.png\Z")]
"""Paths of a film and of its strip, relative to the report. They become links on the page, so they are restricted."""


class FilmResult(PlainRecord, frozen=True, kw_only=True):
    """The film of a failed test, with paths relative to the report.

    Args:
        video: the film itself; None if there is none.
        strip: a picture with its key frames.
        seconds: how long it lasts.
        note: why there is none, or what is wrong with it.
        times_s: the simulated time of each frame (s); empty in reports of older versions.
    """

    video: VideoName | None
    strip: StripName | None
    seconds: NotNegative | None
    frames: Count
    note: str
    times_s: tuple[NotNegative, ...] = ()


def _rename_files(film: FilmResult | None, names: FileNames) -> FilmResult | None:
    return film and replace(film, video=names.file(FOLDER, film.video), strip=names.file(FOLDER, film.strip))


FILM: TestSection[FilmResult | None] = TestSection(
    "film", FilmResult | None, None, rename=_rename_files, folder=FOLDER, suffixes=(".mp4", ".gif", ".png")
)
"""The film of a test that failed in a session with `--hri-film`."""

TEST_SECTIONS = (FILM,)
