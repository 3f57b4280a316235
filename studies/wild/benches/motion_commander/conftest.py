import sys
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import MagicMock

from pytest_hricdv.testbench import BeliefSpace, Concretization, Model, Outcome, Testbench, Uniform, VirtualTime

HERE = Path(__file__).parent
sys.modules.update(dict.fromkeys(("libusb_package", "usb", "usb.core"), MagicMock()))


@dataclass(frozen=True)
class Setpoint:
    height_m: float


@dataclass(frozen=True)
class LandAsked:
    """The program lands."""


@dataclass(frozen=True)
class Landed:
    """The call has returned."""


def pytest_hricdv_testbench(config):
    length = {"m": Uniform(0.1, 0.5, "m")}
    stay = {"for_s": Uniform(0.1, 2.0, "s")}
    return Testbench(
        name="motion_commander",
        model=Model(HERE / "bench.mas2j", actor="person", covered=("person",)),
        beliefs=BeliefSpace(start=("one_flight", "two_flights"),
                            groups={"flight": ("box", "low", "deep", "still", "drift", "double")}),
        concretization=Concretization(
            commands={"take_off": {}, "land": {}, "forward": length, "left": length, "down": {"m": Uniform(0.3, 0.3, "m")},
                      "start_forward": {}, "stay": stay},
        ),
        requirements=HERE / "requirements.toml",
        messages=(Setpoint, LandAsked, Landed),
        signals={"motors_on": bool, "sideways": float},
        code=("cflib.positioning.motion_commander",),
        time=VirtualTime(apis=("time", "threading"), allowed_endings=("early",)),
        run=run,
    )


def run(run):
    from cflib.positioning.motion_commander import MotionCommander

    bus = run.bus.port("drone")

    def record(motors_on, sideways):
        run.recorder.signal(run.kernel.now_s, "motors_on", motors_on)
        run.recorder.signal(run.kernel.now_s, "sideways", sideways)

    def hover(vx, vy, yaw_rate, z):
        bus.publish(Setpoint(z))
        record(True, abs(vx) + abs(vy))

    commander = SimpleNamespace(send_hover_setpoint=hover, send_stop_setpoint=lambda: record(False, 0.0),
                                send_notify_setpoint_stop=lambda: None)
    drone = SimpleNamespace(is_connected=lambda: True, commander=commander,
                            param=SimpleNamespace(set_value=lambda name, value: None))
    record(False, 0.0)

    def program():
        flight = MotionCommander(drone)
        for action in run.actions():
            if action.command == "stay":
                run.kernel.sleep(action.parameters["for_s"])
            elif action.command == "land":
                bus.publish(LandAsked())
                flight.land()
                bus.publish(Landed())
            elif action.command == "take_off" and flight._is_flying:
                try:
                    flight.take_off()
                except Exception as error:
                    assert str(error) == "Already flying"
            else:
                getattr(flight, action.command)(*action.parameters.values())
        run.kernel.sleep(2.0)
        run.kernel.stop("the program has ended")

    run.kernel.spawn("program", run.measured(program))
    return Outcome(run.go(limit_s=200.0))
