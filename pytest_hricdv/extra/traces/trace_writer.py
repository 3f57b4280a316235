"""`TraceWriter`: writes the traces of `--hri-mcap` into the report's folder, in the process that ran the test.

`TracesFeature` calls it after a test. For the scene, it repeats the run with an `ObservedWorld`.
"""

from __future__ import annotations

import contextlib
import io
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from pytest_hricdv._base.contained import inside
from pytest_hricdv._base.error_text import text_of
from pytest_hricdv.execution.case import CaseResult, RunSettings, execute
from pytest_hricdv.extra.traces.records import FOLDER, SceneChange, TraceResult
from pytest_hricdv.registry import offers
from pytest_hricdv.results.model import TestResult
from pytest_hricdv.runtime.world import Body, World
from pytest_hricdv.testbench import Run

SCENE_PERIOD_US = 50_000
"""Period (us) at which shapes are sampled, twenty times a second: viewers play smoothly, and files stay small."""


class ObservedWorld:
    """A world whose shapes are sampled while it advances, without additional stops.

    Args:
        bodies: gives the shapes of the world now.
        period_us: minimum time between two samples (us).
    """

    def __init__(self, world: World, bodies: Callable[[Any], Sequence[Body]], period_us: int) -> None:
        self.changes: list[SceneChange] = []
        self._world = world
        self._bodies = bodies
        self._period_us = period_us
        self._next_us = 0
        self._last: dict[str, Body] = {}
        self.look(0)

    def advance(self, target_us: int) -> int:
        """See `runtime.World`."""
        reached_us = self._world.advance(target_us)
        if reached_us >= self._next_us:
            self.look(reached_us)
        return reached_us

    def observe(self) -> None:
        """See `runtime.World`."""
        self._world.observe()

    def look(self, time_us: int) -> None:
        """Record what changed since the last sample."""
        now = {body.name: body for body in self._bodies(self._world)}
        moved = tuple(body for name, body in now.items() if self._last.get(name) != body)
        gone = tuple(name for name in self._last if name not in now)
        if moved or gone:
            self.changes.append(SceneChange(time_us, moved, gone))
        self._last, self._next_us = now, time_us + self._period_us


def _stem(test: TestResult) -> str:
    return f"{FOLDER}/{re.sub(r'[^A-Za-z0-9._-]', '_', test.id)}"


class TraceWriter:
    """Writes the traces of one process.

    Args:
        settings: the settings of the session's runs.
        folder: the report's folder; traces go into a folder inside.
    """

    def __init__(self, settings: RunSettings, folder: Path) -> None:
        self._settings = settings
        self._testbench = settings.testbench
        self._folder = folder

    def trace(self, run: CaseResult, test: TestResult) -> TraceResult:
        """Write the trace of a run.

        Errors are written into its `note`: a failed test must be reported even when the disk is full.
        """
        from pytest_hricdv.extra.traces import mcap_trace  # its library is not needed by all

        name = f"{_stem(test)}.mcap"
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                scene, note = self._scene(run)
            mcap_trace.write(inside(self._folder, name), mcap_trace.McapTrace(test, run.record, self._testbench, scene))
            bag = self._write_bag(run, test)
        except Exception as error:
            return TraceResult(file=None, note=f"not written: {type(error).__name__}: {text_of(error)}")
        return TraceResult(file=name, note=note, bag=bag)

    def bag(self, run: CaseResult, test: TestResult) -> TraceResult | None:
        """Write the messages of ROS 2 of a run, if there are any; errors as from `trace`."""
        try:
            bag = self._write_bag(run, test)
        except Exception as error:
            return TraceResult(file=None, note=f"no bag was written: {type(error).__name__}: {text_of(error)}")
        return None if bag is None else TraceResult(file=None, bag=bag)

    def _write_bag(self, run: CaseResult, test: TestResult) -> str | None:
        name = f"{_stem(test)}.ros2.mcap"
        written = any(write(inside(self._folder, name), run.record) for write in offers("bag_writer", "write_bag"))
        return name if written else None

    def _scene(self, run: CaseResult) -> tuple[Sequence[SceneChange], str]:
        """The movement of the world's shapes, from a replay; nothing if the testbench does not provide it."""
        film = self._testbench.simulation.film
        bodies = film.bodies if film is not None else None
        if bodies is None:
            return (), ""
        observed: list[ObservedWorld] = []

        @contextlib.contextmanager
        def observe(again: Run) -> Iterator[None]:
            if again.kernel.world is not None:
                observed.append(ObservedWorld(again.kernel.world, bodies, SCENE_PERIOD_US))
                again.kernel.world = observed[0]
            yield

        again = execute(self._settings, run.test, filming=observe)
        same = again.record.sha256 == run.record.sha256
        note = "" if same else f"the scene is of a replay that differs from the run (record {again.record.sha256})"
        return observed[0].changes if observed else (), note
