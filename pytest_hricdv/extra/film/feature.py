"""Films of failing tests (`--hri-film`): `FilmFeature` makes them, and `FilmView` links to them in the report.

The process that ran a failing test calls `FilmMaker`, which runs it again with a camera in its world. The first run is
never rendered.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from importlib.util import find_spec
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import pytest
from msgspec import to_builtins

from pytest_hricdv.extra.film.records import FILM
from pytest_hricdv.report.view import View
from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, HasFeatures, OptionReader, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.execution.hri_case import HriCase
    from pytest_hricdv.extra.film.film_maker import FilmMaker
    from pytest_hricdv.report.formatting import Line
    from pytest_hricdv.results.model import Report, TestResult
    from pytest_hricdv.session.run_context import RunContext

_FILM_MAKER: pytest.StashKey[FilmMaker] = pytest.StashKey()


class FilmFeature(Feature[bool]):
    """Films failing tests if `--hri-film` is given, which is its setting."""

    name = "film"
    group = "files"
    options = (Flag("film", "film the runs of failing tests"),)

    switched_off = MappingProxyType({"hri_film": False})

    def read(self, reader: OptionReader) -> bool:
        """Whether failing tests are filmed."""
        return reader.flag("film")

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """The option: results with and without films differ."""
        return {"--hri-film": "set" if self.settings(options) else ""}

    def check(self, context: RunContext) -> None:
        """Check that the testbench has a camera, and that Pillow is installed."""
        if not self.settings(context.options):
            return
        testbench = context.collection.testbench
        if testbench.simulation.film is None:
            raise usage_error(
                f"--hri-film: testbench {testbench.name!r} cannot be filmed: "
                "give it simulation=Simulation(film=Film(camera=...))"
            )
        if find_spec("PIL") is None:
            raise usage_error('--hri-film: Pillow is not installed: pip install "pytest-hricdv[sim]"')

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """Add a film to the result of a failed test. Its duration excludes this; its monkeypatches still apply."""
        if not self.settings(context.options) or case.result is None or not result.leaves_evidence:
            return result
        from pytest_hricdv.extra.film.film_maker import film_text

        maker = self._film_maker(context)
        film = maker.film(case.result)
        folder = os.path.relpath(context.options.report, context.collection.config.invocation_params.dir)
        report.sections.append(("film", film_text(film, Path(folder))))
        return FILM.put(result, film)

    def after_isolated_test(self, context: RunContext, result: TestResult) -> None:
        """Count the film of a test that ran in another process, since the number of films is limited."""
        if not self.settings(context.options):
            return
        film = FILM.of(result)
        if film is not None and film.video:
            failed = [name for name in result.requirements if result.violates(name)]
            self._film_maker(context).count(failed)

    def _film_maker(self, context: RunContext) -> FilmMaker:
        from pytest_hricdv.extra.film.film_maker import FilmMaker

        if _FILM_MAKER not in context.stash:
            context.stash[_FILM_MAKER] = FilmMaker(
                context.run_settings, context.options.report, context.violation_exemptions
            )
        return context.stash[_FILM_MAKER]


FEATURE = FilmFeature()


class FilmView(View):
    """Shows the number of films, and the film of a test on its page."""

    name = "film"
    scripts = ("film",)

    def file_lines(self, report: Report, columns: int) -> Iterator[Line]:
        """The number of filmed tests, and why other failing tests were not filmed."""
        from pytest_hricdv.report.formatting import Line, count_notes, plural

        films = [film for test in report.tests if (film := FILM.of(test)) is not None]
        if not films:
            return
        made = sum(film.video is not None for film in films)
        text = f"films: {made} of {plural(len(films), 'failing test')}, next to the report"
        yield Line(text, "ok" if made else "warn")
        yield from count_notes((film.note for film in films), columns)

    def of_test(self, report: Report, test: TestResult) -> dict[str, Any]:
        """The film of the test."""
        return {"film": to_builtins(FILM.of(test))}

    def pictures(self, test: TestResult) -> Iterator[tuple[str, str]]:
        """The film and its key frames, if they exist."""
        film = FILM.of(test)
        for name, file in (("film", film and film.video), ("key frames", film and film.strip)):
            if file:
                yield name, file


VIEW = FilmView()
