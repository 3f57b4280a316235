import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("libusb_package", "usb", "usb.core"), MagicMock()))


@dataclass(frozen=True)
class Motion:
    duration_s: float
    height_m: float


@dataclass(frozen=True)
class Asked:
    height_m: float


def pytest_hricdv_testbench(config):
    return Testbench(
        name="position_commander",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_flight", "two_flights"), groups={"flight": ("square", "stays", "returns")}),
        concretization=Concretization(commands={
            "stay": {"for_s": Uniform(0.1, 2.0, "s")}, **dict.fromkeys(("go_to here", "go_to low", "go_to aside"), {}),
            "up": {"m": Uniform(0.1, 0.5, "m")}, "forward": {"m": Uniform(0.1, 0.5, "m")}}),
        requirements=HERE / "requirements.toml",
        messages=(Motion, Asked),
        signals={"flies": bool},
        code=("cflib.positioning.position_hl_commander",),
        time=VirtualTime(apis=("time",), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from cflib.positioning.position_hl_commander import PositionHlCommander

    bus = run.bus.port("drone")

    def flies(value):
        run.recorder.signal(run.kernel.now_s, "flies", value)

    def takeoff(height, duration_s):
        flies(True)
        bus.publish(Motion(duration_s, height))

    firmware = SimpleNamespace(
        takeoff=takeoff, stop=lambda: flies(False), land=lambda height, duration_s: bus.publish(Motion(duration_s, height)),
        go_to=lambda x, y, z, yaw, duration_s: bus.publish(Motion(duration_s, z)))
    drone = SimpleNamespace(is_connected=lambda: True, high_level_commander=firmware,
                            param=SimpleNamespace(set_value=lambda name, value: None))
    flies(False)

    def program():
        with PositionHlCommander(drone, default_velocity=0.3, default_height=1.0) as flight:
            for action in run.actions():
                verb, _, where = action.command.partition(" ")
                if verb == "stay":
                    run.kernel.sleep(action.parameters["for_s"])
                elif verb == "go_to":
                    x, y, z = flight.get_position()
                    goal = {"here": (x, y, z), "low": (0.0, 0.0, 0.5), "aside": (0.5, 0.0, 1.0)}[where]
                    bus.publish(Asked(goal[2]))
                    flight.go_to(*goal)
                else:
                    getattr(flight, verb)(action.parameters["m"])
        run.kernel.sleep(1.0)
        run.kernel.stop("the program has ended")

    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=200.0))
