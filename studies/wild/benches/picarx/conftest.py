import importlib.util
import os
import sys
from pathlib import Path

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
PLACES = {"far": 80.0, "middle": 30.0, "near": 10.0, "nowhere": -1.0, "unplugged": -1.0}


def pytest_hricdv_testbench(config):
    os.getlogin = lambda: "pi"
    spec = importlib.util.spec_from_file_location("avoiding_obstacles", HERE / "src/picar-x/example/4.avoiding_obstacles.py")
    sys.modules["avoiding_obstacles"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(sys.modules["avoiding_obstacles"])
    return Testbench(
        name="picarx",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(
            start=("one_round", "two_rounds"), groups={"way": ("comes_near", "is_close", "walks_off", "cable_off")}
        ),
        concretization=Concretization(commands={f"stand {place}": {"for_s": Uniform(0.7, 3.0, "s")} for place in PLACES}),
        requirements=HERE / "requirements.toml",
        messages=(),
        signals={"speed": float, "is_near": bool, "is_blind": bool, "is_free": bool},
        code=("avoiding_obstacles", "picarx"),
        time=VirtualTime(apis=("time",)),
        run=run,
    )


def run(run):
    import robot_hat

    car = sys.modules["avoiding_obstacles"]
    world = robot_hat.world
    world.distance_cm, world.powers, world.direction, world.sleep = 80.0, {}, {}, run.kernel.sleep

    def record(**signals):
        for name, value in signals.items():
            run.recorder.signal(run.kernel.now_s, name, value)

    world.changed = lambda: record(speed=float(world.powers.get("P13", 0) * world.direction.get("D4", 1)))
    record(speed=0.0, is_near=False, is_blind=False, is_free=False)

    def person():
        for action in run.actions():
            place = action.command.partition(" ")[2]
            world.distance_cm = PLACES[place]
            record(is_near=place == "near", is_blind=place in ("nowhere", "unplugged"), is_free=place == "far")
            run.kernel.sleep(action.parameters["for_s"])
        run.kernel.stop("the person has left")

    run.kernel.spawn("car", run.measured(car.main))
    run.kernel.spawn("person", person)
    return Outcome(run.go(limit_s=120.0))
