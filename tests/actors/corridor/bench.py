"""The world of the corridor, its people, and the testbench."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from pytest_hricdv.testbench import (
    ActionMapping,
    BeliefSpace,
    Concretization,
    Film,
    Model,
    ModelOracle,
    Outcome,
    PerceptMapping,
    Run,
    Signal,
    Simulation,
    Suites,
    Testbench,
    Uniform,
    VirtualTime,
)
from tests.actors.corridor.cart import Arrived, Near, SendOn, deliver

HERE = Path(__file__).parent
STEP_US = 20_000
LENGTH_M = 10.0
SPEED_M_S = 0.5
IN_FRONT_M = 1.5
"""So far in front of the cart the child steps into its way; less than that is near."""
LIMIT_S = 200.0

COMMANDS = {
    "nurse: send_on": {"takes_s": Uniform(0.2, 2.0, "s")},
    "nurse: call_out": {"takes_s": Uniform(0.2, 2.0, "s")},
    "nurse: rest": {"takes_s": Uniform(0.5, 4.0, "s")},
    "child: step_in": {"takes_s": Uniform(0.5, 3.0, "s")},
    "child: step_out": {"takes_s": Uniform(0.2, 1.0, "s")},
    "child: wait": {"takes_s": Uniform(0.5, 6.0, "s")},
}


class Corridor:
    """A straight corridor with the cart, and where in it the child stands, if it does."""

    def __init__(self, run: Run) -> None:
        self._run = run
        self._sensor = run.bus.port("sensor")
        self._time_us = 0
        self._drives = False
        self.cart_m = 0.0
        self.child_m: float | None = None
        self.observe()

    def advance(self, target_us: int) -> int:
        """Make one step, but not beyond `target_us`."""
        reached_us = min(self._time_us + STEP_US, target_us)
        if self._drives:
            self.cart_m += SPEED_M_S * (reached_us - self._time_us) / 1e6
        self._time_us = reached_us
        return reached_us

    @property
    def gap_m(self) -> float:
        """From the cart to the child; the corridor's length where it is not in the way."""
        ahead = self.child_m is not None and self.child_m >= self.cart_m
        return self.child_m - self.cart_m if ahead and self.child_m is not None else LENGTH_M

    def observe(self) -> None:
        """Record what requirements read."""
        self._run.recorder.signal(self._time_us / 1e6, "moves", self._drives)
        self._run.recorder.signal(self._time_us / 1e6, "gap", self.gap_m)

    def step(self, into: bool) -> None:
        """The child steps into the way, or out of it; the sensor says so."""
        self.child_m = self.cart_m + IN_FRONT_M if into else None
        self._sensor.publish(Near(into))

    def drive(self, on: bool) -> None:
        """See `Wheels`."""
        self._drives = on

    def is_there(self) -> bool:
        """See `Wheels`."""
        return self.cart_m >= LENGTH_M


def nurse(run: Run, corridor: Corridor) -> None:
    """What the nurse does."""
    bus = run.bus.port("nurse")
    for action in run.actions("nurse"):
        if action.command == "send_on":
            bus.publish(SendOn())
        run.kernel.sleep(action.parameters["takes_s"])


def child(run: Run, corridor: Corridor) -> None:
    """What the child does; in the end it is called away."""
    for action in run.actions("child"):
        if action.command in ("step_in", "step_out"):
            corridor.step(action.command == "step_in")
        run.kernel.sleep(action.parameters["takes_s"])
    run.kernel.sleep(3.0)
    corridor.step(False)


People = tuple[Callable[[Run, Corridor], None], ...]


Hits = dict[str, tuple[tuple[str, ...], ...]]


def running(
    people: People = (nurse, child), obeys: bool = True, reports: Callable[[Run], Hits] = lambda run: {}
) -> Callable[[Run], Outcome]:
    """A testbench's run with these people; `reports` says which bins it has hit."""

    def run(run: Run) -> Outcome:
        corridor = Corridor(run)
        run.kernel.world = corridor
        run.set_disturbance_target(corridor)

        def cart() -> None:
            deliver(run.bus.port("cart"), corridor, obeys)
            run.kernel.stop("the cart is there")

        run.kernel.spawn("cart", run.measured(cart))  # first: it hears what people do at once
        for person in people:
            run.kernel.spawn(person.__name__, lambda person=person: person(run, corridor))  # type: ignore[misc]
        ended = run.go(limit_s=LIMIT_S)
        return Outcome(ended, cross=reports(run))

    return run


def ward(people: People = (nurse, child), obeys: bool = True) -> Testbench:
    """The testbench; with `obeys` the code has its fault."""
    return Testbench(
        name="corridor",
        model=Model(HERE / "models" / "ward.mas2j", actors=("nurse", "child"), covered=("nurse", "child")),
        beliefs=BeliefSpace(
            start=("playful", "shy"), groups={"nurse": ("hurried", "watchful", "patient")}, default_beliefs=("patient",)
        ),
        concretization=Concretization(commands=COMMANDS),
        requirements=HERE / "requirements.toml",
        suites=Suites(by_hand=HERE / "by_hand.toml"),
        messages=(Near, SendOn, Arrived),
        signals={"moves": bool, "gap": Signal(float, unit="m")},
        code=("tests.actors.corridor.cart",),
        time=VirtualTime(apis=("time",)),
        run=running(people, obeys),
    )


class Camera:
    """Looks at the corridor from above: the cart, and the child where it is in the way."""

    def __init__(self, corridor: Corridor) -> None:
        self._corridor = corridor

    def picture(self, *, fine: bool = False) -> Any:
        """A picture, as a film has it."""
        from PIL import Image, ImageDraw

        image = Image.new("RGB", (640, 160), (240, 240, 240))
        draw = ImageDraw.Draw(image)
        draw.rectangle((60 * self._corridor.cart_m, 60, 60 * self._corridor.cart_m + 30, 100), (40, 80, 160))
        if self._corridor.child_m is not None:
            draw.ellipse((60 * self._corridor.child_m, 65, 60 * self._corridor.child_m + 30, 95), (200, 60, 60))
        return image

    def close(self) -> None:
        """Nothing to release."""


def followed_ward(obeys: bool = True) -> Testbench:
    """The testbench with a film, and with the model's robot as an oracle."""
    made = ward(obeys=obeys)
    oracle = ModelOracle(
        agent="robot",
        percepts=(
            PerceptMapping("in_the_way", "on(near) & near.somebody"),
            PerceptMapping("free_again", "on(near) & !near.somebody"),
        ),
        actions=(ActionMapping("arrive", "on(arrived)", within_s=(0.0, 60.0)),),
    )
    film = Film(camera=Camera, moments={"steps in": "near", "sent on": "send_on"}, period_s=0.1)
    model = replace(made.model, path=HERE / "models" / "ward_with_robot.mas2j")
    return replace(made, oracle=oracle, simulation=Simulation(film=film), model=model)
