"""The testbench: connects the person's model, the world and the code under test."""

from __future__ import annotations

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


def pytest_hricdv_testbench(config: object) -> Testbench:
    """The testbench that the plugin runs."""
    from my_robot import Done, Request

    return Testbench(
        name="my_robot",
        model=Model(
            HERE / "models" / "my_robot.mas2j",
            actor="my_person",
            covered=("my_person",),
        ),
        # The beliefs that the person can have; learning finds out which of them matter.
        beliefs=BeliefSpace(
            start=("one_wish", "two_wishes"),
            groups={"manner": ("keeps_away", "comes_near")},
        ),
        # The person's commands, with the ranges of their parameters.
        concretization=Concretization(
            commands={
                "ask": {"after_s": Uniform(0.2, 2.0, "s")},
                "come_near": {"after_s": Uniform(0.2, 1.5, "s")},
                "go_away": {"after_s": Uniform(0.5, 3.0, "s")},
                "wait_done": {},
            },
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
    """One test: a person, the robot's code, and the world, in virtual time."""
    from my_robot import Done, Request, work
    from world import World

    world = World(run.recorder)
    run.kernel.world = world

    def person() -> None:
        bus = run.bus.port("my_person")
        done = bus.subscribe(Done)
        for action in run.actions():
            run.kernel.sleep(float(action.parameters.get("after_s", 0.0)))
            if action.command == "ask":
                bus.publish(Request())
            elif action.command == "wait_done":
                done.wait(30.0)
            else:
                world.near = action.command == "come_near"

    def robot() -> None:
        work(run.bus.port("my_robot"), world, float(run.test.run["patience_s"]))
        run.kernel.stop("nobody asks for anything any more")

    run.kernel.spawn("my_person", person)
    # `measured`: coverage counts what runs in here.
    run.kernel.spawn("my_robot", run.measured(robot))
    return Outcome(run.go(limit_s=300.0))
