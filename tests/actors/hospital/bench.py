"""The world of the ward, its people, and the testbench."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from pytest_hricdv.testbench import (
    BeliefSpace,
    Concretization,
    CrossProduct,
    Disturbance,
    Drop,
    InteractiveAgent,
    Model,
    Outcome,
    People,
    Run,
    Testbench,
    Uniform,
    VirtualTime,
)
from tests.actors.hospital.robot import Answered, Door, Loaded, Seen, Sent, bring

HERE = Path(__file__).parent
STEP_US = 50_000
DOOR_M, LENGTH_M, SPEED_M_S = 2.0, 4.0, 0.5
LIMIT_S = 90.0
TAKES = {"takes_s": Uniform(0.2, 3.0, "s")}
ACTS = {
    "nurse": ("load", "send", "rest"),
    "porter": ("open", "close", "rest"),
    "child": ("peek", "go_away"),
}
COMMANDS = {f"{actor}: {act}": dict(TAKES) for actor, acts in ACTS.items() for act in acts}
CROSS = {
    "nurse and porter": CrossProduct(
        {"nurse": ("load", "send"), "porter": ("open", "close"), "first": ("nurse", "porter")}
    ),
    "nurse and child": CrossProduct({"nurse": ("load", "send"), "child": ACTS["child"], "first": ("nurse", "child")}),
    "child waits": CrossProduct({"child": ("go_away",), "porter": ("open", "close")}),
}


DISTURBANCES: dict[str, Disturbance | Drop] = {
    "draught": Disturbance({}, lambda ward, values: ward.door(False)),
    "unseen": Drop("seen"),
}
"""The door falls to; the sensor misses what comes next."""


class Ward:
    """A corridor with a door in the middle, which is closed at first, and the robot."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._sensor = run.bus.port("sensor")
        self._time_us = 0
        self._drives = self._is_open = False
        self.robot_m = 0.0
        self.observe()

    def advance(self, target_us: int) -> int:
        """Make one step, but not beyond `target_us`."""
        reached_us = min(self._time_us + STEP_US, target_us)
        if self._drives:
            self.robot_m += SPEED_M_S * (reached_us - self._time_us) / 1e6
        self._time_us = reached_us
        return reached_us

    def observe(self) -> None:
        """Record what requirements read."""
        recorder, time_s = self._run.recorder, self._time_us / 1e6
        recorder.signal(time_s, "open", self._is_open)
        recorder.signal(time_s, "passes", self._drives and abs(self.robot_m - DOOR_M) < 0.5)

    def door(self, is_open: bool) -> None:
        """The porter opens or closes the door."""
        self._is_open = is_open
        self._sensor.publish(Door(is_open))

    def seen(self, somebody: bool) -> None:
        """The child is in the way, or is not any more."""
        self._sensor.publish(Seen(somebody))

    def drive(self, on: bool) -> None:
        """See `Wheels`."""
        self._drives = on

    def is_there(self) -> bool:
        """See `Wheels`."""
        return self.robot_m >= LENGTH_M


def people(run: Run, ward: Ward) -> dict[str, Callable[[], None]]:
    """What each of them does with each of its actions."""
    port = run.bus.port("nurse")
    return {
        "load": lambda: port.publish(Loaded()),
        "send": lambda: port.publish(Sent()),
        "open": lambda: ward.door(True),
        "close": lambda: ward.door(False),
        "peek": lambda: ward.seen(True),
        "go_away": lambda: ward.seen(False),
        "rest": lambda: None,
    }


def running(looks_late: bool, actors: tuple[str, ...] = tuple(ACTS)) -> Callable[[Run], Outcome]:
    """A testbench's run, in which these people have nodes."""

    def run(run: Run) -> Outcome:
        ward = run.kernel.world = Ward(run)
        run.set_disturbance_target(ward)
        does = people(run, ward)

        def robot() -> None:
            bring(run.bus.port("robot"), ward, looks_late)
            run.kernel.stop("the robot is there")

        def person(actor: str) -> None:
            for action in run.actions(actor):
                does[action.command]()
                run.kernel.sleep(action.parameters["takes_s"])

        run.kernel.spawn("robot", run.measured(robot))
        for actor in actors:
            run.kernel.spawn(actor, lambda actor=actor: person(actor))  # type: ignore[misc]
        ended = run.go(limit_s=LIMIT_S)
        return Outcome(ended, cross=crossed(run))

    return run


def crossed(run: Run) -> dict[str, tuple[tuple[str, ...], ...]]:
    """The bins of `CROSS` that a run has hit."""
    hits = {
        "nurse and porter": run.order_bins("nurse", "porter"),
        "nurse and child": run.order_bins("nurse", "child"),
        "child waits": run.overlap_bins("child", "porter"),
    }
    bins = {name: set(product.bins()) for name, product in CROSS.items()}
    return {name: tuple(hit for hit in reported if hit in bins[name]) for name, reported in hits.items()}


def hospital(looks_late: bool = False, online: bool = False) -> Testbench:
    """The testbench; without `looks_late` the code has its fault, with `online` people decide during runs, too."""
    return Testbench(
        name="hospital",
        model=Model(HERE / "models" / "hospital.mas2j", actors=tuple(ACTS), covered=tuple(ACTS)),
        beliefs=BeliefSpace(
            start=("early", "late"),
            groups={
                "porter": ("tidy", "lazy"),
                "child": ("curious", "calm"),
            },
            default_beliefs=("lazy", "calm"),
        ),
        concretization=Concretization(commands=COMMANDS),
        requirements=HERE / "requirements.toml",
        messages=(Loaded, Sent, Door, Seen, Answered),
        signals={"open": bool, "passes": bool},
        cross=CROSS,
        disturbances=DISTURBANCES,
        code=("tests.actors.hospital.robot",),
        time=VirtualTime(apis=("asyncio", "threading"), allowed_endings=("limit", "cycle")),
        people=People(tuple(InteractiveAgent(actor, idle_timeout_s=5.0) for actor in ACTS) if online else ()),
        run=running(looks_late),
    )
