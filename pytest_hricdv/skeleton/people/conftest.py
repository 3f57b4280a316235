"""The testbench: connects the people's models, the world and the code under test."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from pytest_hricdv.testbench import (
    BeliefSpace,
    Concretization,
    Model,
    Outcome,
    Run,
    Testbench,
    Uniform,
    VirtualTime,
)

HERE = Path(__file__).parent
PEOPLE = ("my_person", "my_other")

# What each of them can do, with the ranges of the parameters.
ACTS = {
    "ask": {"after_s": Uniform(0.2, 2.0, "s")},
    "come_near": {"after_s": Uniform(0.2, 1.5, "s")},
    "go_away": {"after_s": Uniform(0.5, 3.0, "s")},
    "wait_done": {},
}


def pytest_hricdv_testbench(config: object) -> Testbench:
    """The testbench that the plugin runs."""
    from my_robot import Done, Request

    return Testbench(
        name="my_robot",
        model=Model(HERE / "models" / "my_robot.mas2j", actors=PEOPLE, covered=PEOPLE),
        # The beliefs that the people can have; learning finds out which of them matter.
        beliefs=BeliefSpace(
            start=("one_wish", "two_wishes"),
            groups={"manner": ("keeps_away", "comes_near")},
        ),
        # The people's commands say who acts.
        concretization=Concretization(
            commands={f"{name}: {act}": ranges for name in PEOPLE for act, ranges in ACTS.items()},
            run={"patience_s": Uniform(10.0, 15.0, "s")},
        ),
        requirements=HERE / "requirements.toml",
        messages=(Done, Request),
        signals={"arm_moves": bool, "person_near": bool},
        code=("my_robot",),
        # Python's blocking APIs that the code uses; they wait in virtual time.
        time=VirtualTime(apis=("time", "threading", "asyncio")),
        run=run,
    )


def run(run: Run) -> Outcome:
    """One test: people, the robot's code, and the world, in virtual time."""
    from my_robot import Done, Request, work
    from world import World

    world = World(run.recorder)
    run.kernel.world = world
    near: set[str] = set()

    def person(name: str) -> None:
        bus = run.bus.port(name)
        done = bus.subscribe(Done)
        for action in run.actions(name):
            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            if action.command == "ask":
                bus.publish(Request())
            elif action.command == "wait_done":
                done.wait(30.0)
            else:
                (near.add if action.command == "come_near" else near.discard)(name)
                world.near = bool(near)

    def robot() -> None:
        work(run.bus.port("my_robot"), world, float(run.test.run["patience_s"]))
        run.kernel.stop("nobody asks for anything any more")

    # `measured`: coverage counts what runs in here. It is first, so that it hears what people do at once.
    run.kernel.spawn("my_robot", run.measured(robot))
    for name in PEOPLE:
        run.kernel.spawn(name, partial(person, name))
    return Outcome(run.go(limit_s=300.0))
