"""Films in a session: tests that fail are filmed where they ran."""

from __future__ import annotations

import os
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from pytest_hricdv.session.feature import Feature
from pytest_hricdv.session.option import Flag, HasFeatures, OptionReader, usage_error

if TYPE_CHECKING:
    from pytest_hricdv.execution.case import HriCase
    from pytest_hricdv.extra.film.filming import Filming
    from pytest_hricdv.results.model import TestResult
    from pytest_hricdv.session.run_context import RunContext

_FILMING: pytest.StashKey[Filming] = pytest.StashKey()


class FilmFeature(Feature[bool]):
    """Films failing tests; its setting is whether it does."""

    name = "film"
    options = (Flag("film", "film the runs of failing tests"),)

    def read(self, reader: OptionReader) -> bool:
        """Whether failing tests are filmed."""
        return reader.flag("film")

    def fingerprint(self, options: HasFeatures) -> Mapping[str, str]:
        """A result names its film."""
        return {"--hri-film": "set" if self.settings(options) else ""}

    def check(self, context: RunContext) -> None:
        """Whether anything can be filmed."""
        if not self.settings(context.options):
            return
        testbench = context.collection.testbench
        if testbench.film is None:
            raise usage_error(
                f"--hri-film: testbench {testbench.name!r} cannot be filmed: "
                "give it film=Film(camera=...) (from pytest_hricdv.testbench import Film)"
            )
        if find_spec("PIL") is None:
            raise usage_error('--hri-film: Pillow is not installed: pip install "pytest-hricdv[sim]"')

    def after_test(
        self, context: RunContext, case: HriCase, result: TestResult, report: pytest.TestReport
    ) -> TestResult:
        """The result with its film, if the test failed: its duration is taken already, its patches still hold."""
        if not self.settings(context.options) or case.result is None or not result.leaves_evidence:
            return result
        from pytest_hricdv.extra.film.filming import film_text
        from pytest_hricdv.extra.film.records import FILM

        filming = self._filming(context)
        film = filming.film(case.result)
        folder = os.path.relpath(context.options.report, context.collection.config.invocation_params.dir)
        report.sections.append(("film", film_text(film, Path(folder))))
        return FILM.put(result, film)

    def after_isolated_test(self, context: RunContext, result: TestResult) -> None:
        """Counts its film among those of this process."""
        if not self.settings(context.options):
            return
        from pytest_hricdv.extra.film.records import FILM

        film = FILM.of(result)
        if film is not None and film.video:
            failed = [name for name in result.requirements if result.violates(name)]
            self._filming(context).count(failed)

    def _filming(self, context: RunContext) -> Filming:
        from pytest_hricdv.extra.film.filming import Filming

        if _FILMING not in context.stash:
            context.stash[_FILMING] = Filming(context.run_settings, context.options.report, context.known_violations)
        return context.stash[_FILMING]


FEATURE = FilmFeature()
