"""The anchors as models for explorers of schedules, and what one of these tools finds; run by the tool's own Python.

    python studies/races/peer_models.py TOOL ASYNCIO    # prints JSON: model -> what the tool came to

ASYNCIO is the folder of Python 3.11's asyncio: what is wrong in it, later versions have repaired.
"""

from __future__ import annotations

import asyncio
import inspect
import json
import sys
import threading
import time
from collections.abc import Awaitable, Callable, Coroutine, Iterable, Iterator
from functools import partial
from importlib import import_module
from importlib.metadata import version
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

SEEDS = 20
RUNS = 100
"""At most, at each seed: as many as the search of a robot has."""

Outcome = tuple[bool, int]
"""Whether the tool found something, and the number of its run then, or of all its runs."""


class TwoPurses:
    """Each worker moves a coin."""

    workers = 2

    def __init__(self) -> None:
        self.left, self.right = 50, 50

    def serve(self, number: int) -> None:
        left = self.left
        self.left = left - 1
        right = self.right
        self.right = right + 1

    def holds(self) -> bool:
        return self.left + self.right == 100


class LazyCamera:
    """Each worker opens the camera, if nobody has."""

    workers = 2

    def __init__(self) -> None:
        self.camera: object = None
        self.opened: list[object] = []

    def serve(self, number: int) -> None:
        if self.camera is None:
            self.camera = object()
            self.opened.append(self.camera)

    def holds(self) -> bool:
        return len(self.opened) == 1


class SharedAddress:
    """Each worker sends a letter with its own address."""

    workers = 2

    def __init__(self) -> None:
        self.envelope: dict[str, int] = {}
        self.sent: list[tuple[int, int]] = []

    def serve(self, number: int) -> None:
        self.envelope["to"] = number
        letter = dict(self.envelope)
        self.sent.append((letter["to"], number))

    def holds(self) -> bool:
        return all(to == number for to, number in self.sent)


class GuestRooms:
    """Each worker is a guest of one room."""

    workers = 2

    def __init__(self) -> None:
        self.rooms: dict[str, dict[int, bool]] = {}

    def serve(self, number: int) -> None:
        if "blue" not in self.rooms:
            guests: dict[int, bool] = {}
            self.rooms["blue"] = guests
        self.rooms["blue"][number] = True

    def holds(self) -> bool:
        return len(self.rooms["blue"]) == 2


class OneTicket:
    """Each worker takes the ticket, if there is one."""

    workers = 2

    def __init__(self) -> None:
        self.drawer = ["ticket"]
        self.missing = False

    def serve(self, number: int) -> None:
        try:
            if self.drawer:
                self.drawer.pop()
        except IndexError:
            self.missing = True

    def holds(self) -> bool:
        return not self.missing


class TornPose:
    """One worker writes a pose, the other one reads it."""

    workers = 2

    def __init__(self) -> None:
        self.x = self.y = 0
        self.torn = False

    def serve(self, number: int) -> None:
        if number == 0:
            self.x = 1
            self.y = 1
        else:
            x = self.x
            self.torn = x != self.y

    def holds(self) -> bool:
        return not self.torn


class ThreeTools:
    """Each worker takes two of three tools."""

    workers = 3

    def __init__(self) -> None:
        self.tools = [threading.Lock() for _ in range(3)]

    def pair(self, number: int) -> tuple[int, int]:
        return number, (number + 1) % 3

    def serve(self, number: int) -> None:
        first, second = self.pair(number)
        with self.tools[first]:  # noqa: SIM117 (between the two is where it waits)
            with self.tools[second]:
                pass

    def holds(self) -> bool:
        return True


WaitFor = Callable[[Awaitable[Any], float], Coroutine[Any, Any, Any]]


async def swallowed_cancel(wait_for: WaitFor) -> None:
    """A drive is cancelled just before a tick comes."""
    ticks: asyncio.Queue[str] = asyncio.Queue()

    async def drive() -> None:
        while True:
            await wait_for(ticks.get(), 0.3)

    async def brake() -> None:
        driving.cancel()

    async def turn() -> None:
        ticks.put_nowait("tick")

    driving = asyncio.create_task(drive())
    await asyncio.sleep(0.1)
    await asyncio.gather(brake(), turn())
    await asyncio.sleep(0.1)
    assert driving.done(), "it drives on"


async def lost_notify(condition: Callable[[], Any], *, is_repaired: bool = False) -> None:
    """The first of two arms is cancelled just before a part is offered."""
    offered, parts = condition(), ["part"]

    async def arm() -> None:
        async with offered:
            try:
                await offered.wait()
            except asyncio.CancelledError:
                if is_repaired:
                    offered.notify()
                raise
            parts.pop()

    async def rest() -> None:
        first.cancel()

    async def offer() -> None:
        async with offered:
            offered.notify()

    first = asyncio.create_task(arm())
    await asyncio.sleep(0.1)
    second = asyncio.create_task(arm())
    await asyncio.sleep(0.1)
    await asyncio.gather(rest(), offer())
    await asyncio.sleep(0.1)
    is_left = bool(parts)
    second.cancel()
    assert not is_left, "nobody takes the part"


async def wait_well(awaitable: Awaitable[Any], time_s: float) -> Any:
    """What `wait_for` should be."""
    async with asyncio.timeout(time_s):
        return await awaitable


THREADS: dict[str, Any] = {
    "two_purses": TwoPurses,
    "lazy_camera": LazyCamera,
    "shared_address": SharedAddress,
    "guest_rooms": GuestRooms,
    "one_ticket": OneTicket,
    "torn_pose": TornPose,
    "three_tools": ThreeTools,
}
"""Anchors that have threads."""


def repair(model: Any) -> Any:
    """The model without its race: one lock around all, or locks taken in one order."""

    class Repaired(model):  # type: ignore[misc]
        def __init__(self) -> None:
            super().__init__()
            self.lock = threading.Lock()

        def serve(self, number: int) -> None:
            if model is ThreeTools:
                super().serve(number)
                return
            with self.lock:
                super().serve(number)

        def pair(self, number: int) -> tuple[int, int]:
            first, second = sorted((number, (number + 1) % 3))
            return first, second

    return Repaired


def explore_threads(model: Any, seed: int | None) -> Outcome:
    """What frontrun finds: at a seed with its random strategy, without one by going through all classes."""
    frontrun = import_module("frontrun")
    options = {} if seed is None else {"strategy": "random", "max_attempts": RUNS, "seed": seed}

    def worker(number: int) -> Callable[[Any], None]:
        return lambda state: state.serve(number)

    explored = frontrun.explore(
        setup=model,
        workers=[worker(number) for number in range(model.workers)],
        invariant=model.holds,
        reproduce_on_failure=0,
        **options,
    )
    return explored.property_holds is False, explored.num_explored


def explore_tasks(tool: str, race: Callable[[], Coroutine[Any, Any, None]], seed: int) -> Outcome:
    """What detangle or simloom finds at a seed."""
    if tool == "detangle":
        detangle = import_module("detangle")
        try:
            stats = detangle.explore(race, runs=RUNS, seed=seed, shrink=False, database=False)
        except detangle.BugFound as error:
            return True, int(error.report.runs)
        return False, stats.runs
    explored = import_module("simloom").explore(race, runs=RUNS, start_seed=seed * RUNS)
    return explored.failed, explored.runs


def old_asyncio(folder: Path) -> Iterator[ModuleType]:
    """Its modules `tasks` and `locks`, beside those of this Python."""
    for name in ("tasks", "locks"):
        spec = spec_from_file_location(f"asyncio.old_{name}", folder / f"{name}.py")
        assert spec is not None
        assert spec.loader is not None
        module = module_from_spec(spec)
        spec.loader.exec_module(module)
        yield module


def find(tool: str, folder: Path) -> dict[str, Any]:
    """Of each model: at which seeds it was found after how many runs, in what time, and how long the model is."""
    made: dict[str, Any] = {}

    def note(name: str, model: Any, explore: Callable[[Any], Outcome], seeds: Iterable[Any], twin: Outcome) -> None:
        began_s = time.process_time()
        found = [explore(seed) for seed in seeds]
        cpu_s = (time.process_time() - began_s) / len(found)
        lines = [line for line in inspect.getsource(model).splitlines() if line.strip() and '"""' not in line]
        made[name] = {"found": found, "cpu_s": round(cpu_s, 4), "lines": len(lines), "repaired": twin}

    if tool.startswith("frontrun"):
        is_random = tool.endswith("random")
        for name, model in THREADS.items():
            seeds = range(SEEDS) if is_random else [None]
            note(name, model, partial(explore_threads, model), seeds, explore_threads(repair(model), seeds[0]))
        return made
    tasks, locks = old_asyncio(folder)
    races: dict[Any, tuple[Callable[[], Any], Callable[[], Any]]] = {
        swallowed_cancel: (partial(swallowed_cancel, tasks.wait_for), partial(swallowed_cancel, wait_well)),
        lost_notify: (partial(lost_notify, locks.Condition), partial(lost_notify, locks.Condition, is_repaired=True)),
    }
    for model, (race, repaired) in races.items():
        twin = explore_tasks(tool, repaired, 0)
        note(model.__name__, model, partial(explore_tasks, tool, race), range(SEEDS), twin)
    return made


if __name__ == "__main__":
    package = sys.argv[1].partition("-")[0]
    print(json.dumps({"version": version(package), "models": find(sys.argv[1], Path(sys.argv[2]))}))
