"""`FilmMaker`: films a failed test by rerunning it with a camera in its world. Measured runs are never rendered.

`FilmFeature` calls it in the process that ran the test. It uses `schedule`, `FilmRecorder` and `video`.
"""

from __future__ import annotations

import contextlib
import glob
import io
import os
import re
from collections import Counter
from collections.abc import Container, Iterator, Sequence
from itertools import chain
from pathlib import Path

import msgspec

from pytest_hricdv._base.atomic_file import replace_file
from pytest_hricdv._base.contained import inside
from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.execution.forks import ForkError, call_in_fork
from pytest_hricdv.execution.judge import list_undeclared_violations
from pytest_hricdv.extra.film.recorder import Alarm, FilmedWorld, FilmRecorder
from pytest_hricdv.extra.film.records import FOLDER, FilmResult
from pytest_hricdv.extra.film.schedule import Schedule, key_moments, schedule
from pytest_hricdv.extra.film.video import FRAMES_PER_S, Video, video
from pytest_hricdv.report.formatting import plural
from pytest_hricdv.report.violations import violation_line
from pytest_hricdv.runtime import Record
from pytest_hricdv.testbench import Film, Run, TestbenchError

FILMS_EACH = 5
"""Maximum number of filmed failures of each requirement in a process: a film takes far longer than its test."""


class FilmMaker:
    """Films the failures of one process.

    Args:
        settings: the settings of the session's runs, with a testbench that has a film.
        folder: the report's folder; films go into a folder inside.
        known_violations: requirements with declared violations; a film shows only others, if there are any.
    """

    def __init__(self, settings: RunSettings, folder: Path, known_violations: Container[str] = ()) -> None:
        self._settings = settings
        self._folder = folder
        self._known = known_violations
        self._filmed: Counter[str] = Counter()

    def film(self, result: CaseResult) -> FilmResult:
        """Film the run that gave this result.

        Errors are written into its `note`: a failed test must be reported even when the disk is full.
        """
        failed = _film_subjects(result.failed)
        if all(self._filmed[requirement] >= FILMS_EACH for requirement in failed):
            failures = " and ".join(failed) or "an assertion"
            return _without(
                f"not filmed: {plural(FILMS_EACH, 'failure')} of {failures} had been filmed in this process; "
                "run this test alone to see it"
            )
        self.count(result.failed)
        if not hasattr(os, "fork"):
            return self._film_here(result)
        return self._in_fork(result)

    def _in_fork(self, result: CaseResult) -> FilmResult:
        """Film it in a fork: a renderer or its driver that dies takes neither the session nor the result along."""
        try:
            made = call_in_fork(lambda: msgspec.json.encode(self._film_here(result)))
        except ForkError as error:
            for rest in (self._folder / FOLDER).glob(f".{glob.escape(_file_name(result))}.*.part"):
                rest.unlink(missing_ok=True)
            return _without(f"not filmed: the process with the camera {error}")
        return msgspec.json.decode(made, type=FilmResult | None) or _without("not filmed: it was interrupted")

    def _film_here(self, result: CaseResult) -> FilmResult:
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                return self._replay(result, inside(self._folder, f"{FOLDER}/{_file_name(result)}"))
        except Exception as error:
            return _without(f"not filmed: {type(error).__name__}: {text_of(error)}")

    def count(self, failed: Sequence[str]) -> None:
        """A failure of these requirements is filmed."""
        self._filmed.update(_film_subjects(failed))

    def _replay(self, result: CaseResult, path: Path) -> FilmResult:
        declared = self._settings.testbench.simulation.film
        assert declared is not None
        path.parent.mkdir(parents=True, exist_ok=True)
        film = video(path)
        try:
            film_run = FilmRun(declared, result, film, alarms_of(result, self._known))
            again = execute(self._settings, result.test, filming=film_run.roll)
            if film_run.recorder is None:
                raise TestbenchError("the testbench's run did not call run.go")
            film.finish()
            strip = path.with_name(path.name + ".png")
            with replace_file(strip) as part:
                film_run.recorder.strip().save(part, format="PNG")
        finally:
            film.discard()
        same = again.record.sha256 == result.record.sha256
        return FilmResult(
            video=f"{FOLDER}/{film.path.name}",
            strip=f"{FOLDER}/{strip.name}",
            seconds=round(film.frames / FRAMES_PER_S, 2),
            frames=film.frames,
            times_s=tuple(round(time_s, 3) for time_s in film_run.recorder.times_s),
            note="" if same else f"the replay differs from the run (record {again.record.sha256}): compare with care",
        )


def _file_name(result: CaseResult) -> str:
    """The name of a run's film, without the suffix."""
    return re.sub(r"[^A-Za-z0-9._-]", "_", result.test.id)


def _film_subjects(failed: Sequence[str]) -> Sequence[str]:
    """The requirements that a film counts for; without one, it counts for an assertion."""
    return failed or [""]


class FilmRun:
    """One run being filmed."""

    def __init__(self, film: Film, result: CaseResult, video: Video, alarms: Sequence[Alarm]) -> None:
        self._film = film
        self._result = result
        self._video = video
        self._alarms = alarms
        self.recorder: FilmRecorder | None = None

    @contextlib.contextmanager
    def roll(self, run: Run) -> Iterator[None]:
        """Context of the run: a camera in its world takes the pictures."""
        world = run.kernel.world
        if world is None:
            raise TestbenchError("a film needs a world: run.kernel.world is None")
        camera = self._film.camera(world)
        with contextlib.closing(camera):
            self.recorder = FilmRecorder(camera, self._plan(), run, self._film.state, self._alarms, self._video)
            run.kernel.world = FilmedWorld(world, self.recorder)
            self.recorder.take_picture(run.kernel.now_us)
            yield
            self.recorder.end(run.kernel.now_us)

    def _plan(self) -> Schedule:
        result = self._result
        violations_s = [alarm.time_s for alarm in self._alarms]
        first_s = violations_s[0] if violations_s else None
        moments = key_moments(self._film.moments, _events(result.record), first_s, result.sim_s)
        return schedule(moments, violations_s, result.sim_s, self._film.period_us)


def film_text(film: FilmResult, folder: Path) -> str:
    """The location of the film, for the text of a failing test."""
    lines = [f"film:  {folder / film.video}", f"strip: {folder / film.strip}"] if film.video and film.strip else []
    return "\n".join([*lines, *([film.note] if film.note else [])])


def _events(record: Record) -> list[tuple[float, str]]:
    """Messages, and signals when they become true, in the order of time."""
    messages = ((message.time_s, message.topic) for message in record.messages)
    signals = (
        (time_s, name)
        for name, (times, values) in record.signals.items()
        for time_s, value in zip(times, values, strict=True)
        if value == 1.0
    )
    return sorted(chain(messages, signals))


def alarms_of(result: CaseResult, known_violations: Container[str]) -> list[Alarm]:
    """The violations that a film of a run shows, in the order of time: the unknown ones, or else all."""
    unknown = list_undeclared_violations(result, known_violations)
    shown = set(unknown) & set(result.failed) or set(result.failed)
    alarms = [
        Alarm(violation.time_s, verdict.requirement, f"{verdict.requirement} {violation_line(violation, {})}")
        for verdict in result.verdicts
        for violation in verdict.violations
        if verdict.requirement in shown
    ]
    return sorted(alarms, key=lambda alarm: alarm.time_s)


def _without(note: str) -> FilmResult:
    return FilmResult(video=None, strip=None, seconds=None, frames=0, note=note)
