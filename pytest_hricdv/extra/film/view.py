"""What a report shows of films."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from msgspec import to_builtins

from pytest_hricdv.extra.film.records import FILM
from pytest_hricdv.report.formatting import Line, counted_notes, plural
from pytest_hricdv.report.view import View
from pytest_hricdv.results.model import Report, TestResult


class FilmView(View):
    """How many films there are, and on a test's page its own."""

    name = "film"
    scripts = ("film",)

    def file_lines(self, report: Report, columns: int) -> Iterator[Line]:
        """How many failing tests were filmed, and why others were not."""
        films = [film for test in report.tests if (film := FILM.of(test)) is not None]
        if not films:
            return
        made = sum(film.video is not None for film in films)
        text = f"films: {made} of {plural(len(films), 'failing test')}, beside the report"
        yield Line(text, "ok" if made else "warn")
        yield from counted_notes((film.note for film in films), columns)

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """Its film."""
        return {"film": to_builtins(FILM.of(test))}

    def pictures(self, test: TestResult) -> Iterator[tuple[str, str]]:
        """The film and its key frames, as far as they were made."""
        film = FILM.of(test)
        for name, file in (("film", film and film.video), ("key frames", film and film.strip)):
            if file:
                yield name, file


VIEW = FilmView()
