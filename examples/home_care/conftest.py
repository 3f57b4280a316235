"""The testbench: the care robot in its flat, with a person who gives it orders, and a dog."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import pytest
    from carebot.bus import Bus

    from pytest_hricdv.testbench import Outcome, Run, Testbench

HERE = Path(__file__).parent
FAULTS = "CAREBOT_FAULTS"
"""Environment variable: published faults to switch on, such as `stop-on-either`; see `carebot.config.SWITCHES`."""

LIMIT_S = 7200.0
"""No run needs as long (chosen): a person who decides during the run has done 66 things in one, which took 2,600 s."""


def pytest_hricdv_testbench(config: pytest.Config) -> Testbench:
    """Hands the testbench over. Imports stay inside: a run without a suite pays for none of this."""
    import observer
    from carebot.messages import SAID, Order
    from carebot.tasks import STATES, transitions
    from crosses import CROSS
    from disturbances import DISTURBANCES
    from house import house
    from house.fidelity import ENGINES, FILM, TOLERANCES
    from people.beliefs import BELIEFS, LENGTHS, MODEL
    from people.coupling import ONLINE, ORACLE
    from people.dog import DogCalled, bystanders
    from people.ranges import COMMANDS, RUN

    from pytest_hricdv.testbench import (
        Concretization,
        Field,
        People,
        Signal,
        Simulation,
        StateField,
        Suites,
        Testbench,
        Uniform,
        VirtualTime,
    )

    units = {**house.UNITS, **observer.UNITS}
    return Testbench(
        name="home-care",
        model=MODEL,
        beliefs=BELIEFS,
        suites=Suites(by_hand=HERE / "tests" / "by_hand.toml", random_test_length=LENGTHS),
        people=People(agents=(ONLINE,), bystanders=bystanders()),
        disturbances=DISTURBANCES,
        concretization=Concretization(COMMANDS, {**RUN, "battery": Uniform(0.19, 1.0)}),
        requirements=HERE / "tests" / "requirements.toml",
        messages=(Order, *SAID, DogCalled),
        signals={
            name: Signal(kind, units.get(name, ""), house.VALUES.get(name, ()))
            for name, kind in {**house.SIGNALS, **observer.SIGNALS}.items()
        },
        fields={"state.name": Field(values=STATES)},
        state=StateField("state.name", transitions()),
        code=("carebot",),
        time=VirtualTime(apis=("asyncio",)),
        run=run,
        simulation=Simulation(engines=ENGINES, engine_tolerances=TOLERANCES, film=FILM),
        oracle=ORACLE,
        outcome_label="orders",
        cross=CROSS,
    )


def run(run: Run) -> Outcome:
    """Runs one test: the real robot's code in the simulated flat."""
    from bridge import spawn_robot
    from carebot.config import Config, faults
    from carebot.robot import Carebot
    from crosses import bins, served
    from disturbances import Flat
    from house.fidelity import new_mechanics
    from house.house import House
    from observer import Observer
    from people.dog import spawn_dog
    from people.person import spawn_person

    from pytest_hricdv.testbench import Outcome

    mechanics, battery = new_mechanics(run.engine), float(run.test.run["battery"])
    house = House(run.kernel, run.recorder, run.test.seed, mechanics, battery)
    run.kernel.world = house
    run.set_disturbance_target(Flat(run.kernel, house))

    async def program(bus: Bus) -> None:
        config = Config(faults=faults(os.environ.get(FAULTS, "")))
        await Carebot(bus, house, house.gripper_port, house.battery_port, config).run()

    spawn_robot(run, program)  # first: it hears what people do at once
    observer = Observer(run, house)
    run.kernel.spawn("observer", observer.watch)
    spawn_person(run, house)
    spawn_dog(run, house)
    ended = run.go(LIMIT_S)
    messages = run.recorder.messages
    outcomes = tuple(order.end for order in served(messages))
    cross = bins(messages, observer.dog_met_s)
    return Outcome(ended, outcomes, house.skipped_us / 1e6, cross, run.fidelity)
